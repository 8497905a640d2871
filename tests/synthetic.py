"""Rooms, scans and comparisons that the tests of several stages share."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from scipy import ndimage

from indoorfit.config import RunConfig
from indoorfit.discover import discover
from indoorfit.model import FitResult, Scan, Shape
from indoorfit.orient import orient
from indoorfit.pipeline import truth_result
from indoorfit.simulate import SamplingSettings, room_shape, sample_surface
from indoorfit.simulate.virtual import VirtualScan
from indoorfit.thin import surfels, thin

KINDS = ("box", "L", "U", "X", "T", "Z", "stair")


def virtual(kind: str, seed: int = 0, *, coloured: bool = False, **settings) -> VirtualScan:
    """A scan of a named room; angles in degrees as `yaw_deg`, `tilt_deg`, `azimuth_deg`.

    Without colours there is nothing to paint, which would take a third of the time of a fit.
    """
    angles = {
        f"{name}_rad": math.radians(settings.pop(f"{short}_deg", 0.0))
        for name, short in (("yaw", "yaw"), ("tilt", "tilt"), ("tilt_azimuth", "azimuth"))
    }
    made = sample_surface(
        room_shape(kind),
        SamplingSettings(**angles, **settings),
        np.random.default_rng(seed),
        name=f"{kind}.ply",
    )
    return made if coloured else replace(made, scan=replace(made.scan, colours=None))


def moved(scan: Scan, points_m: np.ndarray) -> Scan:
    """The same scan with other coordinates."""
    return replace(scan, points_m=np.ascontiguousarray(points_m))


def truth_of(scan: VirtualScan) -> FitResult:
    """The exact model of a virtual scan."""
    return truth_result(scan.shape, scan.frame, {}, 0)


def lengths(result: FitResult) -> np.ndarray:
    """All dimensions in increasing order: what two models of one room share whatever their names and axes.

    Sorting never enlarges the largest difference, and rooms that differ in structure differ in number.
    """
    return np.sort([dimension.quantity.value for dimension in result.dimensions])


def largest_error_m(result: FitResult, truth: FitResult) -> float:
    """Largest difference of dimensions; raises where the structure differs."""
    found, true = lengths(result), lengths(truth)
    assert len(found) == len(true), f"{len(found)} dimensions instead of {len(true)}"
    return float(np.max(np.abs(found - true)))


def expected_limit_m(scan: VirtualScan, sigma_m: float) -> float:
    """Five standard errors of the distance between the two faces with the fewest points.

    A plane's position from n points has sigma / sqrt(n); the robust location has 95 % efficiency and leaves
    out the rim of each face (at most a third of the points of a narrow one), hence the factor 1.3. Five,
    because each room has a dozen dimensions and the tests some dozens of rooms.
    """
    on_plane = np.bincount(scan.point_plane[scan.point_plane >= 0], minlength=len(scan.shape.planes))
    fewest = np.sort(on_plane)[:2]
    return 5.0 * 1.3 * sigma_m * math.sqrt(float(np.sum(1.0 / fewest)))


def is_rotation(matrix: np.ndarray) -> bool:
    """Orthonormal to rounding (1e-12) and right-handed."""
    return bool(np.allclose(matrix @ matrix.T, np.eye(3), atol=1e-12) and np.linalg.det(matrix) > 0)


def oriented(scan: Scan, config: RunConfig | None = None):
    """The front end up to orientation: frame, surfels in the Manhattan frame, notes."""
    config = config or RunConfig()
    cloud = thin(scan, config.thin)
    local = surfels(cloud, config.surfels)
    frame, notes = orient(local, cloud.origin_m, config.orient, np.random.default_rng(config.seed))
    turn = frame.R_manhattan_scan.T
    return frame, replace(local, positions_m=local.positions_m @ turn, normals=local.normals @ turn), notes


def discovered(scan: Scan, config: RunConfig | None = None) -> tuple[Shape, tuple]:
    """The front end up to the grammar."""
    from indoorfit.classify import classify
    from indoorfit.segment import grow_surfaces

    config = config or RunConfig()
    _, local, _ = oriented(scan, config)
    segments = grow_surfaces(local, config.segment)
    return discover(local, segments, classify(segments, config.classify), config.discover)


@st.composite
def plans(draw, side: int = 5):
    """A connected rectilinear plan: grid lines along x and y, mask of the cells, floor and ceiling height."""
    nx, ny = draw(st.integers(1, side)), draw(st.integers(1, side))
    missing = draw(st.sets(st.integers(0, nx * ny - 1), max_size=nx * ny // 2))
    mask = ~np.isin(np.arange(nx * ny), list(missing)).reshape(nx, ny)
    labels, n = ndimage.label(mask)
    mask = labels == 1 + np.argmax([np.sum(labels == k) for k in range(1, n + 1)])
    steps = st.floats(0.1, 2.0, allow_nan=False)
    x = np.cumsum([draw(st.floats(-3, 3)), *(draw(steps) for _ in range(nx))])
    y = np.cumsum([draw(st.floats(-3, 3)), *(draw(steps) for _ in range(ny))])
    low = draw(st.floats(-2, 0))
    return x.tolist(), y.tolist(), mask, (low, low + draw(st.floats(2.0, 4.0)))


def touches_by_corner(mask: np.ndarray) -> bool:
    """Whether two cells meet in a corner alone: there the solid is not a manifold."""
    padded = np.pad(mask, 1)
    a, b = padded[:-1, :-1], padded[1:, 1:]
    c, d = padded[1:, :-1], padded[:-1, 1:]
    return bool(np.any((a & b & ~c & ~d) | (c & d & ~a & ~b)))
