"""Textures against the simulator's true ones, and what they cost.

    python -m benchmarks.textures                  quality and cost
    python -m benchmarks.textures --quality        PSNR and SSIM only
    python -m benchmarks.textures --cost           time and memory only

Quality: a room of 12 walls with a mosaic of 2, 8 and 31 cm squares and two things in it, filmed by a Kinect;
the cloud has every fourth row and column of the images. Compared with the true texture, averaged over each
pixel, where both textures are known:

- `points`: as `indoorfit fit` makes it;
- `best 3-NN`: the mean of the three nearest of the points that are known to lie on that plane, which no scan
  tells;
- `images`: the full frames, at 5 mm; and the points at 5 mm beside it; `not aligned` leaves every frame where
  its pose says.

`placed` is the PSNR with each tile of 30 x 30 cm moved to where it fits the truth best: what is left of the
errors once the poses' common drift, which no texture can mend, is out.

Cost: CPU and wall seconds and additional peak memory of the texture stage on 1.4 million points at 1 cm, in
units of scipy's neighbour search over the same points (as in benchmarks.speed).
"""

import argparse
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from indoorfit.environment import prepare_numerics

prepare_numerics()

import numpy as np  # noqa: E402
from scipy import ndimage  # noqa: E402
from scipy.spatial import KDTree  # noqa: E402

from benchmarks.tables import machine, table  # noqa: E402
from indoorfit.model import Camera, CameraImage, FaceTexture, FitResult  # noqa: E402
from indoorfit.pipeline import truth_result  # noqa: E402
from indoorfit.simulate import (  # noqa: E402
    BuiltScene,
    Finish,
    Furniture,
    SamplingSettings,
    ScanSettings,
    Scene,
    VirtualScan,
    assemble_scan,
    build_scene,
    handheld_path,
    load_sensor,
    plane_colours,
    regime,
    room_plans,
    room_shape,
    sample_surface,
    scan_frames,
)
from indoorfit.texture import TextureConfig, pack, texture_from_images, texture_from_points  # noqa: E402
from indoorfit.texture.canvas import Canvas, canvas_of  # noqa: E402

FINE = TextureConfig(pixel_m=0.005)


@dataclass(frozen=True)
class Film:
    """A scan, its truth and the frames that it was made from."""

    built: BuiltScene
    virtual: VirtualScan
    result: FitResult
    images: tuple[CameraImage, ...]


def film(seed: int, n_frames: int, registration: str, gain_sigma: float) -> Film:
    """Walk through the room; `gain_sigma` is the spread of the frames' exposures, in the logarithm."""
    things = (
        Furniture("cupboard", (3.0, 0.5), (1.0, 0.4, 1.8)),
        Furniture("table", (3.5, 3.0), (1.4, 0.8, 0.75)),
    )
    scene = Scene(room_plans(room_shape("X")), finishes=(Finish(texture="mosaic"),), furniture=things)
    built, sensor, errors = build_scene(scene), load_sensor("kinect_v1"), regime(registration)  # type: ignore[arg-type]
    path = handheld_path(scene, n_frames, np.random.default_rng(seed))
    settings = ScanSettings(yaw_rad=0.3, tilt_rad=0.05)
    thin = sensor.thinned(settings.pixel_step)
    frames = scan_frames(built, thin, path, errors, np.random.default_rng([seed, 1]), settings)
    virtual = assemble_scan(built, thin, frames, errors, settings)
    fx, fy = sensor.focal_pixels
    camera = Camera(fx, fy, 0.5 * sensor.columns - 0.5, 0.5 * sensor.rows - 0.5, sensor.columns, sensor.rows)
    rng, images = np.random.default_rng([seed, 2]), []
    # The same seed, hence the same poses as those of the cloud.
    for frame in scan_frames(built, sensor, path, errors, np.random.default_rng([seed, 1]), settings):
        gain = np.exp(gain_sigma * rng.standard_normal())
        pixels = np.clip(frame.colours * gain, 0, 255).round().astype(np.uint8)
        assert frame.estimated.rotation is not None
        images.append(
            CameraImage(
                f"{frame.true.id}",
                camera,
                frame.estimated.position_m,
                frame.estimated.rotation,
                lambda pixels=pixels: pixels,
            )
        )
    result = truth_result(virtual.shape, virtual.frame, {}, seed, virtual)
    return Film(built, virtual, result, tuple(images))


def true_texture(built: BuiltScene, result: FitResult, canvas: Canvas) -> np.ndarray:
    """Mean of 4 x 4 places in each pixel."""
    at = canvas.positions_m(np.ones((canvas.rows, canvas.columns), bool))
    total = np.zeros((len(at), 3))
    steps = canvas.pixel_m * ((np.arange(4) + 0.5) / 4 - 0.5)
    for dx in steps:
        for dy in steps:
            moved = at + dx * canvas.right + dy * canvas.down
            total += plane_colours(built, canvas.face.plane, result.frame.to_manhattan(moved)) / 16.0
    return total.reshape(canvas.rows, canvas.columns, 3)


def best_three(virtual: VirtualScan, canvas: Canvas, known: np.ndarray) -> np.ndarray:
    """Three nearest neighbours among the points that were taken on the plane."""
    own = np.flatnonzero(virtual.point_plane == canvas.face.plane)
    x_m, y_m = canvas.coordinates_m(virtual.scan.points_m[own], np.zeros(3))
    row, column = np.nonzero(known)
    centre_x, centre_y = canvas.centres_m()
    places = np.stack([centre_x[column], centre_y[row]], axis=1)
    nearest = KDTree(np.stack([x_m, y_m], axis=1)).query(places, 3, workers=2)[1]
    assert virtual.scan.colours is not None
    out = np.zeros((*known.shape, 3))
    out[known] = virtual.scan.colours[own][nearest].mean(axis=1)
    return out


def ssim(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Structural similarity of two grey images, by windows of 7 x 7 pixels (Wang et al. 2004)."""

    def mean(x: np.ndarray) -> np.ndarray:
        return ndimage.uniform_filter(x, 7)

    ma, mb = mean(a), mean(b)
    va, vb, both = mean(a * a) - ma**2, mean(b * b) - mb**2, mean(a * b) - ma * mb
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    return (2 * ma * mb + c1) * (2 * both + c2) / ((ma**2 + mb**2 + c1) * (va + vb + c2))


TILE_M, REACH_M = 0.3, 0.025


def placed_errors(found: np.ndarray, truth: np.ndarray, where: np.ndarray, pixel_m: float) -> list[float]:
    """Mean squared error of every whole tile at its best place within the reach, in whole pixels."""
    side, reach = round(TILE_M / pixel_m), round(REACH_M / pixel_m)
    errors = []
    for r in range(reach, where.shape[0] - side - reach, side):
        for c in range(reach, where.shape[1] - side - reach, side):
            if not where[r - reach : r + side + reach, c - reach : c + side + reach].all():
                continue
            tile = truth[r : r + side, c : c + side]
            errors.append(
                min(
                    float(((found[y : y + side, x : x + side] - tile) ** 2).mean())
                    for y in range(r - reach, r + reach + 1)
                    for x in range(c - reach, c + reach + 1)
                )
            )
    return errors


class Score:
    """Errors of one way, pixel by pixel over all faces."""

    def __init__(self) -> None:
        self.squared, self.similar, self.pixels = 0.0, 0.0, 0
        self.placed: list[float] = []

    def add(self, found: np.ndarray, truth: np.ndarray, where: np.ndarray, pixel_m: float) -> None:
        """One face."""
        self.placed += placed_errors(found, truth, where, pixel_m)
        self.squared += float(((found - truth) ** 2).mean(axis=2)[where].sum())
        self.similar += float(ssim(found.mean(axis=2), truth.mean(axis=2))[where].sum())
        self.pixels += int(where.sum())

    @property
    def texts(self) -> tuple[str, str, str]:
        """PSNR in dB, mean SSIM, and PSNR of tiles that were put right."""
        psnr = 10 * np.log10(255**2 * self.pixels / self.squared)
        placed = 10 * np.log10(255**2 / np.mean(self.placed))
        return f"{psnr:.2f}", f"{self.similar / self.pixels:.3f}", f"{placed:.2f}"


def compared(film: Film, ways: dict[str, dict[str, FaceTexture]], pixel_m: float, best: bool):
    """Scores of several textures of the same faces where all of them know the colour."""
    scores = {name: Score() for name in (*ways, *(["best 3-NN"] if best else []))}
    for face in film.result.faces:
        if not all(face.id in way for way in ways.values()):
            continue
        canvas = canvas_of(face, film.result.frame, pixel_m, FINE.max_side)
        truth = true_texture(film.built, film.result, canvas)
        where = np.logical_and.reduce([way[face.id].rgba[..., 3] > 0 for way in ways.values()])
        for name, way in ways.items():
            scores[name].add(way[face.id].rgba[..., :3].astype(float), truth, where, pixel_m)
        if best:
            scores["best 3-NN"].add(best_three(film.virtual, canvas, where), truth, where, pixel_m)
    return scores


def by_face(textures: tuple[FaceTexture, ...]) -> dict[str, FaceTexture]:
    """Textures by the id of their face."""
    return {texture.face: texture for texture in textures}


def quality(seed: int, n_frames: int) -> None:
    """Print PSNR and SSIM."""
    rows = []
    for registration in ("0", "5mm"):
        for gain_sigma in (0.0, 0.2):
            if registration != "0" and gain_sigma:
                continue
            took = film(seed, n_frames, registration, gain_sigma)
            scan, result = took.virtual.scan, took.result
            label = f"poses {registration}, exposures {gain_sigma:g}"
            if not gain_sigma:
                coarse = {"points": by_face(texture_from_points(result, scan, TextureConfig()))}
                for name, score in compared(took, coarse, 0.01, True).items():
                    rows.append((label, "1 cm", name, *score.texts))
            fine = {
                "points": by_face(texture_from_points(result, scan, FINE)),
                "images": by_face(texture_from_images(result, scan, took.images, FINE)),
            }
            if registration != "0":
                still = replace(FINE, align=False)
                fine["images, not aligned"] = by_face(texture_from_images(result, scan, took.images, still))
            if gain_sigma:
                unbalanced = replace(FINE, exposure=False)
                fine["images, gains off"] = by_face(
                    texture_from_images(result, scan, took.images, unbalanced)
                )
            for name, score in compared(took, fine, 0.005, False).items():
                rows.append((label, "5 mm", name, *score.texts))
    print(f"{n_frames} frames of kinect_v1, seed {seed}\n")
    print(table(("scan", "pixel", "texture", "PSNR dB", "SSIM", "placed dB"), rows))


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Wall and CPU seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - cpu


def cost(seed: int, n_points: int) -> None:
    """Print time and memory of the texture stage."""
    settings = SamplingSettings(n_points=n_points, n_furniture=2, n_windows=1, yaw_rad=0.4, tilt_rad=0.05)
    virtual = sample_surface(room_shape("X"), settings, np.random.default_rng(seed))
    result = truth_result(virtual.shape, virtual.frame, {}, seed, virtual)
    config = TextureConfig()

    def stage() -> None:
        pack(texture_from_points(result, virtual.scan, config), config)

    held_mb, peak_mb = peak_of(stage)
    wall_s, cpu_s = min((timed(stage) for _ in range(3)), key=lambda figures: figures[1])
    points_m = virtual.scan.points_m
    _, yardstick_s = timed(lambda: KDTree(points_m).query(points_m, 8, workers=1))
    print(f"\nX room of 12 walls, {n_points} points, 1 cm, files encoded; best of 3\n")
    print(
        table(
            ("what", "CPU s", "wall s", "additional MB"),
            [
                ("texture", f"{cpu_s:.2f}", f"{wall_s:.2f}", f"{peak_mb - held_mb:.0f}"),
                ("k-d tree and 8 neighbours", f"{yardstick_s:.2f}", "", ""),
            ],
        )
    )
    print(f"\ntexture / yardstick: {cpu_s / yardstick_s:.2f}")


def peak_of(work: Callable[[], object]) -> tuple[float, float]:
    """Memory held before, and the most held during the work, MB; Linux's own count of this process."""
    if not sys.platform.startswith("linux"):
        usage = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e-6
        work()
        return usage, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e-6
    # Forget the peak of the simulation.
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")
    before = _status_mb("VmRSS")
    work()
    return before, _status_mb("VmHWM")


def _status_mb(name: str) -> float:
    with open("/proc/self/status") as file:
        return next(float(line.split()[1]) for line in file if line.startswith(name)) * 1.024e-3


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quality", action="store_true")
    parser.add_argument("--cost", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--frames", type=int, default=90)
    parser.add_argument("--points", type=int, default=1_400_000)
    wanted = parser.parse_args()
    print(machine())
    if wanted.quality or not wanted.cost:
        quality(wanted.seed, wanted.frames)
    if wanted.cost or not wanted.quality:
        cost(wanted.seed, wanted.points)


if __name__ == "__main__":
    main()
