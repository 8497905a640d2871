"""The order of parallel planes: put back, any plan is again a room that can be measured."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from indoorfit.geometry import passed, reverted, shape_from_plan
from indoorfit.measure import survey
from indoorfit.model import Shape
from indoorfit.solid import face_polygons, subtract_cubes
from synthetic import plans, touches_by_corner


def scattered(shape: Shape, seed: int, by_m: float) -> Shape:
    """Every plane somewhere else."""
    moves_m = np.random.default_rng(seed).uniform(-by_m, by_m, len(shape.planes))
    return shape.with_offsets(shape.offsets_m + moves_m)


@given(plan=plans(), seed=st.integers(0, 1000), by_m=st.floats(0.01, 3.0))
@settings(deadline=None)
def test_wherever_planes_went_put_back_they_are_in_order(plan, seed, by_m):
    x, y, mask, z = plan
    before = shape_from_plan(x, y, [mask], [z])
    after = scattered(before, seed, by_m)
    ordered, back = reverted(before, after)
    assert passed(before, ordered) == []
    assert (not back) == (passed(before, after) == [])
    # What is not put back stays where it went, to the bit.
    others = np.setdiff1d(np.arange(len(before.planes)), back)
    np.testing.assert_array_equal(ordered.offsets_m[others], after.offsets_m[others])


@given(plan=plans(), seed=st.integers(0, 1000))
@settings(deadline=None, max_examples=50)
def test_a_room_in_order_encloses_its_faces_wherever_its_planes_went(plan, seed):
    x, y, mask, z = plan
    # Two cells that meet in a corner alone are no solid.
    assume(not touches_by_corner(mask))
    before = shape_from_plan(x, y, [mask], [z])
    ordered, _ = reverted(before, scattered(before, seed, 0.3))
    solids = [subtract_cubes(ordered, room) for room in ordered.rooms]
    found = survey(ordered, solids, [face_polygons(solid) for solid in solids])
    assert {face.polygon.plane for face in found.faces} == set(range(len(before.planes)))


def test_an_end_that_leaves_the_rooms_box_has_passed_the_one_beside_it():
    """Two arms of a U that end within a hand's breadth: the longer one is the side of the box."""
    mask = np.array([[True, True, True], [True, False, False], [True, True, False]])
    before = shape_from_plan([0.0, 1.0, 2.0, 3.0], [0.0, 1.5, 3.0, 3.05], [mask], [(0.0, 2.5)])
    ends = [k for k, plane in enumerate(before.planes) if plane.axis == 1 and plane.offset_m >= 3.0]
    shorter, longer = sorted(ends, key=lambda k: before.planes[k].offset_m)
    offsets_m = before.offsets_m
    offsets_m[shorter] = 3.06
    after = before.with_offsets(offsets_m)
    assert passed(before, after) == [(shorter, longer)]
    assert reverted(before, after)[0].offsets_m[shorter] == 3.0


def test_planes_of_different_rooms_have_no_order():
    """The two sides of a partition may pass each other where registration slipped; both rooms stay whole."""
    left, right = np.array([[True], [False], [False]]), np.array([[False], [False], [True]])
    before = shape_from_plan([0.0, 3.0, 3.1, 6.0], [0.0, 4.0], [left, right], [(0.0, 2.5)] * 2)
    sides = [k for k, plane in enumerate(before.planes) if plane.axis == 0 and plane.offset_m in (3.0, 3.1)]
    assert len(sides) == 2
    offsets_m = before.offsets_m
    offsets_m[sides] = offsets_m[sides[::-1]]
    assert passed(before, before.with_offsets(offsets_m)) == []
