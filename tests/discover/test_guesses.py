"""A wall in a shadow is put where it may be, with an uncertainty that reaches over the shadow."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from indoorfit.config import RunConfig
from indoorfit.discover.outline import Place, n_corners, walls_of, with_moved
from indoorfit.evaluate import compare
from indoorfit.model import Scan
from indoorfit.pipeline import fit_scan
from indoorfit.simulate.virtual import VirtualScan
from indoorfit.texture import TextureConfig
from synthetic import discovered, plans, truth_of, virtual

_SLOPE = 0.2
"""Of the shadow's edge: lines of sight from far beside the notch."""


def shadowed(virtual_scan: VirtualScan, depth_m: float) -> tuple[Scan, np.ndarray]:
    """The scan of a U without the end of one arm: as seen from beside the notch, behind its edge.

    Returns:
        the scan; the places across the hidden wall, from where the last was seen to where the wall is.
    """
    bounds, shape = virtual_scan.shape.bounds_m(), virtual_scan.shape
    room = bounds[shape.rooms[0].id]
    notch = next(cube for cube in shape.cubes if cube.role == "notch")
    (side,) = (side for side in notch.open_sides if side[1] != "z")
    across = "xyz".index(side[1])
    sign = 1.0 if side[0] == "+" else -1.0
    wall_m = room[1 if sign > 0 else 0][across]
    edge_m = bounds[notch.id][1][1 - across]
    points_m = virtual_scan.frame.to_manhattan(virtual_scan.scan.points_m)
    behind_m = points_m[:, 1 - across] - edge_m
    before_m = sign * (wall_m - points_m[:, across])
    # The line of sight past the edge: what is farther round it is dark, and so is the notch's own side.
    dark = (behind_m > -0.03) & (before_m < depth_m - _SLOPE * behind_m)
    width_m = room[1][1 - across] - edge_m
    places_m = np.sort([wall_m - sign * (depth_m - _SLOPE * width_m), wall_m])
    scan = virtual_scan.scan
    return replace(scan, points_m=scan.points_m[~dark]), places_m


@pytest.mark.parametrize("depth_m", [0.9, 1.3])
def test_a_hidden_wall_is_put_where_it_may_be_and_its_doubt_reaches_over_the_shadow(depth_m):
    whole = virtual("U", 4, n_points=60_000)
    scan, places_m = shadowed(whole, depth_m)
    shape, _ = discovered(scan)
    walls = [plane for plane in shape.planes if (plane.axis, plane.outward) == (1, 1)]
    # The other arm's end was seen, and both end together.
    seen_m = max(plane.offset_m for plane in walls if plane.status == "observed")
    (hidden,) = [plane for plane in walls if plane.status == "inferred"]
    for place_m in places_m - places_m.max() + seen_m:
        assert abs(hidden.offset_m - place_m) < 2.0 * hidden.doubt_m
    assert 2.0 * hidden.doubt_m < depth_m, "the shadow is no deeper"


def test_the_intervals_of_a_room_with_a_hidden_wall_hold_and_the_note_says_how_far_it_may_be_off():
    whole = virtual("U", 4, n_points=60_000, yaw_deg=20)
    scan, _ = shadowed(whole, 0.9)
    result = fit_scan(scan, RunConfig(texture=TextureConfig(enabled=False)))
    (note,) = [note for note in result.notes if note.code == "FACE_INFERRED"]
    assert "it may be off" in note.message
    found = compare(result, truth_of(whole))
    assert found.right, found.faults
    inferred = [check for check in found.lengths if check.status == "inferred"]
    assert inferred
    assert all(check.hit for check in inferred)


def test_a_wall_at_the_end_of_floor_and_ceiling_was_measured():
    shape, _ = discovered(virtual("L", 3, n_points=50_000, missing_planes=(2,)).scan)
    (wall,) = [plane for plane in shape.planes if plane.status == "inferred"]
    assert wall.doubt_m == 0.0


@given(plans(), st.data())
def test_moving_a_wall_keeps_the_corners_and_adds_its_strip(plan, data):
    x, y, cells, _ = plan
    grid = (np.array(x), np.array(y))
    wall = data.draw(st.sampled_from(walls_of(0, cells)))
    behind = wall.line - 1 if wall.outward > 0 else wall.line
    share = data.draw(st.floats(0.2, 0.8))
    lines_m = grid[wall.axis]
    place = Place(float(lines_m[behind] + share * (lines_m[behind + 1] - lines_m[behind])), 0.1)
    found = with_moved([cells], grid, [(wall, place)])
    assert n_corners(found.rooms[0]) == n_corners(cells)
    area_m2 = [
        float(np.sum(mask * np.outer(*(np.diff(line) for line in lines))))
        for mask, lines in ((cells, grid), (found.rooms[0], found.grid))
    ]
    ends_m = grid[1 - wall.axis][[wall.cells.start, wall.cells.stop]]
    strip_m2 = wall.outward * (place.offset_m - lines_m[wall.line]) * (ends_m[1] - ends_m[0])
    # Rounding of sums of a few square metres.
    assert found.moved == ((wall, place),)
    assert area_m2[1] - area_m2[0] == pytest.approx(strip_m2, abs=1e-9)
    assert found.doubt_m(0, wall.axis, wall.outward, place.offset_m) == 0.1


def test_two_rooms_whose_facing_walls_nobody_saw_do_not_run_into_each_other():
    grid = (np.array([0.0, 3.0, 4.0, 7.0]), np.array([0.0, 4.0]))
    rooms = [np.array([[True], [False], [False]]), np.array([[False], [False], [True]])]
    facing = [
        next(wall for wall in walls_of(room, cells) if wall.axis == 0 and wall.outward == outward)
        for room, (cells, outward) in enumerate(zip(rooms, (1, -1), strict=True))
    ]
    moves = list(zip(facing, (Place(3.6, 0.3), Place(3.4, 0.3)), strict=True))
    found = with_moved(rooms, grid, moves)
    assert not np.any(found.rooms[0] & found.rooms[1])
    # The other one stays, and is no better known for it.
    assert found.moved[0] == moves[0]
    wall, place = found.moved[1]
    assert (wall, place.offset_m) == (facing[1], 4.0)
    assert found.doubt_m(1, 0, -1, 4.0) == pytest.approx(np.hypot(0.3, 0.6))


def test_a_wall_that_stays_leaves_its_doubt_to_no_other_wall_of_its_line():
    # A U whose arms end on one line; a move that would make a corner less is left out.
    grid = (np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 2.0, 4.0]))
    cells = np.array([[True, True], [True, False], [True, True]])
    ends = [wall for wall in walls_of(0, cells) if wall.axis == 1 and wall.line == 2]
    assert len(ends) == 2
    found = with_moved([cells], grid, [(ends[0], Place(2.0, 0.3))])
    assert found.moved == ()
    np.testing.assert_array_equal(found.rooms[0], cells)


@given(plans(), st.data())
def test_walls_moved_all_at_once_leave_a_room_of_the_same_shape(plan, data):
    x, y, cells, _ = plan
    grid = (np.array(x), np.array(y))
    walls = walls_of(0, cells)
    places = [
        Place(data.draw(st.floats(float(grid[wall.axis][0]), float(grid[wall.axis][-1]))), 0.1)
        for wall in walls
    ]
    found = with_moved([cells], grid, list(zip(walls, places, strict=True)))
    assert ndimage.label(found.rooms[0])[1] == 1
    assert n_corners(found.rooms[0]) == n_corners(cells)
