"""From a plan to the cube grammar and back: whatever the plan, the tree says the same."""

import numpy as np
import pytest
from hypothesis import given

from indoorfit.geometry import exposures, shape_from_plan
from indoorfit.model import SIDES, Shape, side_sign
from indoorfit.simulate import room_shape
from synthetic import KINDS, plans


def inside(shape: Shape, points_m: np.ndarray, cube_id: str) -> np.ndarray:
    """Cube minus children, straight from the definition of the grammar."""
    low, high = shape.bounds_m()[cube_id]
    result = np.all((points_m > low) & (points_m < high), axis=1)
    for child in shape.children(cube_id):
        result &= ~inside(shape, points_m, child.id)
    return result


def cell_centres(x, y, z) -> np.ndarray:
    u, v = np.meshgrid(x[:-1] + np.diff(x) / 2, y[:-1] + np.diff(y) / 2, indexing="ij")
    return np.column_stack([u.ravel(), v.ravel(), np.full(u.size, np.mean(z))])


@given(plan=plans())
def test_shape_reproduces_the_mask_of_any_plan(plan):
    x, y, mask, z = plan
    shape = shape_from_plan(x, y, [mask], [z])
    found = inside(shape, cell_centres(x, y, z), shape.rooms[0].id)
    np.testing.assert_array_equal(found.reshape(mask.shape), mask)


@given(plan=plans())
def test_tree_is_well_formed(plan):
    x, y, mask, z = plan
    shape = shape_from_plan(x, y, [mask], [z])
    seen = set()
    used = []
    for cube in shape.cubes:
        assert (cube.parent is None) == (cube.role == "room")
        assert cube.parent is None or cube.parent in seen, "parents come before their children"
        assert set(cube.sides) == set(SIDES)
        assert cube.role != "pillar" or set(cube.open_sides) == {"-z", "+z"}
        seen.add(cube.id)
        used += [k for k in cube.sides.values() if k is not None]
    # No two cubes share a parameter, and none is left over.
    assert sorted(used) == list(range(len(shape.planes)))


@given(plan=plans())
def test_every_plane_says_which_way_is_out(plan):
    x, y, mask, z = plan
    shape = shape_from_plan(x, y, [mask], [z])
    root = shape.rooms[0].id
    for exposure in exposures(shape):
        plane = shape.planes[exposure.plane]
        i, j = np.nonzero(exposure.mask)
        others = [a for a in range(3) if a != plane.axis]
        spots = np.empty((len(i), 3))
        spots[:, others[0]] = (exposure.u_m[i] + exposure.u_m[i + 1]) / 2
        spots[:, others[1]] = (exposure.v_m[j] + exposure.v_m[j + 1]) / 2
        # A centimetre: a tenth of the thinnest cell that the strategy makes.
        for sign, expected in ((-1, True), (1, False)):
            spots[:, plane.axis] = plane.offset_m + sign * plane.outward * 0.01
            assert np.all(inside(shape, spots, root) == expected)


@pytest.mark.parametrize("kind", KINDS)
def test_moving_planes_keeps_the_tree(kind):
    shape = room_shape(kind)
    moved = shape.with_offsets(shape.offsets_m + 0.01)
    assert moved.cubes == shape.cubes
    # Rounding: 0.01 is added to numbers of order 5.
    np.testing.assert_allclose(moved.offsets_m - shape.offsets_m, 0.01, atol=1e-12)


def test_open_sides_lie_beyond_the_parent():
    shape = room_shape("stair")
    bounds = shape.bounds_m()
    for cube in shape.cubes:
        for side in cube.open_sides:
            end, axis = int(side_sign(side) > 0), "xyz".index(side[1])
            assert cube.parent is not None
            beyond = bounds[cube.id][end, axis] - bounds[cube.parent][end, axis]
            assert beyond * side_sign(side) > 0


def test_a_hole_is_a_pillar_and_a_missing_corner_a_notch():
    mask = np.ones((3, 3), bool)
    mask[1, 1] = mask[2, 2] = False
    lines_m = [0.0, 1.0, 2.0, 3.0]
    shape = shape_from_plan(lines_m, lines_m, [mask], [(0.0, 2.5)])
    # The two cells meet in a corner only, so they are two cubes.
    assert [cube.role for cube in shape.cubes] == ["room", "pillar", "notch"]


def test_two_rooms_share_no_plane_even_where_they_touch():
    masks = [np.array([[True], [False]]), np.array([[False], [True]])]
    shape = shape_from_plan([0.0, 2.0, 5.0], [0.0, 3.0], masks, [(0.0, 2.5), (0.1, 2.4)])
    assert len(shape.rooms) == 2
    assert len(shape.planes) == 12
