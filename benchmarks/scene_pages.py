"""Pages of simulated scans to look at, beside real ones.

    python benchmarks/scene_pages.py --out pages --scenes 3
    python benchmarks/scene_pages.py --out pages --kinds real --real FOLDER

One PNG for each kind of scene; in each row one scan, from above without its ceiling and in perspective, point
colours, the name of sensor and seed below. `real` draws the scans of a folder in the same way.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from indoorfit.io import read_scan
from indoorfit.simulate import (
    RandomSceneSettings,
    Registration,
    ScanSettings,
    Scene,
    VirtualScan,
    handheld_path,
    load_sensor,
    random_scene,
    regime,
    room_plans,
    room_shape,
    stations,
    virtual_scan,
)

VIEW_PIXELS = (620, 460)
BACKGROUND = (252, 252, 250)
EXACT = Registration()


@dataclass(frozen=True)
class Kind:
    """How the scans of one page are made."""

    settings: Callable[[int], RandomSceneSettings]
    """From the number of the scan."""
    sensor: str = "kinect_v1"
    registration: Registration = EXACT
    frames: int = 90
    thesis_room: bool = False


KINDS = {
    "thesis": Kind(
        lambda k: RandomSceneSettings(n_furniture=3, n_doors=0), registration=regime("5mm"), thesis_room=True
    ),
    "clutter": Kind(
        lambda k: RandomSceneSettings(n_walls=6 + 2 * k, n_furniture=12, bookcase=True),
        registration=regime("5mm"),
    ),
    "hidden": Kind(lambda k: RandomSceneSettings(n_walls=4 + 2 * k, n_furniture=6, bookcase=True)),
    "glass": Kind(lambda k: RandomSceneSettings(n_walls=4 + 2 * k, glass_wall=True), sensor="tls", frames=2),
    "laser": Kind(
        lambda k: RandomSceneSettings(n_walls=8 + 2 * k, n_furniture=8, uneven_m=0.008),
        sensor="tls",
        frames=3,
    ),
    "rooms": Kind(lambda k: RandomSceneSettings(n_rooms=2 + k, n_furniture=8), sensor="tls", frames=4),
    "steps": Kind(
        lambda k: RandomSceneSettings(n_walls=4 + 2 * k, floor_step=k != 1, beam=k > 0), sensor="tof_camera"
    ),
    "oblique": Kind(lambda k: RandomSceneSettings(n_walls=4 + 2 * k, oblique=True), sensor="tls", frames=3),
    "drift": Kind(
        lambda k: RandomSceneSettings(n_walls=6 + 2 * k),
        registration=Registration(rms_m=0.05, jump_share=0.3, slip_share=0.1),
    ),
}


def main() -> None:
    """Write the pages that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="directory for the pages")
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=[*KINDS, "real"])
    parser.add_argument("--scenes", type=int, default=3, help="scans on a page")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--real", type=Path, help="folder of real scans, for the kind `real`")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for kind in arguments.kinds:
        if kind == "real":
            rows = real_rows(arguments.real)
        else:
            rows = [simulated_row(kind, KINDS[kind], k, arguments.seed + k) for k in range(arguments.scenes)]
        page(rows).save(arguments.out / f"{kind}.png")
        print(arguments.out / f"{kind}.png")


def simulated_row(name: str, kind: Kind, number: int, seed: int) -> tuple[Image.Image, Image.Image, str]:
    """Both views of one simulated scan, and what to write below them."""
    rng = np.random.default_rng([seed, sum(name.encode())])
    rooms = room_plans(room_shape("L")) if kind.thesis_room else None
    scene = random_scene(rng, kind.settings(number), name, rooms)
    virtual = scan(scene, kind, rng)
    points_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    assert virtual.scan.colours is not None
    text = (
        f"{name}, seed {seed}: {kind.sensor}, {kind.frames} frames, registration "
        f"{100 * kind.registration.rms_m:g} cm, {virtual.scan.n_points:,} points"
    )
    rooms_m = np.array([virtual.shape.bounds_m()[room.id] for room in virtual.shape.rooms])
    bounds_m = np.stack([rooms_m[:, 0].min(axis=0), rooms_m[:, 1].max(axis=0)])
    return (*views(points_m, virtual.scan.colours, bounds_m), text)


def scan(scene: Scene, kind: Kind, rng: np.random.Generator) -> VirtualScan:
    """A scan with the sensor of the kind."""
    sensor = load_sensor(kind.sensor)
    scanner = sensor.kind == "scanner"
    path = stations(scene, kind.frames, rng) if scanner else handheld_path(scene, kind.frames, rng)
    settings = ScanSettings(pixel_step=2 if scanner else 4)
    return virtual_scan(scene, sensor, path, kind.registration, rng, settings)


def real_rows(folder: Path) -> list[tuple[Image.Image, Image.Image, str]]:
    """Both views of every scan of a folder."""
    rows = []
    for path in sorted([*folder.glob("*.ply"), *folder.glob("*.pcd")]):
        cloud = read_scan(path)
        colours = cloud.colours
        if colours is None:
            colours = np.full((cloud.n_points, 3), 120, np.uint8)
        points_m = cloud.points_m - np.median(cloud.points_m, axis=0)
        rows.append((*views(points_m, colours), f"{path.name}: {cloud.n_points:,} points"))
    return rows


def views(
    points_m: np.ndarray, colours: np.ndarray, bounds_m: np.ndarray | None = None
) -> tuple[Image.Image, Image.Image]:
    """From above and in perspective, both without what lies above 80 % of the height; z is up."""
    if bounds_m is None:
        # Points far outside would leave the room itself a dot.
        low, high = np.percentile(points_m, [1.0, 99.0], axis=0)
    else:
        low, high = bounds_m
    margin_m = 0.15 * (high - low) + 0.5
    near = ((points_m > low - margin_m) & (points_m < high + margin_m)).all(axis=1)
    below = near & (points_m[:, 2] < low[2] + 0.8 * (high[2] - low[2]))
    centred = points_m[below] - 0.5 * (low + high)
    plan = np.stack([centred[:, 0], -centred[:, 1], -centred[:, 2]], axis=1)
    extent = high - low + margin_m
    scale = min(VIEW_PIXELS[0] / extent[0], VIEW_PIXELS[1] / extent[1])
    top = splat(plan[:, :2] * scale, plan[:, 2], colours[below])
    return top, perspective(centred, colours[below], float(np.linalg.norm(extent)))


def perspective(points_m: np.ndarray, colours: np.ndarray, size_m: float) -> Image.Image:
    """From a corner, 40 degrees above the horizon."""
    yaw, pitch = np.radians(-60.0), np.radians(40.0)
    forward = -np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    # The camera stands back along its own axis; the middle of the room is the origin.
    in_view = (points_m + 1.15 * size_m * forward) @ np.stack([right, down, forward], axis=1)
    scale = 1.05 * VIEW_PIXELS[0] / in_view[:, 2:]
    return splat(in_view[:, :2] * scale, in_view[:, 2], colours)


def splat(places: np.ndarray, depth: np.ndarray, colours: np.ndarray) -> Image.Image:
    """Points as single pixels, the nearest on top; the origin is the middle of the image."""
    width, height = VIEW_PIXELS
    column, row = (np.round(places + np.array(VIEW_PIXELS) / 2)).astype(int).T
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    # Later writes win: the farthest first.
    order = np.flatnonzero(inside)[np.argsort(-depth[inside])]
    image = np.full((height, width, 3), BACKGROUND, np.uint8)
    image[row[order], column[order]] = colours[order]
    return Image.fromarray(image)


def page(rows: list[tuple[Image.Image, Image.Image, str]]) -> Image.Image:
    """All rows below each other."""
    width, height = VIEW_PIXELS
    sheet = Image.new("RGB", (2 * width + 30, len(rows) * (height + 30) + 10), "white")
    draw = ImageDraw.Draw(sheet)
    for k, (top, perspective_view, text) in enumerate(rows):
        y = 10 + k * (height + 30)
        sheet.paste(top, (10, y))
        sheet.paste(perspective_view, (20 + width, y))
        draw.text((10, y + height + 6), text, fill="black")
    return sheet


if __name__ == "__main__":
    main()
