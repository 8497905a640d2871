"""The visible parts of planes: areas, and who lies on them."""

import numpy as np
import pytest
from hypothesis import assume, given

from indoorfit.geometry import exposures, pieces, room_of_planes, shape_from_plan
from indoorfit.simulate import room_shape
from indoorfit.solid import face_polygons, subtract_cubes
from synthetic import KINDS, plans, touches_by_corner


def polygon_areas(shape) -> np.ndarray:
    areas = np.zeros(len(shape.planes))
    for room in shape.rooms:
        for polygon in face_polygons(subtract_cubes(shape, room)):
            areas[polygon.plane] += polygon.area_m2
    return areas


@given(plan=plans())
def test_visible_areas_equal_the_solid_polygons(plan):
    x, y, mask, z = plan
    assume(not touches_by_corner(mask))
    shape = shape_from_plan(x, y, [mask], [z])
    areas = [exposure.area_m2 for exposure in exposures(shape)]
    # The solid merges triangles within 1e-6 m, over at most 20 m of edges.
    np.testing.assert_allclose(polygon_areas(shape), areas, atol=2e-5)


@given(plan=plans())
def test_divergence_theorem_gives_the_volume_of_the_plan(plan):
    x, y, mask, z = plan
    shape = shape_from_plan(x, y, [mask], [z])
    # Volume = one third of the sum over faces of area x signed distance from the origin.
    total = sum(
        e.area_m2 * shape.planes[e.plane].outward * shape.planes[e.plane].offset_m for e in exposures(shape)
    )
    volume = float(np.diff(x) @ mask @ np.diff(y)) * (z[1] - z[0])
    # Rounding of sums of numbers below 1e4.
    assert total / 3.0 == pytest.approx(volume, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_cell_centres_are_contained_and_the_margin_shrinks(kind):
    rng = np.random.default_rng(3)
    for exposure in exposures(room_shape(kind)):
        points = rng.uniform(-1, 7, (400, 3))
        wide, exact, narrow = (exposure.contains(points, margin) for margin in (-0.05, 0.0, 0.05))
        assert np.all(wide >= exact)
        assert np.all(exact >= narrow)
        # A plane of 2 m2 in 64 m2 is hit at least once in 400 throws but for a chance of 3e-6.
        assert exact.any() or exposure.area_m2 < 2.0


@pytest.mark.parametrize("kind", KINDS)
def test_share_of_random_points_inside_equals_the_area(kind):
    rng = np.random.default_rng(4)
    points = rng.uniform(-1, 7, (40_000, 3))
    for exposure in exposures(room_shape(kind)):
        share = exposure.contains(points).mean() * 64.0
        p = exposure.area_m2 / 64.0
        # Binomial: five standard deviations.
        assert abs(share - exposure.area_m2) < 5 * 64 * np.sqrt(p * (1 - p) / len(points))


def test_margin_is_the_distance_to_the_edge():
    floor = next(e for e in exposures(room_shape("box")) if e.axis == 2)
    points = np.array([[0.049, 2.0, 0.0], [0.051, 2.0, 0.0], [-0.049, 2.0, 0.0], [-0.051, 2.0, 0.0]])
    assert floor.contains(points, 0.05).tolist() == [False, True, False, False]
    assert floor.contains(points, -0.05).tolist() == [True, True, True, False]


def test_swallowed_plane_is_not_visible():
    shape = room_shape("L")
    notch = next(cube for cube in shape.cubes if cube.role == "notch")
    plane = next(k for side, k in notch.sides.items() if k is not None and side[1] == "x")
    offsets = shape.offsets_m
    # The notch's wall is pushed out of the room.
    offsets[plane] = shape.bounds_m()["cube-0"][1, 0] + 0.5
    assert exposures(shape.with_offsets(offsets))[plane].area_m2 == 0.0


def test_planes_know_their_room():
    masks = [np.array([[True], [False]]), np.array([[False], [True]])]
    shape = shape_from_plan([0.0, 2.0, 5.0], [0.0, 3.0], masks, [(0.0, 2.5), (0.1, 2.4)])
    rooms = room_of_planes(shape)
    assert set(rooms) == set(range(12))
    assert sorted(rooms.values()) == ["cube-0"] * 6 + ["cube-1"] * 6


def test_a_nested_part_does_not_claim_its_neighbours_wall():
    """Its open sides reach a metre beyond its notch, over the wall of another notch in the same plane."""
    mask = np.array([[0, 0, 1], [0, 1, 1], [1, 1, 1], [0, 1, 1]], bool)
    x, y = [0.0, 1.0, 2.0, 2.5, 3.5], [0.0, 1.0, 2.0, 3.0]
    shape = shape_from_plan(x, y, [mask], [(0.0, 2.0)])
    areas = [exposure.area_m2 for exposure in exposures(shape)]
    # As above.
    np.testing.assert_allclose(polygon_areas(shape), areas, atol=2e-5)


@given(plan=plans())
def test_the_pieces_of_a_plane_are_its_faces(plan):
    x, y, mask, z = plan
    assume(not touches_by_corner(mask))
    shape = shape_from_plan(x, y, [mask], [z])
    found = [part for exposure in exposures(shape) for part in pieces(exposure)]
    polygons = [p for room in shape.rooms for p in face_polygons(subtract_cubes(shape, room))]
    areas_m2 = [sorted((k.plane, k.area_m2) for k in kinds) for kinds in (found, polygons)]
    np.testing.assert_allclose(*areas_m2, rtol=1e-6)
