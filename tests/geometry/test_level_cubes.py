"""Levels of floor and ceiling as cubes: the solid is what lies between them, whatever their outlines."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from indoorfit.geometry import Level, exposures, shape_from_plan, with_levels
from indoorfit.model import Shape
from indoorfit.solid import face_polygons, subtract_cubes
from synthetic import plans, touches_by_corner

X, Y, Z = [0.0, 1.0, 3.0, 4.5], [0.0, 2.0, 2.4, 4.0], (0.0, 2.6)


def cells(*rows: str) -> np.ndarray:
    """A mask as one sees it from above: the first row has the largest y."""
    return np.array([[cell == "#" for cell in row] for row in reversed(rows)]).T


ROOM = cells("###", "###", "###")
L_ROOM = cells("#..", "###", "###")


def leveled(room: np.ndarray, *levels: Level) -> Shape:
    return with_levels(shape_from_plan(X, Y, [room], [Z]), X, Y, [room], levels)


@st.composite
def stepped_plans(draw):
    """A plan with up to three heights of floor and of ceiling, scattered over its cells."""
    x, y, mask, z = draw(plans(side=4))
    heights = []
    for base, sign in zip(z, (1.0, -1.0), strict=True):
        rises = [0.0, *draw(st.lists(st.floats(0.1, 0.9), max_size=2, unique=True))]
        index = draw(st.lists(st.integers(0, len(rises) - 1), min_size=mask.size, max_size=mask.size))
        heights.append(base + sign * np.array(rises)[np.array(index)].reshape(mask.shape))
    return x, y, mask, z, heights[0], heights[1]


def shape_of(plan) -> Shape:
    x, y, mask, z, floor, ceiling = plan
    levels = [
        Level(0, on, float(height), mask & (heights == height))
        for on, heights, base in (("floor", floor, z[0]), ("ceiling", ceiling, z[1]))
        for height in np.unique(heights[mask])
        if height != base
    ]
    return with_levels(shape_from_plan(x, y, [mask], [z]), x, y, [mask], levels)


@given(plan=stepped_plans())
def test_room_is_what_lies_between_its_levels(plan):
    x, y, mask, _, floor, ceiling = plan
    shape = shape_of(plan)
    expected = float(np.sum(np.outer(np.diff(x), np.diff(y)) * np.where(mask, ceiling - floor, 0.0)))
    # Open sides reach a metre beyond the room, on a boolean that is exact but for 1e-6 m of merging.
    assert subtract_cubes(shape, shape.rooms[0]).volume_m3 == pytest.approx(expected, abs=1e-3)


@given(plan=stepped_plans())
def test_exposures_are_the_surface_of_the_solid(plan):
    assume(not touches_by_corner(plan[2]))
    shape = shape_of(plan)
    areas = np.zeros(len(shape.planes))
    for polygon in face_polygons(subtract_cubes(shape, shape.rooms[0])):
        areas[polygon.plane] += polygon.area_m2
    # Where the ends of two levels lie in one plane by chance, which of them has the common part is open.
    places = [(plane.axis, plane.outward, plane.offset_m) for plane in shape.planes]
    index = np.array([places.index(place) for place in places])
    exposed = np.bincount(index, [e.area_m2 for e in exposures(shape)])
    # Merged within 1e-6 m along at most 100 m of edges.
    np.testing.assert_allclose(exposed, np.bincount(index, areas), atol=1e-3)


def test_a_beam_from_wall_to_wall_has_three_planes_of_its_own():
    shape = leveled(ROOM, Level(0, "ceiling", 2.3, cells("...", "###", "...")))
    beam = shape.cubes[-1]
    assert (beam.role, beam.open_sides) == ("beam", ("-x", "+x", "+z"))
    assert len(shape.planes) == 6 + 3


def test_a_lowered_end_of_the_ceiling_is_a_step_and_a_podium_a_platform():
    end, podium = cells("#..", "#..", "#.."), cells("...", ".#.", "...")
    shape = leveled(ROOM, Level(0, "ceiling", 2.3, end), Level(0, "floor", 0.2, podium))
    assert [cube.role for cube in shape.cubes] == ["room", "platform", "step"]


def test_a_beam_that_a_notch_interrupts_is_one_cube():
    u_room = cells("#.#", "###", "###")
    shape = leveled(u_room, Level(0, "ceiling", 2.3, cells("#.#", "...", "...")))
    assert [cube.role for cube in shape.cubes] == ["room", "notch", "step"]


def test_a_level_between_walls_shares_their_planes_instead_of_adding_its_own():
    """In the arm of an L a platform ends at the arm's own wall; its front continues the other wall."""
    shape = leveled(L_ROOM, Level(0, "floor", 0.2, cells("#..", "...", "...")))
    assert shape.cubes[-1].role == "step"
    # The top is one more plane, the front is the notch's wall over the arm's width.
    assert len(shape.planes) == len(leveled(L_ROOM).planes) + 1
    walls = [face for face in face_polygons(subtract_cubes(shape, shape.rooms[0]))]
    assert len(walls) == 8 + 1


def test_stairs_rest_on_each_other_with_one_face_for_each_rise():
    shape = leveled(
        ROOM,
        Level(0, "floor", 0.17, cells(".#.", ".#.", ".#.")),
        Level(0, "floor", 0.34, cells("..#", "..#", "..#")),
    )
    upright = [k for k, plane in enumerate(shape.planes) if plane.axis == 0]
    assert len(upright) == 2 + 2
    areas = [exposures(shape)[k].area_m2 for k in upright[2:]]
    np.testing.assert_allclose(areas, [0.17 * 4.0, 0.17 * 4.0], atol=1e-12)
