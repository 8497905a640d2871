"""Points drawn evenly over a room's surface: the quick simulator, with no sensor in it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from indoorfit.errors import ConfigError
from indoorfit.model import Scan, Shape

from .colour import surface_colours
from .patches import Box, Patches, box_patches, join, shape_patches
from .placement import Hole, place_furniture, place_windows, room_centre_m
from .pose import scan_frame
from .virtual import VirtualScan

Noise = Literal["normal", "isotropic", "kinect"]

KINECT_SIGMA_PER_M = 0.04 / 5.0**2
"""1/m: 4 cm at 5 m, growing with the square of the distance (Khoshelham & Oude Elberink 2012, rounded)."""


@dataclass(frozen=True)
class SamplingSettings:
    """What kind of cloud to draw."""

    n_points: int = 150_000
    """Points of the cloud, outliers included. The thesis' synthetic rooms hold 120 to 200 thousand."""
    sigma_m: float = 0.005
    """Standard deviation of the noise: 0.5 cm as in the thesis (5.1.1). Unused by `kinect`."""
    noise: Noise = "normal"
    """`normal` shifts points along the surface normal, `isotropic` in all directions with `sigma_m` each,
    `kinect` along the line of sight with 4 cm * (distance / 5 m)^2."""
    sensor_m: tuple[float, float, float] | None = None
    """Where the `kinect` stands, Manhattan frame; None for the middle of the room."""
    outlier_share: float = 0.0
    """Share of points spread evenly over the bounding box grown by 10 %."""
    n_furniture: int = 0
    """Boxes put on the floor at random."""
    furniture: tuple[Box, ...] = ()
    """Further boxes, Manhattan frame."""
    furniture_hides: bool = False
    """Whether the wall and floor that boxes cover is missing from the cloud, as in a real scan."""
    n_windows: int = 0
    """Window holes put into large walls at random."""
    holes: tuple[Hole, ...] = ()
    """Further parts of planes without points."""
    missing_planes: tuple[int, ...] = ()
    """Planes without any point, such as a wall of glass."""
    yaw_rad: float = 0.0
    tilt_rad: float = 0.0
    """Angle between the room's vertical and the file's z axis."""
    tilt_azimuth_rad: float = 0.0
    """Direction of the horizontal axis about which the room is tilted."""
    translation_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Scan coordinates of the Manhattan origin, such as a map offset."""


DEFAULT_SAMPLING = SamplingSettings()


def sample_surface(
    shape: Shape, settings: SamplingSettings, rng: np.random.Generator, name: str = "simulated"
) -> VirtualScan:
    """Draw points evenly (by area) over the visible surface of a room.

    Every wall is seen in full, whatever stands before it, unless `furniture_hides` or a hole says
    otherwise; for a cloud with occlusion and drift see `virtual_scan`.

    Args:
        shape: the room, Manhattan frame, metres.
        settings: count, noise, clutter and pose.
        rng: decides everything else; the same state gives the same bytes.
        name: the scan's name.

    Raises:
        ConfigError: a setting is out of range, or nothing of the surface is left to sample.
    """
    _check(shape, settings)
    boxes = settings.furniture + place_furniture(shape, settings.n_furniture, rng)
    holes = settings.holes + place_windows(shape, settings.n_windows, rng)
    patches = _visible(shape, boxes, settings.missing_planes)
    n_outliers = round(settings.outlier_share * settings.n_points)
    n_surface = settings.n_points - n_outliers
    patch, points_m = _draw(patches, boxes, holes, n_surface, settings.furniture_hides, rng)
    colours = surface_colours(patches.surface[patch], points_m, rng)
    points_m = points_m + _noise(shape, patches, patch, points_m, settings, rng)
    points_m, colours = _add_outliers(points_m, colours, n_outliers, rng)
    frame = scan_frame(settings.yaw_rad, settings.tilt_rad, settings.tilt_azimuth_rad, settings.translation_m)
    plane = np.concatenate([patches.plane[patch], np.full(n_outliers, -1)])
    # Outliers come anywhere in a real file, not at its end.
    order = rng.permutation(settings.n_points)
    scan = Scan(frame.to_scan(points_m[order]), colours[order], name=name)
    return VirtualScan(scan, shape, frame, plane[order])


def _check(shape: Shape, settings: SamplingSettings) -> None:
    if shape.oblique:
        raise ConfigError(
            "simulate: points are drawn from rectangles along the axes, and the shape has oblique walls. "
            "Fix: scan it as a scene (virtual_scan)."
        )
    if settings.n_points < 1 or settings.sigma_m < 0.0 or not 0.0 <= settings.outlier_share < 1.0:
        raise ConfigError(
            f"simulate: n_points {settings.n_points}, sigma_m {settings.sigma_m:g}, outlier_share "
            f"{settings.outlier_share:g}; need at least one point, noise of 0 or more and a share from 0 "
            "to below 1. Fix: sizes are in metres, shares are fractions."
        )
    if settings.noise not in ("normal", "isotropic", "kinect"):
        raise ConfigError(
            f"simulate: unknown noise '{settings.noise}'; need normal, isotropic or kinect. Fix: choose one."
        )
    wrong = [k for k in settings.missing_planes if not 0 <= k < len(shape.planes)]
    if wrong:
        raise ConfigError(
            f"simulate: missing_planes {wrong} do not exist; the room has planes 0 to "
            f"{len(shape.planes) - 1}. Fix: correct the numbers."
        )


def _visible(shape: Shape, boxes: tuple[Box, ...], missing_planes: tuple[int, ...]) -> Patches:
    room = shape_patches(shape)
    furniture = box_patches(boxes, room, len(shape.planes))
    patches = join(room.select(~np.isin(room.plane, missing_planes)), furniture)
    if not len(patches.axis):
        raise ConfigError("simulate: every plane is missing. Fix: leave some of them to be scanned.")
    return patches


def _draw(
    patches: Patches,
    boxes: tuple[Box, ...],
    holes: tuple[Hole, ...],
    n_points: int,
    hides: bool,
    rng: np.random.Generator,
) -> tuple[Int[np.ndarray, " points"], Float[np.ndarray, "points 3"]]:
    """Patch and position of every point: drawn, and drawn again where a hole or a box swallowed it."""
    share = patches.areas_m2 / patches.areas_m2.sum()
    patch, points_m = np.zeros(0, int), np.zeros((0, 3))
    for _ in range(100):
        missing = n_points - len(patch)
        if missing <= 0:
            return patch[:n_points], points_m[:n_points]
        new = rng.choice(len(share), size=missing, p=share)
        place = rng.random((missing, 3))
        new_m = patches.low_m[new] + place * (patches.high_m[new] - patches.low_m[new])
        keep = ~_in_holes(holes, patches.plane[new], patches.axis[new], new_m)
        if hides:
            keep &= ~_behind_boxes(boxes, patches.plane[new], new_m)
        patch, points_m = np.concatenate([patch, new[keep]]), np.concatenate([points_m, new_m[keep]])
    raise ConfigError("simulate: holes cover nearly the whole surface. Fix: smaller or fewer holes.")


def _in_holes(
    holes: tuple[Hole, ...],
    plane: Int[np.ndarray, " points"],
    axis: Int[np.ndarray, " points"],
    points_m: Float[np.ndarray, "points 3"],
) -> Bool[np.ndarray, " points"]:
    inside = np.zeros(len(points_m), bool)
    for hole in holes:
        within = (points_m >= np.array(hole.low_m)) & (points_m <= np.array(hole.high_m))
        # The extent along the plane's own axis is ignored.
        within[np.arange(len(axis)), axis] = True
        inside |= (plane == hole.plane) & within.all(axis=1)
    return inside


def _behind_boxes(
    boxes: tuple[Box, ...], plane: Int[np.ndarray, " points"], points_m: Float[np.ndarray, "points 3"]
) -> Bool[np.ndarray, " points"]:
    hidden = np.zeros(len(plane), bool)
    for box in boxes:
        # Furniture stands a few millimetres off the wall at most; 1 cm counts as covered.
        hidden |= (plane >= 0) & box.contains(points_m, 0.01)
    return hidden


def _noise(
    shape: Shape,
    patches: Patches,
    patch: Int[np.ndarray, " points"],
    points_m: Float[np.ndarray, "points 3"],
    settings: SamplingSettings,
    rng: np.random.Generator,
) -> Float[np.ndarray, "points 3"]:
    n = len(points_m)
    if settings.noise == "isotropic":
        return rng.normal(0.0, 1.0, (n, 3)) * settings.sigma_m
    if settings.noise == "normal":
        return np.eye(3)[patches.axis[patch]] * (rng.normal(0.0, 1.0, n) * settings.sigma_m)[:, None]
    sensor_m = room_centre_m(shape) if settings.sensor_m is None else np.array(settings.sensor_m)
    sight_m = points_m - sensor_m
    distance_m = np.linalg.norm(sight_m, axis=1)
    # d * unit vector * (k d^2 / d) = sight * k d: no division, so a point at the sensor is harmless.
    return sight_m * (rng.normal(0.0, 1.0, n) * KINECT_SIGMA_PER_M * distance_m)[:, None]


def _add_outliers(
    points_m: Float[np.ndarray, "points 3"],
    colours: UInt8[np.ndarray, "points 3"],
    n_outliers: int,
    rng: np.random.Generator,
) -> tuple[Float[np.ndarray, "all 3"], UInt8[np.ndarray, "all 3"]]:
    low_m, high_m = points_m.min(axis=0), points_m.max(axis=0)
    grow_m = 0.05 * (high_m - low_m)
    outliers_m = rng.uniform(low_m - grow_m, high_m + grow_m, (n_outliers, 3))
    grey = rng.integers(60, 200, (n_outliers, 1), dtype=np.uint8).repeat(3, axis=1)
    return np.concatenate([points_m, outliers_m]), np.concatenate([colours, grey])
