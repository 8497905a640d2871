// The rooms in 3D: orbit, walk, cut; faces look inward, so that those in front of the room are not drawn.
"use strict";
(() => {
  const stage = document.getElementById("stage");
  const canvas = stage.querySelector("canvas");
  const overlay = stage.querySelector(".labels");
  const $ = (id) => document.getElementById(id);
  let renderer;
  try {
    // The buffer is kept, so that the page prints with the picture in it.
    renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
  } catch {
    stage.classList.add("flat");
    $("says").textContent = "This browser cannot draw in 3D (no WebGL); plan and tables below are complete.";
    return;
  }
  const EYE_M = 1.6;
  const corners = report.faces.flatMap((face) => face.edges).flat();
  const range = (k) => [Math.min(...corners.map((c) => c[k])), Math.max(...corners.map((c) => c[k]))];
  const [[x0, x1], [low, high], [z0, z1]] = [range(0), range(1), range(2)];
  const middle = new THREE.Vector3((x0 + x1) / 2, (low + high) / 2, (z0 + z1) / 2);
  const size = Math.hypot(x1 - x0, high - low, z1 - z0);

  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(45, 1, 0.02, 20 * size);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enableDamping = false;
  controls.maxDistance = 6 * size;
  controls.minDistance = 0.2;
  const cut = new THREE.Plane(new THREE.Vector3(0, -1, 0), high + 1);
  renderer.clippingPlanes = [cut];

  let asked = false;
  function draw() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      renderer.render(scene, camera);
      placeLabels();
    });
  }

  // ---- faces -------------------------------------------------------------------------------------------
  const loader = new THREE.TextureLoader();
  const maps = {};
  for (const [name, source] of Object.entries(report.images)) {
    maps[name] = loader.load(source, draw);
    maps[name].colorSpace = THREE.SRGBColorSpace;
    maps[name].anisotropy = renderer.capabilities.getMaxAnisotropy();
  }
  const lineMaterial = new THREE.LineBasicMaterial({ color: 0x59636c, transparent: true, opacity: 0.55 });
  const faces = report.faces.map((face) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(face.position, 3));
    geometry.setIndex(face.index);
    if (face.uv) geometry.setAttribute("uv", new THREE.Float32BufferAttribute(face.uv, 2));
    const material = new THREE.MeshBasicMaterial({ side: THREE.FrontSide, polygonOffset: true });
    material.polygonOffsetFactor = material.polygonOffsetUnits = 1;
    const mesh = new THREE.Mesh(geometry, material);
    const glow = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({
      color: 0xff8a1e, transparent: true, opacity: 0.55, side: THREE.DoubleSide, depthWrite: false,
    }));
    glow.visible = false;
    scene.add(mesh, glow);
    const ends = face.edges.flatMap((ring) => ring.flatMap((c, k) => [...c, ...ring[(k + 1) % ring.length]]));
    const outline = new THREE.BufferGeometry();
    outline.setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
    scene.add(new THREE.LineSegments(outline, lineMaterial));
    const normal = new THREE.Vector3(...face.normal);
    const centre = new THREE.Vector3(...face.centre);
    mesh.userData = { face };
    return { face, mesh, glow, normal, centre };
  });
  function dress(textured) {
    for (const { face, mesh } of faces) {
      mesh.material.map = textured && face.image ? maps[face.image] : null;
      mesh.material.color.set(mesh.material.map ? "#ffffff" : face.colour);
      mesh.material.needsUpdate = true;
    }
    draw();
  }

  // ---- dimensions --------------------------------------------------------------------------------------
  const lines = new THREE.Group();
  const bars = [];
  scene.add(lines);
  const UP = new THREE.Vector3(0, 1, 0);
  function ticked(a, b) {
    // A short stroke across each end, level for upright lines.
    const along = b.clone().sub(a).normalize();
    const across = Math.abs(along.y) > 0.9 ? new THREE.Vector3(1, 0, 0) : along.clone().cross(UP).normalize();
    const t = across.multiplyScalar(0.012 * size);
    return [a, b, a.clone().sub(t), a.clone().add(t), b.clone().sub(t), b.clone().add(t)].flatMap((p) => p.toArray());
  }
  const labels = [];
  /** A text at the first of several places that is free. */
  function label(className, text, shows, places, seen) {
    const element = document.createElement("span");
    element.className = className;
    element.textContent = text;
    element.dataset.shows = shows;
    element.addEventListener("click", () => selection.toggle(shows.split(" ")[0]));
    overlay.append(element);
    labels.push({ element, places, seen, ids: shows.split(" "), width: 0, height: 0 });
  }
  const spans = new Map();
  for (const d of report.dimensions) {
    const key = JSON.stringify([d.from, d.to]);
    if (!spans.has(key)) spans.set(key, []);
    spans.get(key).push(d);
  }
  const lineColour = { observed: 0x1273d1, inferred: 0xc0600f };
  const longest = (group) => Math.hypot(...group[0].from.map((c, k) => c - group[0].to[k]));
  for (const group of [...spans.values()].sort((p, q) => longest(q) - longest(p))) {
    const [a, b] = [new THREE.Vector3(...group[0].from), new THREE.Vector3(...group[0].to)];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(ticked(a, b), 3));
    const colour = lineColour[group[0].inferred ? "inferred" : "observed"];
    const line = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour }));
    const bar = new THREE.Mesh(
      new THREE.CylinderGeometry(0.0025 * size, 0.0025 * size, a.distanceTo(b), 12),
      new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true }),
    );
    bar.position.copy(a).add(b).multiplyScalar(0.5);
    bar.quaternion.setFromUnitVectors(UP, b.clone().sub(a).normalize());
    bar.renderOrder = 2;
    bar.visible = false;
    const ids = group.map((d) => d.id);
    bar.userData.ids = ids;
    lines.add(line, bar);
    bars.push(bar);
    const places = [0.5, 0.33, 0.67, 0.2, 0.8].map((share) => a.clone().lerp(b, share));
    label("dimension", `${ids.join(", ")}  ${group[0].text}`, ids.join(" "), places, () => lines.visible);
  }
  const back = new THREE.Vector3();
  for (const { face, centre, normal } of faces) {
    // Dimensions run at half height and over the middle, so names go nearer to the corners of their face.
    const inner = (share) => face.edges[0].map((c) => centre.clone().lerp(new THREE.Vector3(...c), share));
    const high = (p, q) => q.y - p.y;
    label("name", face.id, face.id, [...inner(0.5).sort(high), centre, ...inner(0.75).sort(high)], () =>
      $("names").checked && back.copy(camera.position).sub(centre).dot(normal) > 0);
  }
  const measure = () => labels.forEach((l) => {
    l.element.style.display = "block";
    [l.width, l.height] = [l.element.offsetWidth, l.element.offsetHeight];
  });
  const spot = new THREE.Vector3();
  // Pixels around every label. One room has some 20 labels and needs no more than that they do not touch; in a
  // storey they would cover the picture, so fewer are shown with more room, and zooming in brings the rest.
  const apart = Math.min(Math.max(labels.length / 8, 3), 20);
  function placeLabels() {
    const taken = [];
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    // What is selected comes first, then long dimensions, then names; what would lie over another is left out.
    const order = [...labels].sort((a, b) => b.ids.includes(selection.id) - a.ids.includes(selection.id));
    for (const l of order) {
      const shown = l.seen() && l.places.some((at) => {
        spot.copy(at).project(camera);
        if (spot.z >= 1 || at.y > cut.constant) return false;
        const [x, y] = [(0.5 + 0.5 * spot.x) * width, (0.5 - 0.5 * spot.y) * height];
        const [half, tall] = [l.width / 2 + apart, l.height / 2 + apart / 1.5];
        const box = [x - half, y - tall, x + half, y + tall];
        if (box[0] < 0 || box[1] < 0 || box[2] > width || box[3] > height) return false;
        if (taken.some((t) => box[0] < t[2] && t[0] < box[2] && box[1] < t[3] && t[1] < box[3])) return false;
        taken.push(box);
        return true;
      });
      l.element.style.display = shown ? "block" : "none";
      if (!shown) continue;
      // In shares of the stage, so that they stay in place when it is printed at another size.
      l.element.style.left = `${50 + 50 * spot.x}%`;
      l.element.style.top = `${50 - 50 * spot.y}%`;
    }
  }

  // ---- the observer ------------------------------------------------------------------------------------
  let walking = false;
  let untouched = true;
  let yaw = 0;
  let pitch = 0;
  function overview() {
    const direction = new THREE.Vector3(-0.45, 0.95, 0.65).normalize();
    // In the middle of the picture and as near as all corners allow; each round halves what is left, and more.
    controls.target.copy(middle);
    let away = size;
    for (let round = 0; round < 12; round += 1) {
      camera.position.copy(controls.target).addScaledVector(direction, away);
      controls.update();
      camera.updateMatrixWorld();
      const seen = corners.map((c) => new THREE.Vector3(...c).project(camera));
      const ends = (k) => [Math.min(...seen.map((p) => p[k])), Math.max(...seen.map((p) => p[k]))];
      const [[left, right], [bottom, top]] = [ends("x"), ends("y")];
      const half = Math.tan((Math.PI * camera.fov) / 360) * away;
      const side = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
      const over = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
      controls.target.addScaledVector(side, 0.25 * (left + right) * half * camera.aspect);
      controls.target.addScaledVector(over, 0.25 * (bottom + top) * half);
      away *= 0.5 + 0.25 * Math.max(right - left, top - bottom) / 0.92;
    }
    camera.position.copy(controls.target).addScaledVector(direction, away);
    controls.update();
    draw();
  }
  function look() {
    const ahead = new THREE.Vector3(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), -Math.cos(yaw) * Math.cos(pitch));
    camera.lookAt(ahead.add(camera.position));
    draw();
  }
  function stand(x, floor, z) {
    camera.position.set(x, Math.min(floor + EYE_M, high - 0.1), z);
    look();
  }
  function setMode(walk) {
    walking = walk;
    untouched = !walk;
    controls.enabled = !walk;
    $("orbit").setAttribute("aria-pressed", String(!walk));
    $("walk").setAttribute("aria-pressed", String(walk));
    camera.fov = walk ? 70 : 45;
    // From a step away a bar would hide what it measures.
    bars.forEach((bar) => bar.scale.set(walk ? 0.25 : 1, 1, walk ? 0.25 : 1));
    camera.updateProjectionMatrix();
    if (!walk) return overview();
    const [x, floor, z] = report.start;
    [yaw, pitch] = [Math.atan2(middle.x - x, z - middle.z), 0];
    stand(x, floor, z);
  }
  const TURN = 0.08;
  const keys = {
    ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
    a: [-1, 0], d: [1, 0], w: [0, 1], s: [0, -1],
  };
  function step(forward, aside) {
    const [s, c] = [Math.sin(yaw), Math.cos(yaw)];
    const inside = (v, a, b) => Math.min(Math.max(v, a + 0.1), b - 0.1);
    camera.position.x = inside(camera.position.x + s * forward + c * aside, x0, x1);
    camera.position.z = inside(camera.position.z - c * forward + s * aside, z0, z1);
    look();
  }
  function orbit(aside, up) {
    const arm = new THREE.Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    arm.theta += TURN * aside;
    arm.phi = Math.min(Math.max(arm.phi - TURN * up, 0.01), Math.PI - 0.01);
    camera.position.setFromSpherical(arm).add(controls.target);
    controls.update();
    draw();
  }
  function zoom(factor) {
    camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
    controls.update();
    draw();
  }
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const move = keys[key];
    if (move && walking) {
      if (key.startsWith("Arrow") && move[0]) { yaw += TURN * move[0]; look(); }
      else step(0.2 * move[1], 0.2 * move[0]);
    } else if (move) orbit(...move);
    else if (!walking && (key === "+" || key === "=")) zoom(0.9);
    else if (!walking && key === "-") zoom(1 / 0.9);
    else if (key === "Home") setMode(walking);
    else return;
    event.preventDefault();
  });

  // ---- pointer: drag to look around while walking; a click selects a face, or walks to a place of the floor -----
  const ray = new THREE.Raycaster();
  function faceAt(event) {
    const box = canvas.getBoundingClientRect();
    const at = new THREE.Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    ray.setFromCamera(at, camera);
    return ray.intersectObjects(faces.map((f) => f.mesh)).find((hit) => hit.point.y <= cut.constant);
  }
  let down = null;
  canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY, event.clientX, event.clientY]; });
  canvas.addEventListener("pointermove", (event) => {
    if (!down || !walking) return;
    yaw -= 0.005 * (event.clientX - down[2]);
    pitch = Math.min(Math.max(pitch + 0.005 * (event.clientY - down[3]), -1.4), 1.4);
    [down[2], down[3]] = [event.clientX, event.clientY];
    look();
  });
  addEventListener("pointerup", (event) => {
    const click = down && event.target === canvas && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5;
    down = null;
    const hit = click && faceAt(event);
    if (!hit) return;
    const face = hit.object.userData.face;
    if (walking && face.kind === "floor") stand(hit.point.x, hit.point.y, hit.point.z);
    else selection.toggle(face.id);
  });
  addEventListener("pointercancel", () => { down = null; });

  // ---- tools -------------------------------------------------------------------------------------------
  $("orbit").addEventListener("click", () => setMode(false));
  $("walk").addEventListener("click", () => setMode(true));
  $("home").addEventListener("click", () => setMode(walking));
  $("textures").addEventListener("change", (event) => dress(event.target.checked));
  $("lengths").addEventListener("change", (event) => { lines.visible = event.target.checked; draw(); });
  $("names").addEventListener("change", draw);
  const slider = $("cut");
  const cutAt = () => {
    const share = Number(slider.value) / 100;
    cut.constant = share >= 1 ? high + 1 : low + 0.02 + share * (high - low);
    const text = share >= 1 ? "not cut" : `${(cut.constant - low).toFixed(2)} m above the floor`;
    slider.setAttribute("aria-valuetext", text);
    $("cut-says").textContent = text;
    draw();
  };
  slider.addEventListener("input", cutAt);

  selection.listeners.push(() => {
    const lit = selection.lit();
    faces.forEach(({ face, glow }) => { glow.visible = lit.has(face.id); });
    bars.forEach((bar) => { bar.visible = bar.userData.ids.includes(selection.id); });
    draw();
  });
  controls.addEventListener("change", draw);
  function fit() {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    measure();
    // Turning a phone shows the whole again; a view that somebody chose stays.
    if (untouched) overview();
    draw();
  }
  controls.addEventListener("start", () => { untouched = false; });
  canvas.addEventListener("keydown", () => { untouched = false; });
  fit();
  new ResizeObserver(fit).observe(canvas);
  dress(true);
  cutAt();
})();
