"""Walls between two rooms: their thickness, and the doors through them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from indoorfit.geometry import shape_from_plan
from indoorfit.measure import Survey, backings, find_doors, survey, with_thicknesses
from indoorfit.model import Frame, Shape
from indoorfit.solid import face_polygons, subtract_cubes

SPACING_M = 0.04
"""Of the points; a cell of 10 cm then holds six."""
FRAME = Frame(Rotation.from_euler("xyz", [3, -2, 40], degrees=True).as_matrix(), np.array([1e5, 2e5, 30.0]))


def two_rooms(thick_m: float, height_m: float = 2.6) -> Shape:
    """A room of 4 m and one of 3 m by 5 m side by side along x, the second 0.1 m higher."""
    masks = np.zeros((2, 3, 2), bool)
    masks[0, 0, 0] = masks[1, 2] = True
    x, y = [0.0, 4.0, 4.0 + thick_m, 7.0 + thick_m], [0.0, 3.5, 5.0]
    return shape_from_plan(x, y, list(masks), [(0.0, height_m), (0.0, height_m + 0.1)])


def survey_of(shape: Shape) -> Survey:
    solids = [subtract_cubes(shape, room) for room in shape.rooms]
    return survey(shape, solids, [face_polygons(solid) for solid in solids])


def wall_points(
    shape: Shape, hole: tuple[float, float, float, float], between: tuple[str, ...]
) -> np.ndarray:
    """Both faces of the partition without (y0, y1, z0, z1), and what of the reveal is to be there."""
    (backing,) = backings(shape, survey_of(shape))
    faces_m = [shape.planes[face.polygon.plane].offset_m for face in (backing.low, backing.high)]
    y, z = (a.ravel() for a in np.meshgrid(np.arange(0.02, 3.5, SPACING_M), np.arange(0.02, 2.6, SPACING_M)))
    kept = (y < hole[0]) | (y > hole[1]) | (z < hole[2]) | (z > hole[3])
    points = [np.column_stack([np.full(kept.sum(), x), y[kept], z[kept]]) for x in faces_m]
    across = np.linspace(*faces_m, 9)[1:-1]
    if "floor" in between:
        a, b = (c.ravel() for c in np.meshgrid(across, np.arange(hole[0], hole[1], SPACING_M)))
        points.append(np.column_stack([a, b, np.zeros(len(a))]))
    if "reveal" in between:
        for jamb in hole[:2]:
            a, b = (c.ravel() for c in np.meshgrid(across, np.arange(hole[2], hole[3], SPACING_M)))
            points.append(np.column_stack([a, np.full(len(a), jamb), b]))
    noise = np.random.default_rng(0).normal(0.0, 0.003, (sum(map(len, points)), 3))
    return np.concatenate(points) + noise


def doors_of(shape: Shape, points_m: np.ndarray):
    return find_doors(shape, FRAME, survey_of(shape), points_m, pixel_m=0.08)


DOOR = (1.0, 1.9, 0.0, 2.05)


@pytest.mark.parametrize("thick_m", [0.08, 0.15, 0.45])
def test_thickness_is_the_distance_of_the_faces_that_back_onto_each_other(thick_m):
    shape = two_rooms(thick_m)
    plain, found = survey_of(shape), with_thicknesses(shape, survey_of(shape))
    # All else keeps its place, and with it its letter.
    assert [d.kind for d in found.dimensions] == [*(d.kind for d in plain.dimensions), "thickness"]
    thickness = found.dimensions[-1]
    assert thickness.measurand.value == pytest.approx(thick_m, abs=1e-12)
    assert thickness.measurand.value == pytest.approx(
        thickness.measurand.gradient @ shape.offsets_m, abs=1e-12
    )
    assert {face.room for face in found.faces if face.id in thickness.faces} == {"room-1", "room-2"}
    np.testing.assert_allclose(thickness.to_m - thickness.from_m, (thick_m, 0.0, 0.0), atol=1e-12)


@pytest.mark.parametrize("end", [0, 1])
def test_a_wall_of_which_one_side_was_not_seen_has_no_thickness(end):
    shape = two_rooms(0.15)
    (backing,) = backings(shape, survey_of(shape))
    hidden = (backing.low, backing.high)[end].polygon.plane
    planes = list(shape.planes)
    planes[hidden] = replace(planes[hidden], status="inferred")
    shape = replace(shape, planes=tuple(planes))
    assert all(d.kind != "thickness" for d in with_thicknesses(shape, survey_of(shape)).dimensions)


@pytest.mark.parametrize("thick_m", [0.01, 0.8])
def test_a_sheet_and_a_shaft_are_no_wall(thick_m):
    shape = two_rooms(thick_m)
    assert backings(shape, survey_of(shape)) == ()


@pytest.mark.parametrize("thick_m", [0.1, 0.25])
@pytest.mark.parametrize("between", [("floor",), ("reveal",), ("floor", "reveal")], ids="+".join)
def test_an_open_door_is_found_where_it_is(thick_m, between):
    shape = two_rooms(thick_m)
    (door,) = doors_of(shape, wall_points(shape, DOOR, between))
    assert set(door.rooms) == {"room-1", "room-2"}
    assert door.evidence == ("holes", *between)
    # To the nearest points of the wall: their spacing and the noise, on either side.
    assert door.width_m == pytest.approx(0.9, abs=2 * SPACING_M + 0.02)
    assert door.height_m == pytest.approx(2.05, abs=SPACING_M + 0.02)
    sill_m = FRAME.to_manhattan(door.sill_m)
    np.testing.assert_allclose(sill_m, (4.0 + 0.5 * thick_m, 1.45, 0.0), atol=SPACING_M + 0.01)


@pytest.mark.parametrize(
    ("hole", "between"),
    [
        ((0.0, 0.0, 0.0, 0.0), ()),
        (DOOR, ()),
        ((1.0, 1.9, 0.9, 2.05), ("reveal",)),
        ((1.0, 1.3, 0.0, 2.05), ("floor", "reveal")),
    ],
    ids=["no hole", "nothing in the hole", "window", "slit"],
)
def test_what_is_no_door_is_not_called_one(hole, between):
    shape = two_rooms(0.15)
    assert doors_of(shape, wall_points(shape, hole, between)) == ()


@pytest.mark.parametrize("at_m", [-10.0, -1.45, 10.0], ids=["before", "at the origin", "behind"])
def test_where_the_origin_lies_does_not_matter(at_m):
    """Of the floor in a door of 1.1 m three cells of 10 cm are in view, just enough."""
    shape = two_rooms(0.15)
    points_m = wall_points(shape, (1.0, 2.1, 0.0, 2.05), ("floor",))
    between = (points_m[:, 0] > 4.03) & (points_m[:, 0] < 4.12)
    points_m = points_m[~between | ((points_m[:, 1] > 1.36) & (points_m[:, 1] < 1.64))]
    along_m = np.array([at_m * (plane.axis == 1) for plane in shape.planes])
    doors = doors_of(shape.with_offsets(shape.offsets_m + along_m), points_m + np.array([0.0, at_m, 0.0]))
    assert [door.evidence for door in doors] == [("holes", "floor")]


def test_a_door_up_to_the_ceiling_has_no_height():
    shape = two_rooms(0.15)
    (door,) = doors_of(shape, wall_points(shape, (1.0, 1.9, 0.0, 2.6), ("floor", "reveal")))
    assert door.height_m is None


def test_a_cupboard_before_one_face_makes_no_door():
    shape = two_rooms(0.15)
    points_m = wall_points(shape, DOOR, ("floor",))
    closed_m = wall_points(shape, (0.0, 0.0, 0.0, 0.0), ())
    far_face = closed_m[np.abs(closed_m[:, 0] - 4.15) < 0.05]
    assert doors_of(shape, np.concatenate([points_m, far_face])) == ()
