"""What is measured, how it is named, and how it changes when a wall moves."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given

from indoorfit.errors import IndoorfitError
from indoorfit.geometry import Level, shape_from_plan, with_levels, with_oblique_wall
from indoorfit.measure import Survey, face_notes, measurands, survey
from indoorfit.model import Frame, Shape
from indoorfit.pipeline import truth_result
from indoorfit.simulate import room_shape
from indoorfit.solid import face_polygons, subtract_cubes
from synthetic import KINDS, plans, touches_by_corner


def survey_of(shape: Shape) -> Survey:
    solids = [subtract_cubes(shape, room) for room in shape.rooms]
    return survey(shape, solids, [face_polygons(solid) for solid in solids])


def shape_of(plan) -> Shape:
    x, y, mask, z = plan
    assume(not touches_by_corner(mask))
    return shape_from_plan(x, y, [mask], [z])


def pillar_room() -> Shape:
    mask = np.ones((3, 3), bool)
    mask[1, 1] = False
    return shape_from_plan([0.0, 1.0, 2.0, 4.0], [0.0, 1.5, 2.0, 3.0], [mask], [(0.0, 2.5)])


def leveled_room() -> Shape:
    """An L with a platform in its arm, stairs of two steps beside it and a beam across."""
    x, y = [0.0, 1.0, 2.0, 4.5, 5.5], [0.0, 0.8, 1.3, 2.0, 3.0]
    mask = np.ones((4, 4), bool)
    mask[3, 3] = False
    column, row = np.indices(mask.shape)
    levels = [
        Level(0, "floor", 0.36, column == 0),
        Level(0, "floor", 0.18, column == 1),
        Level(0, "floor", 0.25, (column == 3) & mask),
        Level(0, "ceiling", 2.2, row == 1),
    ]
    return with_levels(shape_from_plan(x, y, [mask], [(0.0, 2.5)]), x, y, [mask], levels)


def oblique_room() -> Shape:
    """An L with a corner cut off at 55 degrees, and the edge of its notch at 45."""
    mask = np.array([[True, True], [True, False]])
    shape = shape_from_plan([0.0, 2.0, 5.0], [0.0, 3.0, 4.0], [mask], [(0.0, 2.5)])
    room, notch = shape.cubes
    corner = room.sides["-x"], room.sides["-y"]
    edge = notch.sides["-x"], notch.sides["-y"]
    angles = np.radians([235.0, 45.0])
    shape = with_oblique_wall(shape, corner, angles[0], float(0.8 * np.cos(angles[0])))
    through = np.array([2.4, 3.0]) @ [np.cos(angles[1]), np.sin(angles[1])]
    return with_oblique_wall(shape, edge, angles[1], float(through), opens=True)


def oblique_levels() -> Shape:
    """An oblique wall across the side of a platform and below a beam: no rectangle."""
    shape = leveled_room()
    sides, yaw_rad = shape.rooms[0].sides, float(np.radians(235.0))
    corner, end_m = (sides["-x"], sides["-y"]), 1.4
    return with_oblique_wall(shape, corner, yaw_rad, end_m * float(np.cos(yaw_rad)))


SHAPES = {kind: room_shape(kind) for kind in KINDS} | {"pillar": pillar_room(), "levels": leveled_room()}
OBLIQUE = {"oblique": oblique_room(), "oblique levels": oblique_levels()}


@pytest.mark.parametrize("kind", {**SHAPES, **OBLIQUE})
def test_gradients_are_those_of_a_rebuilt_room(kind):
    shape = {**SHAPES, **OBLIQUE}[kind]
    n = len(shape.parameters)
    for k in range(n):
        # Polynomials of degree three at most in the offsets, and smooth in yaws over angles of a radian: a
        # step of 0.1 mm costs its square, 1e-8 m, times factors of the order of 1.
        step = 1e-4 * np.eye(n)[k]
        above, below = (
            [m.value for m in measurands(survey_of(moved), moved)]
            for moved in (shape.with_parameters(shape.parameters + s * step) for s in (1, -1))
        )
        for measurand, a, b in zip(measurands(survey_of(shape), shape), above, below, strict=True):
            # The solid merges within 1e-6 m over edges of 20 m, divided by the step of 0.2 mm: 0.1 at worst;
            # in fact nothing is merged, and rounding 1e-13 / 2e-4 is what is left. Offsets themselves have
            # value 0 by definition.
            if measurand.value != 0.0:
                assert measurand.gradient[k] == pytest.approx((a - b) / 2e-4, abs=1e-6)


@pytest.mark.parametrize("kind", SHAPES)
def test_values_are_those_of_the_gradients(kind):
    """Lengths are linear, areas quadratic and volumes cubic in the offsets (Euler's theorem)."""
    shape = SHAPES[kind]
    found = survey_of(shape)
    offsets = shape.offsets_m
    for dimension in found.dimensions:
        assert dimension.measurand.gradient @ offsets == pytest.approx(dimension.measurand.value, abs=1e-12)
    for room in found.rooms:
        for measurand, degree in ((room.perimeter, 1), (room.floor_area, 2), (room.volume, 3)):
            assert measurand.gradient @ offsets == pytest.approx(degree * measurand.value, abs=1e-9)


@given(plan=plans())
def test_room_quantities_are_those_of_the_plan(plan):
    x, y, mask, z = plan
    shape = shape_of(plan)
    (room,) = survey_of(shape).rooms
    area = float(np.diff(x) @ mask @ np.diff(y))
    padded = np.pad(mask, 1).astype(int)
    across_x = np.abs(np.diff(padded, axis=0))[:, 1:-1] @ np.diff(y)
    across_y = np.diff(x) @ np.abs(np.diff(padded, axis=1))[1:-1]
    # The solid merges within 1e-6 m along at most 100 m of edges.
    assert room.floor_area.value == pytest.approx(area, abs=1e-4)
    assert room.volume.value == pytest.approx(area * (z[1] - z[0]), abs=1e-3)
    assert room.perimeter.value == pytest.approx(float(across_x.sum() + across_y.sum()), abs=1e-6)


@given(plan=plans())
def test_every_face_is_named_once_and_every_wall_measured_once(plan):
    found = survey_of(shape_of(plan))
    ids = [face.id for face in found.faces]
    assert len(set(ids)) == len(ids)
    walls = [face.id for face in found.faces if face.kind == "wall"]
    assert walls == [f"wall-{k + 1}" for k in range(len(walls))]
    measured = [dimension.wall for dimension in found.dimensions if dimension.kind == "wall"]
    assert measured == walls
    assert [d.kind for d in found.dimensions][:3] == ["overall", "overall", "height"]
    triangles = np.concatenate([face.polygon.triangles for face in found.faces])
    np.testing.assert_array_equal(np.sort(triangles), np.arange(len(found.rooms[0].solid.triangles)))


@given(plan=plans())
def test_dimensions_are_distances_between_points_on_their_faces(plan):
    shape = shape_of(plan)
    found = survey_of(shape)
    by_id = {face.id: face for face in found.faces}
    for dimension in found.dimensions:
        low, high = (shape.planes[k] for k in dimension.planes)
        assert low.axis == high.axis
        assert dimension.measurand.value > 0
        # Rounding.
        assert np.linalg.norm(dimension.to_m - dimension.from_m) == pytest.approx(
            dimension.measurand.value, abs=1e-12
        )
        assert dimension.from_m[low.axis] == low.offset_m
        assert dimension.to_m[low.axis] == pytest.approx(high.offset_m, abs=1e-12)
        assert [by_id[name].polygon.plane for name in dimension.faces] == list(dimension.planes)


@pytest.mark.parametrize("kind", SHAPES)
def test_outer_walls_are_numbered_counter_clockwise_from_the_lowest_corner(kind):
    found = survey_of(SHAPES[kind])
    feet = []
    for face in found.faces:
        if face.kind == "wall":
            feet.append(face.polygon.rings_m[0].mean(axis=0)[:2])
    loop = np.array(feet[:4] if kind == "pillar" else feet)
    x, y = loop.T
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0
    floor = next(face for face in found.faces if face.kind == "floor")
    lowest = min(tuple(corner) for corner in floor.polygon.rings_m[0])
    assert lowest in {tuple(corner) for corner in found.faces[0].polygon.rings_m[0]}


def test_lengths_of_the_thesis_room_are_those_of_table_6_1():
    lengths = [round(d.measurand.value, 12) for d in survey_of(room_shape("L")).dimensions]
    assert lengths == [5.08, 3.2, 2.7, 5.08, 1.7, 0.33, 1.5, 4.75, 3.2]


def test_two_rooms_are_numbered_on():
    masks = [np.array([[True], [False], [False]]), np.array([[False], [False], [True]])]
    shape = shape_from_plan([0.0, 3.0, 3.2, 5.0], [0.0, 3.0], masks, [(0.0, 2.5), (0.1, 2.4)])
    found = survey_of(shape)
    assert [room.id for room in found.rooms] == ["room-1", "room-2"]
    assert [face.id for face in found.faces if face.kind == "wall"] == [f"wall-{k}" for k in range(1, 9)]
    assert [face.id for face in found.faces if face.kind == "floor"] == ["floor-1", "floor-2"]
    for dimension in found.dimensions:
        assert {face.room for face in found.faces if face.id in dimension.faces} == {dimension.room}


def test_faces_in_line_of_which_none_was_seen_are_named_as_others_are():
    shape = room_shape("U")
    found = survey_of(shape)
    planes = [face.polygon.plane for face in found.faces]
    faces = [
        replace(face, status="inferred") if planes.count(face.polygon.plane) > 1 else face
        for face in found.faces
    ]
    (note,) = face_notes(shape, replace(found, faces=tuple(faces)), ())
    assert len(note.faces) == 2
    assert "in line" not in note.message


def test_unseen_faces_are_named_in_a_note():
    shape = room_shape("L")
    planes = list(shape.planes)
    planes[3] = replace(planes[3], status="inferred")
    shape = replace(shape, planes=tuple(planes))
    (note,) = face_notes(shape, survey_of(shape), ())
    assert note.code == "FACE_INFERRED"
    unseen = [face.id for face in survey_of(shape).faces if face.polygon.plane == 3]
    assert all(name in note.message for name in unseen)
    # A plane that was put back has a note of its own.
    assert face_notes(shape, survey_of(shape), (3,)) == ()
    assert face_notes(room_shape("L"), survey_of(room_shape("L")), ()) == ()


def test_dimensions_get_letters_like_columns_of_a_table():
    masks = [np.zeros((1, 9), bool) for _ in range(5)]
    for k, mask in enumerate(masks):
        mask[0, 2 * k] = True
    shape = shape_from_plan([0.0, 3.0], [3.0 * k for k in range(10)], masks, [(0.0, 2.5)] * 5)
    result = truth_result(shape, Frame(np.eye(3), np.zeros(3)), {}, 0)
    names = [dimension.id for dimension in result.dimensions]
    assert names[:2] == ["A", "B"]
    assert names[24:28] == ["Y", "Z", "AA", "AB"]
    assert len(set(names)) == len(names) == 35


@pytest.mark.parametrize("kind", ["L", "U", "stair"])
@pytest.mark.parametrize("shift_m", [-3.0, -2.0, -0.5, 0.5, 2.0, 3.0])
def test_a_wall_pushed_through_another_is_told_and_never_a_crash(kind, shift_m):
    """Least squares knows no order of walls: a narrow step may come out with its walls exchanged."""
    shape = room_shape(kind)
    for k in range(len(shape.planes)):
        moved = shape.with_offsets(shape.offsets_m + shift_m * (np.arange(len(shape.planes)) == k))
        solid = subtract_cubes(moved, moved.rooms[0])
        try:
            found = survey_of(moved)
        except IndoorfitError:
            continue
        if solid.is_closed:
            assert found.rooms[0].volume.value > 0
            assert all(dimension.measurand.value > 0 for dimension in found.dimensions)


def test_levels_add_their_clear_heights_rises_and_extents():
    found = survey_of(leveled_room())
    values = {
        kind: sorted(round(d.measurand.value, 9) for d in found.dimensions if d.kind == kind)
        for kind in ("height", "step", "width")
    }
    # The room's main levels, then every floor under the ceiling and under the beam.
    floors, ceilings = (0.0, 0.18, 0.25, 0.36), (2.5, 2.2)
    assert values["height"] == sorted(round(c - f, 9) for f in floors for c in ceilings)
    assert values["step"] == [0.18, 0.25, 0.3, 0.36]
    # Treads, beam and platform; along the walls they have the lengths that the walls have.
    assert values["width"] == [0.5, 1.0, 1.0]


def test_upright_faces_between_levels_are_steps_and_every_wall_stands_once():
    found = survey_of(leveled_room())
    (room,) = found.rooms
    kinds = [face.kind for face in found.faces]
    # A riser for each of the stairs, two sides of the beam; the platform's front continues the notch's wall.
    assert kinds.count("wall") == 6
    assert kinds.count("step") == 2 + 2
    assert room.floor_area.value == pytest.approx(5.5 * 3 - 1)
    assert room.perimeter.value == pytest.approx(17.0)


def test_first_height_of_a_room_is_that_of_its_main_levels():
    heights = [d for d in survey_of(leveled_room()).dimensions if d.kind == "height"]
    assert heights[0].measurand.value == pytest.approx(2.5)
