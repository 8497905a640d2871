"""Oblique walls in the tree of cubes: surface, solid and plan agree wherever the wall runs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.geometry import Level, exposures, shape_from_plan, with_levels, with_oblique_wall
from indoorfit.model import Shape
from indoorfit.solid import face_polygons, subtract_cubes

L_ROOM = shape_from_plan(
    [0.0, 2.0, 5.0], [0.0, 3.0, 4.0], [np.array([[True, True], [True, False]])], [(0.0, 2.5)]
)


def cut(shape: Shape, cube: str, sides: tuple, leg_x_m: float, leg_y_m: float, opens: bool = False) -> Shape:
    """Cut a corner off between the ends of its two legs."""
    sides_of = next(c.sides for c in shape.cubes if c.id == cube)
    between = (sides_of[sides[0]], sides_of[sides[1]])
    tip_m = shape.corner_m(*between)
    towards = np.array([1.0 if side[0] == "-" else -1.0 for side in sides])
    legs_m = towards * (leg_x_m, leg_y_m)
    on_x, on_y = tip_m + legs_m * [0.0, 1.0], tip_m + legs_m * [1.0, 0.0]
    normal = np.array([on_y[1] - on_x[1], on_x[0] - on_y[0]])
    normal *= np.sign(normal @ (tip_m - on_x)) * (-1.0 if opens else 1.0) / np.linalg.norm(normal)
    return with_oblique_wall(
        shape, between, float(np.arctan2(normal[1], normal[0])), float(normal @ on_x), opens
    )


CORNERS = [("cube-0", ("-x", "-y"), False), ("cube-0", ("+x", "-y"), False), ("cube-0", ("-x", "+y"), False)]
EDGE = ("cube-1", ("-x", "-y"), True)


@given(st.floats(0.1, 0.9), st.floats(0.1, 0.9), st.sampled_from([*CORNERS, EDGE]))
def test_the_surface_is_that_of_the_solid(leg_x_m, leg_y_m, where):
    cube, sides, opens = where
    shape = cut(L_ROOM, cube, sides, leg_x_m, leg_y_m, opens)
    solid = subtract_cubes(shape, shape.rooms[0])
    whole = subtract_cubes(L_ROOM, L_ROOM.rooms[0])
    assert solid.is_closed
    half = 0.5 * leg_x_m * leg_y_m * 2.5
    assert solid.volume_m3 - whole.volume_m3 == pytest.approx(half if opens else -half, abs=1e-6)
    area_m2 = dict.fromkeys(range(len(shape.planes)), 0.0)
    for face in face_polygons(solid):
        area_m2[face.plane] += face.area_m2
    for exposure in exposures(shape):
        # The solid is simplified by a micrometre, over edges of some metres.
        assert exposure.area_m2 == pytest.approx(area_m2[exposure.plane], abs=1e-5)


def test_places_on_a_floor_are_told_from_those_behind_the_oblique_wall():
    shape = cut(L_ROOM, "cube-0", ("-x", "-y"), 1.0, 1.0)
    floor = exposures(shape)[0]
    places = np.array([[0.6, 0.6, 0.0], [0.4, 0.4, 0.0], [0.52, 0.52, 0.0]])
    assert floor.contains(places).tolist() == [True, False, True]
    # The third lies 2.8 cm before the wall.
    assert floor.contains(places, 0.05).tolist() == [True, False, False]
    assert floor.contains(places, -0.2).tolist() == [True, True, True]


def test_parameters_come_back_as_they_went_in():
    shape = cut(cut(L_ROOM, *EDGE[:2], 0.5, 0.4, opens=True), "cube-0", ("-x", "-y"), 1.0, 0.7)
    assert shape.with_parameters(shape.parameters) == shape
    moved = shape.with_parameters(shape.parameters + 0.01)
    np.testing.assert_allclose(moved.parameters - shape.parameters, 0.01, atol=1e-15)
    assert shape.squared.cubes == L_ROOM.cubes


def test_the_cube_behind_an_oblique_wall_reaches_nothing_else():
    """At the inner corner of an L the line of the wall runs on into the other arm."""
    shape = cut(L_ROOM, "cube-0", ("-x", "+y"), 0.5, 0.5)
    volume = subtract_cubes(shape, shape.rooms[0]).volume_m3
    low = cut(L_ROOM, "cube-0", ("-x", "-y"), 0.5, 0.5)
    assert volume == pytest.approx(subtract_cubes(low, low.rooms[0]).volume_m3, abs=1e-6)


def test_an_oblique_wall_may_stand_in_the_place_of_another():
    box = shape_from_plan([0.0, 5.0], [0.0, 4.0], [np.array([[True]])], [(0.0, 2.5)])
    shape = cut(box, "cube-0", ("+x", "+y"), 0.8, 4.0)
    solid = subtract_cubes(shape, shape.rooms[0])
    assert solid.is_closed
    assert solid.volume_m3 == pytest.approx(2.5 * (20.0 - 0.5 * 0.8 * 4.0), abs=1e-6)
    # Floor, ceiling, three walls and the oblique one: what it replaced is no face.
    assert len(face_polygons(solid)) == 6
    areas_m2 = [exposure.area_m2 for exposure in exposures(shape)]
    replaced = shape.rooms[0].sides["+x"]
    assert areas_m2[replaced] == pytest.approx(0.0, abs=1e-9)
    assert sum(areas_m2) == pytest.approx(sum(face.area_m2 for face in face_polygons(solid)), abs=1e-5)


BOX = shape_from_plan([0.0, 5.0], [0.0, 4.0], [np.array([[True]])], [(0.0, 2.5)])


def same_surface(shape: Shape) -> None:
    area_m2 = dict.fromkeys(range(len(shape.planes)), 0.0)
    for face in face_polygons(subtract_cubes(shape, shape.rooms[0])):
        area_m2[face.plane] += face.area_m2
    # The solid is simplified by a micrometre, over edges of some metres.
    assert [e.area_m2 for e in exposures(shape)] == pytest.approx(list(area_m2.values()), abs=1e-5)


@given(st.floats(0.5, 1.5), st.floats(2.0, 2.5))
def test_two_oblique_walls_may_meet_where_a_wall_was(leg_x_m, leg_y_m):
    """The gable end of a plan: each ends where the other begins, and floor behind both is missing once."""
    shape = cut(BOX, "cube-0", ("+x", "+y"), leg_x_m, leg_y_m)
    same_surface(cut(shape, "cube-0", ("+x", "-y"), leg_x_m, leg_y_m))


@given(st.floats(0.2, 1.5), st.floats(0.2, 1.5), st.sampled_from(["floor", "ceiling"]))
def test_levels_that_an_oblique_wall_crosses_end_there(leg_x_m, leg_y_m, on):
    x, y = [0.0, 4.2, 4.7, 5.0], [0.0, 3.3, 3.7, 4.0]
    at = np.zeros((3, 3), bool)
    at[1] = True
    levels = [Level(0, on, 0.3 if on == "floor" else 2.2, at)]
    shape = with_levels(BOX, x, y, [np.ones((3, 3), bool)], levels)
    same_surface(cut(shape, "cube-0", ("+x", "+y"), leg_x_m, leg_y_m))
