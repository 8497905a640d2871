"""Clouds and a result that the reading and writing tests share."""

import numpy as np
import pytest

from indoorfit.model import (
    SIDES,
    Cube,
    Dimension,
    Face,
    FitResult,
    Frame,
    Interval,
    Note,
    Plane,
    Quantity,
    Room,
    Scan,
    Shape,
)


@pytest.fixture
def scan() -> Scan:
    """200 points in a room of 4 x 5 x 2.5 m at map coordinates, with colours and frames."""
    rng = np.random.default_rng(7)
    points_m = rng.uniform(0, (4, 5, 2.5), size=(200, 3)) + np.array([532_145.25, 5_801_223.5, 34.125])
    colours = rng.integers(0, 256, size=(200, 3), dtype=np.uint8)
    return Scan(points_m, colours, np.arange(200) // 50)


def _quantity(value: float) -> Quantity:
    return Quantity(value, 0.001, Interval(0.95, value - 0.002, value + 0.002))


@pytest.fixture
def result() -> FitResult:
    """An L-shaped room: a cube less a notch with two open sides and an inferred plane."""
    planes = (
        Plane(0, -1, -2.0), Plane(0, 1, 2.0), Plane(1, -1, -1.5), Plane(1, 1, 1.5),
        Plane(2, -1, -1.25), Plane(2, 1, 1.25), Plane(0, 1, 1 / 3), Plane(1, 1, 0.1 + 0.2, "inferred"),
    )  # fmt: skip
    notch = dict.fromkeys(SIDES) | {"-x": 6, "-y": 7, "-z": 4, "+z": 5}
    cubes = (
        Cube("cube-0", "room", None, dict(zip(SIDES, range(6), strict=True))),
        Cube("cube-1", "notch", "cube-0", notch),
    )
    angle_rad = 0.3
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    frame = Frame(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), np.array([532_145.1, 5_801_223.2, 34.7]))
    ring_m = np.array([[-2, -1.5, -1.25], [-2, 1.5, -1.25], [-2, 1.5, 1.25], [-2, -1.5, 1.25]])
    faces = tuple(
        Face(
            id=f"wall-{i + 1}", kind="wall", face_class=planes[i].face_class, room="room-1", cube="cube-0",
            side=SIDES[i], plane=i, normal=frame.directions_to_scan(np.array([1.0 - 2 * i, 0, 0])),
            rings_m=(frame.to_scan(ring_m), frame.to_scan(0.5 * ring_m[::-1])), offset_std_m=1e-4,
            n_points=120 + i, coverage=0.875, rms_m=0.005, status="observed",
        )
        for i in range(2)
    )  # fmt: skip
    dimension = Dimension(
        "A", "overall", "room-1", ("wall-1", "wall-2"), None, ring_m[0], ring_m[1], _quantity(4.0), "observed"
    )
    return FitResult(
        method="truth",
        level=0.95,
        frame=frame,
        shape=Shape(planes, cubes),
        rooms=(Room("room-1", "cube-0", _quantity(10.0), _quantity(25.0), _quantity(14.0)),),
        faces=faces,
        dimensions=(dimension,),
        meshes=(),
        noise={"sigma_m": np.float64(0.005), "knots": np.array([1.0, np.nan]), "explanation": "Größe"},
        notes=(Note("WALL_INFERRED", "wall-8 has no points.", ("wall-8",)),),
        provenance={"version": "0.1.0", "input": {"name": "scan.ply", "sha256": None}, "seed": 1},
        converged=True,
    )
