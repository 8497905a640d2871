"""Every format read back by someone else: same body, same faces, same place."""

import json
import os
import re
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from rooms import BOX, FLAT, L_ROOM, PILLAR, RAGGED, U_ROOM, X_ROOM, make_result, plan_area_m2

from indoorfit.errors import OutputError
from indoorfit.export import write_dimensions_csv, write_glb, write_obj, write_vrml
from indoorfit.model import FitResult, Frame

HOUSES = {
    "box": (BOX,),
    "l": (L_ROOM,),
    "u": (U_ROOM,),
    "x": (X_ROOM,),
    "ragged": (RAGGED,),
    "pillar": (PILLAR,),
    "flat": FLAT,
}
WRITERS = {"glb": write_glb, "wrl": write_vrml, "obj": write_obj, "csv": write_dimensions_csv}

# Vertices are within 10 m of the origin: half a unit in the last place of float32 is 5e-7 m, and a
# volume of 30 m³ or more moves by its surface (90 m² at most per 30 m³) times a mean of those.
FLOAT32_VOLUME = 1e-6


@pytest.fixture(params=HOUSES, scope="module")
def house(request):
    plans = HOUSES[request.param]
    volume_m3 = sum(plan_area_m2(plan) * (plan.z_m[1] - plan.z_m[0]) for plan in plans)
    return make_result(*plans), volume_m3


def body(vertices_m: np.ndarray, triangles: np.ndarray) -> trimesh.Trimesh:
    """One mesh with equal corners joined."""
    mesh = trimesh.Trimesh(vertices_m, triangles, process=False)
    mesh.merge_vertices(digits_vertex=6)
    return mesh


def read_glb_tree(path: Path) -> dict:
    content = path.read_bytes()
    (length,) = struct.unpack("<I", content[12:16])
    return json.loads(content[20 : 20 + length])


def test_glb_holds_the_closed_body_facing_inward(house, tmp_path):
    result, volume_m3 = house
    write_glb(tmp_path / "model.glb", result)
    scene = trimesh.load_scene(tmp_path / "model.glb")
    mesh = scene.to_mesh()
    joined = body(mesh.vertices, mesh.faces)
    assert joined.is_watertight
    assert joined.volume == pytest.approx(-volume_m3, rel=FLOAT32_VOLUME)


def test_glb_names_one_node_per_face_below_its_room(house, tmp_path):
    result, _ = house
    write_glb(tmp_path / "model.glb", result)
    tree = read_glb_tree(tmp_path / "model.glb")
    nodes = tree["nodes"]
    rooms = {node["name"]: node["children"] for node in nodes if "children" in node and "mesh" not in node}
    for room in result.rooms:
        names = {nodes[child]["name"] for child in rooms[room.id]}
        assert names == {face.id for face in result.faces if face.room == room.id}
    assert not any(material["doubleSided"] for material in tree["materials"])


def test_glb_transform_leads_back_to_the_scan_frame(house, tmp_path):
    result, _ = house
    write_glb(tmp_path / "model.glb", result)
    transform = np.array(read_glb_tree(tmp_path / "model.glb")["asset"]["extras"]["T_scan_gltf"])
    scene = trimesh.load_scene(tmp_path / "model.glb")
    for face in result.faces:
        corners = scene.geometry[face.id].vertices @ transform[:3, :3].T + transform[:3, 3]
        given = np.concatenate(face.rings_m)
        gaps = np.linalg.norm(corners[:, None] - given[None], axis=-1)
        # float32 of coordinates below 16 m: 5e-7 m per axis, and float64 at 5e6 m: 1e-9 m.
        assert gaps.min(axis=1).max() < 1e-6
        assert gaps.min(axis=0).max() < 1e-6


def test_glb_is_y_up(tmp_path):
    result = make_result(L_ROOM)
    write_glb(tmp_path / "model.glb", result)
    mesh = trimesh.load_scene(tmp_path / "model.glb").geometry["floor-1"]
    np.testing.assert_allclose(mesh.vertices[:, 1], -1.3, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(mesh.vertex_normals, np.tile([0.0, 1.0, 0.0], (6, 1)), rtol=0.0, atol=1e-6)


def test_obj_holds_the_closed_body_in_the_scan_frame(house, tmp_path):
    result, volume_m3 = house
    write_obj(tmp_path / "model.obj", result)
    vertices_m, _, groups = parse_obj(tmp_path / "model.obj")
    triangles = np.array([corner[:3] for faces in groups.values() for corner in faces])
    joined = body(vertices_m - result.frame.origin_scan_m, triangles)
    assert joined.is_watertight
    # float64 at 5e6 m leaves 1e-9 m per coordinate: 1e-9 m times the surface over the volume.
    assert joined.volume == pytest.approx(-volume_m3, rel=1e-8)
    np.testing.assert_array_equal(vertices_m, np.concatenate([mesh.vertices_m for mesh in result.meshes]))


def test_obj_groups_are_the_faces_with_their_normals(house, tmp_path):
    result, _ = house
    write_obj(tmp_path / "model.obj", result)
    vertices_m, normals, groups = parse_obj(tmp_path / "model.obj")
    assert list(groups) == [face.id for face in result.faces]
    for face in result.faces:
        for a, b, c, normal in groups[face.id]:
            np.testing.assert_array_equal(normals[normal], face.normal)
            across = np.cross(vertices_m[b] - vertices_m[a], vertices_m[c] - vertices_m[a])
            assert across @ face.normal > 0.0


def test_obj_loads_in_trimesh_with_its_materials(tmp_path):
    result = make_result(L_ROOM)
    write_obj(tmp_path / "model.obj", result)
    mesh = trimesh.load_mesh(tmp_path / "model.obj")
    assert len(mesh.faces) == len(result.meshes[0].triangles)
    used = set(re.findall(r"^usemtl (\S+)$", (tmp_path / "model.obj").read_text(), re.M))
    defined = set(re.findall(r"^newmtl (\S+)$", (tmp_path / "model.mtl").read_text(), re.M))
    assert used == defined


def parse_obj(path: Path):
    vertices, normals, groups = [], [], {}
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word == "v":
            vertices.append([float(x) for x in rest])
        elif word == "vn":
            normals.append([float(x) for x in rest])
        elif word == "g":
            current = groups.setdefault(rest[0], [])
        elif word == "f":
            corners = [tuple(int(x) - 1 for x in corner.split("//")) for corner in rest]
            assert len({normal for _, normal in corners}) == 1
            current.append((*(vertex for vertex, _ in corners), corners[0][1]))
    return np.array(vertices), np.array(normals), groups


def test_vrml_holds_the_closed_body_in_the_scan_frame(house, tmp_path):
    result, volume_m3 = house
    write_vrml(tmp_path / "model.wrl", result)
    offset_m, shapes = parse_vrml((tmp_path / "model.wrl").read_text())
    np.testing.assert_array_equal(offset_m, result.frame.origin_scan_m)
    assert list(shapes) == [face.id for face in result.faces]
    vertices, triangles, n = [], [], 0
    for points, indices in shapes.values():
        vertices.append(points)
        triangles.append(indices + n)
        n += len(points)
    joined = body(np.concatenate(vertices), np.concatenate(triangles))
    assert joined.is_watertight
    assert joined.volume == pytest.approx(-volume_m3, rel=1e-8)
    for face in result.faces:
        points, indices = shapes[face.id]
        # Adding the offset rounds once at 5e6 m.
        gaps = np.linalg.norm((points + offset_m)[:, None] - np.concatenate(face.rings_m), axis=-1)
        assert gaps.min(axis=1).max() < 4e-9
        a, b, c = points[indices[:, 0]], points[indices[:, 1]], points[indices[:, 2]]
        assert (np.cross(b - a, c - a) @ face.normal > 0.0).all()


def parse_vrml(text: str):
    """A small reader of the grammar's annex A: tokens, then nested nodes and lists."""
    assert text.startswith("#VRML V2.0 utf8\n")
    tokens = re.findall(r'"(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"]+', text.split("\n", 1)[1])
    depth: list[str] = []
    for token in tokens:
        if token in "{[":
            depth.append(token)
        elif token in "}]":
            assert depth.pop() == {"}": "{", "]": "["}[token]
    assert not depth
    at = tokens.index("translation")
    offset_m = np.array([float(x) for x in tokens[at + 1 : at + 4]])
    shapes = {}
    starts = [k for k, token in enumerate(tokens) if token == "Shape"]
    for start, end in zip(starts, [*starts[1:], len(tokens)], strict=True):
        assert tokens[start - 2] == "DEF"
        block = tokens[start:end]
        for field, value in (("ccw", "TRUE"), ("solid", "TRUE"), ("convex", "TRUE")):
            assert block[block.index(field) + 1] == value
        points = np.array(numbers_after(block, "point")).reshape(-1, 3)
        indices = np.array(numbers_after(block, "coordIndex")).reshape(-1, 4).astype(int)
        assert (indices[:, 3] == -1).all()
        shapes[tokens[start - 1]] = (points, indices[:, :3])
    return offset_m, shapes


def numbers_after(tokens: list[str], field: str) -> list[float]:
    start = tokens.index(field) + 2
    return [float(token) for token in tokens[start : tokens.index("]", start)]]


def test_vrml_world_info_lists_every_dimension(house, tmp_path):
    result, _ = house
    write_vrml(tmp_path / "model.wrl", result)
    info = (tmp_path / "model.wrl").read_text().split("info [")[1].split("]")[0]
    assert re.findall(r'^\s*"(\w+):', info, re.M) == [d.id for d in result.dimensions]


def test_names_cannot_break_the_text_formats(tmp_path):
    result = make_result(BOX)
    names = {face.id: f'{k} "a] {{ }}\nb#' for k, face in enumerate(result.faces)}
    faces = tuple(replace(face, id=names[face.id]) for face in result.faces)
    mesh = replace(result.meshes[0], face_ids=tuple(names[name] for name in result.meshes[0].face_ids))
    dimensions = tuple(replace(d, faces=(names[d.faces[0]], names[d.faces[1]])) for d in result.dimensions)
    nasty = replace(result, faces=faces, meshes=(mesh,), dimensions=dimensions)
    write_vrml(tmp_path / "model.wrl", nasty)
    _, shapes = parse_vrml((tmp_path / "model.wrl").read_text())
    assert len(shapes) == len(faces)
    write_obj(tmp_path / "model.obj", nasty)
    assert len(parse_obj(tmp_path / "model.obj")[2]) == len(faces)


@pytest.mark.parametrize("suffix", WRITERS)
def test_files_are_the_same_bytes_every_time(suffix, tmp_path):
    for name in ("a", "b"):
        WRITERS[suffix](tmp_path / f"{name}.{suffix}", make_result(*FLAT))
    first, second = ((tmp_path / f"{name}.{suffix}").read_bytes() for name in ("a", "b"))
    assert first.replace(b"mtllib a", b"mtllib b") == second


def test_glb_bytes_do_not_depend_on_the_hash_seed(tmp_path):
    script = (
        "import sys; from pathlib import Path; from rooms import FLAT, make_result; "
        "from indoorfit.export import write_glb; write_glb(Path(sys.argv[1]), make_result(*FLAT))"
    )
    paths = [os.path.dirname(__file__), *filter(None, sys.path)]
    for seed in ("1", "2"):
        subprocess.run(
            [sys.executable, "-c", script, str(tmp_path / seed)],
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(paths)},
        )
    assert (tmp_path / "1").read_bytes() == (tmp_path / "2").read_bytes()


@pytest.mark.parametrize("suffix", WRITERS)
def test_unwritable_target_is_the_users_error_and_leaves_nothing(suffix, tmp_path):
    with pytest.raises(OutputError, match="Fix:"):
        WRITERS[suffix](tmp_path / "missing" / f"model.{suffix}", make_result(BOX))
    (tmp_path / f"model.{suffix}").mkdir()
    with pytest.raises(OutputError, match="Fix:"):
        WRITERS[suffix](tmp_path / f"model.{suffix}", make_result(BOX))
    assert not list(tmp_path.glob(".*"))


def test_offsets_cost_no_digits(tmp_path):
    """The same room near and far gives the same GLB vertices, but for the rounding of its input."""
    near = make_result(RAGGED, frame=Frame(np.eye(3), np.zeros(3)))
    far = make_result(RAGGED, frame=Frame(np.eye(3), np.array([4e5, 5e6, 100.0])))
    meshes = [glb_vertices(result, tmp_path / f"{k}.glb") for k, result in enumerate((near, far))]
    # 5e6 m in float64 is known to 1e-9 m, which can tip the rounding to float32 by one unit, 1e-6 m.
    np.testing.assert_allclose(meshes[0], meshes[1], rtol=0.0, atol=1e-6)


def glb_vertices(result: FitResult, path: Path) -> np.ndarray:
    write_glb(path, result)
    scene = trimesh.load_scene(path)
    return np.concatenate([scene.geometry[face.id].vertices for face in result.faces])
