"""Named suites of simulated scans; each room follows from the suite's name and a seed alone.

The first seven are clouds drawn from the surface, the rest are scans by a virtual sensor. A room of one seed
is the same in `thesis`, `full`, `kinect`, `kinectrot` and `sparse`, and again in the three `drift` suites.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from indoorfit import ConfigError
from indoorfit.model import Shape
from indoorfit.simulate import (
    ObliqueWall,
    RandomSceneSettings,
    Registration,
    SamplingSettings,
    ScanSettings,
    VirtualScan,
    handheld_path,
    load_sensor,
    random_room,
    random_scene,
    regime,
    room_shape,
    sample_surface,
    stations,
    virtual_scan,
)

KINDS = ("box", "L", "U", "X", "T", "Z", "stair")
_SIZES_M = {"box": (5.0, 4.0), "L": (5.08, 3.2), "U": (6.0, 4.0), "X": (6.0, 5.5)}
_MAX_TILT_RAD = np.radians(6.0)
_PIXEL_STEP = 8
"""A Kinect frame of 80 x 60: a scan of 60 to 120 frames has 0.3 to 0.5 million points. Correlated errors do
not average out over pixels, so more of them would only cost time."""

_PANE_M = 0.01
"""Thickness of a wall that is all glass."""

_BARE = RandomSceneSettings(n_furniture=0, n_windows=0, n_doors=0)
FURNISHED = RandomSceneSettings(n_furniture=5, n_windows=2, n_doors=1, uneven_m=0.005)
_SECTORS = Registration(rms_m=0.02, rotation_rad_per_m=0.35, walk_share=0.0, jump_share=1.0)
"""2 cm and 0.4 degrees, constant within each of eight sectors of the path."""
SLIPPED = Registration(rms_m=0.005, slip_share=0.15)
_STATIONS = Registration(rms_m=0.003, walk_share=0.0)
"""Stations of a laser scanner do not drift; each is placed on its own."""


@dataclass(frozen=True)
class Suite:
    """One kind of difficulty."""

    about: str
    make: Callable[[int], VirtualScan]


def _random_pose(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "yaw_rad": float(rng.uniform(0.0, 2.0 * np.pi)),
        "tilt_rad": float(rng.uniform(0.0, _MAX_TILT_RAD)),
        "tilt_azimuth_rad": float(rng.uniform(0.0, 2.0 * np.pi)),
    }


def _preset_room(kind: str, rng: np.random.Generator) -> Shape:
    """A room of the kind, each extent some 10 to 35 % off the preset's."""
    length_m, width_m = _SIZES_M.get(kind, (6.0, 4.5))
    for _ in range(20):
        try:
            return room_shape(
                kind,
                length_m=length_m * rng.uniform(0.9, 1.35),
                width_m=width_m * rng.uniform(0.9, 1.35),
                height_m=rng.uniform(2.4, 3.2),
            )
        except ConfigError:
            continue  # the notches of the preset leave no room in this size
    return room_shape(kind)


def _sampled(seed: int, level: bool = False, **changes: Any) -> VirtualScan:
    """A preset's room as points drawn from its surface."""
    rng = np.random.default_rng(seed)
    shape = _preset_room(KINDS[seed % len(KINDS)], rng)
    settings = SamplingSettings(n_points=int(rng.integers(120_000, 200_001)), **_random_pose(rng))
    if level:
        settings = replace(settings, yaw_rad=0.0, tilt_rad=0.0)
    return sample_surface(shape, replace(settings, **changes), rng)


def _nested(seed: int) -> VirtualScan:
    rng = np.random.default_rng(seed)
    shape = random_room(rng, int(rng.choice([8, 10, 12, 14])))
    return sample_surface(shape, SamplingSettings(**_random_pose(rng)), rng)


def scanned(
    seed: int,
    registration: Registration,
    settings: RandomSceneSettings = _BARE,
    walls: tuple[int, ...] = (4, 6, 8, 10),
    sensor: str = "kinect_v1",
) -> VirtualScan:
    """A room scanned with a hand-held depth camera."""
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, replace(settings, n_walls=int(rng.choice(walls))))
    if settings.glass_wall:
        # Without a reveal: with one, floor and ceiling go on to its far end, and "the" wall is neither.
        openings = tuple(replace(opening, depth_m=_PANE_M) for opening in scene.openings)
        scene = replace(scene, openings=openings)
    n_frames = int(rng.integers(60, 121)) * (1 + settings.n_rooms) // 2
    style = "spin" if rng.random() < 0.5 and settings.n_rooms == 1 else "walk"
    path = handheld_path(scene, n_frames, rng, style)
    pose = ScanSettings(pixel_step=_PIXEL_STEP, n_threads=1, **_random_pose(rng))
    return virtual_scan(scene, load_sensor(sensor), path, registration, rng, pose)


def _laser(seed: int) -> VirtualScan:
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, replace(FURNISHED, n_walls=int(rng.choice([4, 6, 8, 10]))))
    # Fewer than three leave whole walls of concave rooms unseen, and no structure to be right about.
    path = stations(scene, int(rng.integers(3, 6)), rng)
    pose = ScanSettings(pixel_step=4, n_threads=1, **_random_pose(rng))
    return virtual_scan(scene, load_sensor("tls"), path, _STATIONS, rng, pose)


def _glass(seed: int) -> VirtualScan:
    return scanned(seed, regime("5mm"), replace(_BARE, glass_wall=True))


def _rooms(seed: int) -> VirtualScan:
    return scanned(seed, regime("5mm"), replace(FURNISHED, n_rooms=2 + seed % 3))


def _steps(seed: int) -> VirtualScan:
    """A platform, a beam, or both."""
    settings = replace(_BARE, floor_step=seed % 3 != 1, beam=seed % 3 != 0)
    return scanned(seed, regime("5mm"), settings, (4, 6, 8))


def _skew(seed: int) -> VirtualScan:
    """A furnished box of which one end is not square: 10 to 25 degrees off."""
    rng = np.random.default_rng(seed)
    scene = random_scene(rng, replace(FURNISHED, n_walls=4, n_windows=0, n_doors=0, uneven_m=0.0))
    (x0, x1), (y0, y1) = scene.rooms[0].x_lines_m, scene.rooms[0].y_lines_m
    shift_m = float(np.tan(np.radians(rng.uniform(10.0, 25.0)))) * (y1 - y0)
    end = ObliqueWall(0, (x1, y0), (x1 - min(shift_m, 0.7 * (x1 - x0)), y1))
    # Nothing stands where the room now ends.
    things = tuple(item for item in scene.furniture if item.centre_m[0] < x1 - shift_m - 1.0)
    scene = replace(scene, oblique_walls=(end,), furniture=things)
    path = handheld_path(scene, int(rng.integers(60, 121)), rng, "walk")
    pose = ScanSettings(pixel_step=_PIXEL_STEP, n_threads=1, **_random_pose(rng))
    return virtual_scan(scene, load_sensor("kinect_v1"), path, regime("5mm"), rng, pose)


SUITES: dict[str, Suite] = {
    "thesis": Suite("points with normal noise of 0.5 cm (thesis 5.1.1)", _sampled),
    "full": Suite(
        "the same with a box of furniture and a window",
        lambda seed: _sampled(seed, n_furniture=1, n_windows=1, furniture_hides=bool(seed % 2)),
    ),
    "kinect": Suite(
        "line-of-sight noise of 4 cm at 5 m, level", lambda seed: _sampled(seed, level=True, noise="kinect")
    ),
    "kinectrot": Suite("the same, tilted and turned", lambda seed: _sampled(seed, noise="kinect")),
    "sparse": Suite(
        "5000 points, 1 cm, 2 % outliers",
        lambda seed: _sampled(seed, n_points=5000, sigma_m=0.01, noise="isotropic", outlier_share=0.02),
    ),
    "nested": Suite("8 to 14 walls, nested notches and pillars", _nested),
    "clutter": Suite(
        "Kinect, 5 mm drift, furniture, windows, a door, uneven walls",
        lambda seed: scanned(seed, regime("5mm"), FURNISHED),
    ),
    "hidden": Suite(
        "the same with a bookcase over half of the longest wall",
        lambda seed: scanned(seed, regime("5mm"), replace(FURNISHED, bookcase=True)),
    ),
    "glass": Suite("Kinect, 5 mm drift, one wall all glass", _glass),
    "drift5mm": Suite("Kinect, bare room, 5 mm drift", lambda seed: scanned(seed, regime("5mm"))),
    "drift2cm": Suite("Kinect, bare room, 2 cm drift", lambda seed: scanned(seed, regime("2cm"))),
    "drift5cm": Suite("Kinect, bare room, 5 cm drift", lambda seed: scanned(seed, regime("5cm"))),
    "slipped": Suite(
        "Kinect, 5 mm drift, 15 % of the frames slipped by 6 cm and 1 degree",
        lambda seed: scanned(seed, SLIPPED),
    ),
    "reg": Suite(
        "Kinect, 2 cm and 0.4 degrees per sector, a bookcase over half of a wall",
        lambda seed: scanned(seed, _SECTORS, replace(_BARE, bookcase=True)),
    ),
    "laser": Suite("terrestrial laser, 3 to 5 stations, furnished", _laser),
    "rooms": Suite("2 to 4 rooms joined by doors, furnished, Kinect, 5 mm drift", _rooms),
    "steps": Suite("a platform or a beam or both, Kinect, 5 mm drift", _steps),
    "oblique": Suite(
        "a corner cut off by a wall of its own direction",
        lambda seed: scanned(seed, regime("5mm"), replace(_BARE, oblique=True)),
    ),
    "skew": Suite("a furnished box with one end that is not square", _skew),
}
