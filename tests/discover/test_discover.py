"""The structure of a room is found whatever hides its walls, and what is no room is refused."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from indoorfit.errors import InputError
from indoorfit.geometry import exposures
from indoorfit.model import Scan, Shape
from synthetic import KINDS, discovered, virtual


def outline(shape: Shape, role: str) -> np.ndarray:
    """What two grammars of one room share in any frame: the sizes of the cubes, each in increasing order."""
    bounds = shape.bounds_m()
    cubes = [bounds[cube.id] for cube in shape.cubes if cube.role == role]
    return np.array([np.sort(high - low) for low, high in cubes]).reshape(-1, 3)


def assert_same_room(found: Shape, true: Shape, limit_m: float) -> None:
    """Every cube of one grammar has its like in the other, one to one."""
    for role in ("room", "notch", "pillar", "part"):
        a, b = outline(found, role), outline(true, role)
        assert len(a) == len(b), f"{len(a)} instead of {len(b)} cubes are a {role}"
        misfit = np.abs(a[:, None] - b[None]).max(axis=2)
        rows, columns = linear_sum_assignment(misfit)
        assert misfit[rows, columns].max(initial=0.0) < limit_m


LIMIT_M = 0.01
"""Discovery places planes at medians of surfels; a centimetre is a tenth of what the fit's reach allows."""


@pytest.mark.parametrize("kind", KINDS)
def test_cubes_of_every_kind_of_room_are_found(kind):
    scan = virtual(kind, 1, n_points=40_000, yaw_deg=28, tilt_deg=3, azimuth_deg=70)
    shape, _ = discovered(scan.scan)
    assert_same_room(shape, scan.shape, LIMIT_M)
    assert all(plane.status == "observed" for plane in shape.planes)
    assert all(exposure.area_m2 > 0 for exposure in exposures(shape))


@pytest.mark.parametrize("kind", ["box", "L", "U", "stair"])
@pytest.mark.parametrize("seed", [1, 2])
def test_furniture_and_windows_are_not_part_of_the_room(kind, seed):
    scan = virtual(kind, seed, n_points=50_000, yaw_deg=64, n_furniture=2, n_windows=2, furniture_hides=True)
    shape, _ = discovered(scan.scan)
    assert_same_room(shape, scan.shape, LIMIT_M)


@pytest.mark.parametrize("kind", ["box", "L", "T"])
def test_a_wall_that_nobody_saw_is_inferred_where_floor_and_ceiling_end(kind):
    plane = 2  # The first wall of the room's own cube: -x.
    scan = virtual(kind, 3, n_points=50_000, missing_planes=(plane,))
    shape, _ = discovered(scan.scan)
    inferred = [p for p in shape.planes if p.status == "inferred"]
    assert len(inferred) == 1
    # Floor and ceiling end within a surfel's spacing, some 6 cm; hence half of that and the noise.
    assert_same_room(shape, scan.shape, 0.05)


@pytest.mark.parametrize("kind", ["box", "L"])
def test_a_room_without_ceiling_keeps_its_walls_and_takes_its_height_from_them(kind):
    scan = virtual(kind, 4, n_points=50_000, missing_planes=(1,))
    shape, _ = discovered(scan.scan)
    (ceiling,) = [p for p in shape.planes if p.face_class == "ceiling"]
    assert ceiling.status == "inferred"
    # The top of the walls: the 99th percentile of 2.7 m of surfels, a few centimetres below.
    assert_same_room(shape, scan.shape, 0.10)


@pytest.mark.parametrize(("kind", "walls", "seed"), [("box", 4, 2), ("box", 4, 6), ("L", 6, 5)])
def test_a_wall_that_is_seen_twice_is_one_where_the_floor_is_seen_twice(kind, walls, seed):
    """Eight stretches of the scan, each displaced by some 5 cm: steps in every wall, and in the floor too."""
    scan = virtual(kind, 4, n_points=50_000)
    points_m = scan.frame.to_manhattan(scan.scan.points_m)
    x_m, y_m = (points_m - points_m.mean(axis=0))[:, :2].T
    stretch = np.floor(np.arctan2(y_m, x_m) / (np.pi / 4)).astype(int) + 4
    shifts_m = np.random.default_rng(seed).normal(0.0, 0.05, (9, 3))
    shape, notes = discovered(Scan(scan.frame.to_scan(points_m + shifts_m[stretch])))
    assert sum(plane.axis < 2 for plane in shape.planes) == walls
    assert [note.code for note in notes if note.code.endswith("STEP")] == []


def test_a_cloud_without_floor_is_refused():
    scan = virtual("box", 5, n_points=40_000, missing_planes=(0,))
    with pytest.raises(InputError, match=r"no floor.*Fix:"):
        discovered(scan.scan)


def test_a_table_is_no_floor():
    scan = virtual("box", 6, n_points=40_000, missing_planes=(0,), n_furniture=3)
    with pytest.raises(InputError, match=r"no floor.*Fix:"):
        discovered(scan.scan)


def test_what_one_wall_and_a_floor_leave_open_is_inferred():
    rng = np.random.default_rng(7)
    floor = rng.uniform(0, 1, (10_000, 3)) * (4, 3, 0)
    wall = rng.uniform(0, 1, (10_000, 3)) * (4, 0, 2.5)
    scan = Scan(np.vstack([floor, wall]) + rng.normal(0, 0.004, (20_000, 3)))
    shape, _ = discovered(scan)
    observed = [plane for plane in shape.planes if plane.status == "observed"]
    assert sorted((plane.axis, plane.outward) for plane in observed) == [(1, -1), (2, -1)]
    # The floor is 4 m by 3 m, and its edges are known to a few pixels.
    for axis, size_m in enumerate((4.0, 3.0)):
        low, high = sorted(plane.offset_m for plane in shape.planes if plane.axis == axis)
        assert high - low == pytest.approx(size_m, abs=0.1)


@pytest.mark.parametrize("partition_m", [0.12, 0.15, 0.25])
def test_two_rooms_side_by_side_are_two_with_a_wall_between(partition_m):
    first, second = virtual("box", 8, n_points=100_000), virtual("box", 9, n_points=100_000)
    beside_m = np.array([5.0 + partition_m, 0.0, 0.0])
    points_m = np.vstack([first.scan.points_m, second.scan.points_m + beside_m])
    shape, _ = discovered(Scan(points_m))
    assert len(shape.rooms) == 2
    assert len(shape.planes) == 12
    for room in shape.rooms:
        low, high = shape.bounds_m()[room.id]
        np.testing.assert_allclose(np.sort(high - low), (2.7, 4.0, 5.0), atol=LIMIT_M)


def test_a_low_room_beside_a_high_one_is_a_room():
    """Its ceiling is as low as the head of a door, which is no ceiling, but it is as wide as a room."""
    high, low = virtual("box", 8, n_points=100_000), virtual("box", 9, n_points=100_000)
    of_low_m = low.scan.points_m * [0.6, 1.0, 2.05 / 2.7] + [4.15, 0.0, 0.0]
    shape, _ = discovered(Scan(np.vstack([high.scan.points_m, of_low_m])))
    heights_m = [np.ptp(shape.bounds_m()[room.id][:, 2]) for room in shape.rooms]
    np.testing.assert_allclose(heights_m, (2.7, 2.05), atol=LIMIT_M)


def test_a_floor_half_way_up_is_told():
    low, high = virtual("box", 8, n_points=100_000), virtual("box", 9, n_points=100_000)
    for rise_m, told in ((1.0, True), (0.0, False)):
        beside_m = np.array([5.15, 0.0, rise_m])
        points_m = np.vstack([low.scan.points_m, high.scan.points_m + beside_m])
        _, notes = discovered(Scan(points_m))
        assert ("SPLIT_LEVEL" in [note.code for note in notes]) == told


def test_same_scan_gives_the_same_shape():
    scan = virtual("X", 11, n_points=30_000, yaw_deg=10).scan
    assert discovered(scan)[0] == discovered(scan)[0]


def test_a_roof_covers_a_corner_of_which_the_floor_was_not_seen():
    rng = np.random.default_rng(0)

    def sheet(corner, u, v):
        corner, u, v = (np.array(side, float) for side in (corner, u, v))
        n = int(900 * np.linalg.norm(np.cross(u, v)))
        return corner + rng.random((n, 1)) * u + rng.random((n, 1)) * v

    # 6 m by 4 m, walls of 2.4 m, two slopes and a level strip along x in the middle; the floor of a corner,
    # 3 m by 1.4 m, is missing.
    parts = [sheet((0, 0, 0), (6, 0, 0), (0, 0, 2.4)), sheet((0, 4, 0), (6, 0, 0), (0, 0, 2.4))]
    parts += [sheet((x, 0, 0), (0, 4, 0), (0, 0, 2.4)) for x in (0, 6)]
    parts += [sheet((0, 0, 2.4), (6, 0, 0), (0, 1.5, 0.8)), sheet((0, 4, 2.4), (6, 0, 0), (0, -1.5, 0.8))]
    parts += [sheet((0, 1.5, 3.2), (6, 0, 0), (0, 1, 0))]
    parts += [sheet((0, 1.4, 0), (6, 0, 0), (0, 2.6, 0)), sheet((0, 0, 0), (3, 0, 0), (0, 1.4, 0))]
    points_m = np.concatenate(parts)
    shape, notes = discovered(Scan(points_m + rng.normal(0.0, 0.004, points_m.shape)))
    assert outline(shape, "room")[0, 1:] == pytest.approx([4.0, 6.0], abs=LIMIT_M)
    assert len(shape.cubes) == 1
    assert "SLOPED_CEILING" in {note.code for note in notes}
