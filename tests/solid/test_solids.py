"""The boolean solid: closed, of the right volume, its faces proper polygons."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given

from indoorfit.geometry import exposures, shape_from_plan
from indoorfit.model import RoomSolid, Shape
from indoorfit.simulate import room_shape
from indoorfit.solid import face_polygons, subtract_cubes
from synthetic import KINDS, plans, touches_by_corner


def shape_of(plan) -> Shape:
    x, y, mask, z = plan
    return shape_from_plan(x, y, [mask], [z])


def solid_of(shape: Shape) -> RoomSolid:
    return subtract_cubes(shape, shape.rooms[0])


def assert_watertight(triangles: np.ndarray) -> None:
    """Every edge belongs to two triangles and is run through once in either direction."""
    edges = Counter((int(a), int(b)) for t in triangles for a, b in zip(t, np.roll(t, -1), strict=True))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)


def signed_area(ring_m: np.ndarray, axis: int, inward: int) -> float:
    """Area within a ring, positive if counter-clockwise as seen from inside the room."""
    u, v = ((axis + 1) % 3, (axis + 2) % 3)  # Right-handed with `axis`.
    x, y = ring_m[:, u], ring_m[:, v]
    return inward * 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@given(plan=plans())
def test_solid_is_watertight_and_has_the_volume_of_the_plan(plan):
    x, y, mask, z = plan
    solid = solid_of(shape_of(plan))
    assert solid.is_closed
    # Merging within 1e-6 m on a surface of at most 500 m2.
    expected = float(np.diff(x) @ mask @ np.diff(y)) * (z[1] - z[0])
    assert solid.volume_m3 == pytest.approx(expected, abs=1e-4)
    # Where cells meet in a corner the boolean library doubles the vertices, which keeps it a manifold.
    assert_watertight(solid.triangles)


@given(plan=plans())
def test_mesh_volume_by_divergence_equals_the_reported_one_and_is_outward(plan):
    solid = solid_of(shape_of(plan))
    a, b, c = np.moveaxis(solid.vertices_m[solid.triangles], 1, 0)
    # Rounding of sums of a few hundred numbers below 100.
    assert np.sum(a * np.cross(b, c)) / 6.0 == pytest.approx(solid.volume_m3, abs=1e-9)
    assert solid.volume_m3 > 0


@given(plan=plans())
def test_triangles_lie_on_their_planes_and_face_their_way(plan):
    shape = shape_of(plan)
    solid = solid_of(shape)
    a, b, c = np.moveaxis(solid.vertices_m[solid.triangles], 1, 0)
    normals = np.cross(b - a, c - a)
    for t, k in enumerate(solid.planes):
        plane = shape.planes[k]
        # Bitwise: the boolean keeps the coordinates of the boxes.
        assert np.all(solid.vertices_m[solid.triangles[t], plane.axis] == plane.offset_m)
        assert np.sign(normals[t, plane.axis]) == plane.outward


@given(plan=plans())
def test_polygons_cover_the_surface_once(plan):
    shape = shape_of(plan)
    solid = solid_of(shape)
    polygons = face_polygons(solid)
    used = np.concatenate([polygon.triangles for polygon in polygons])
    np.testing.assert_array_equal(np.sort(used), np.arange(len(solid.triangles)))
    keys = [(polygon.plane, *polygon.rings_m[0].min(axis=0)) for polygon in polygons]
    assert keys == sorted(keys)


@given(plan=plans())
def test_rings_run_counter_clockwise_outside_and_clockwise_around_holes(plan):
    _, _, mask, _ = plan
    assume(not touches_by_corner(mask))
    shape = shape_of(plan)
    for polygon in face_polygons(solid_of(shape)):
        plane = shape.planes[polygon.plane]
        areas = [signed_area(ring, plane.axis, -plane.outward) for ring in polygon.rings_m]
        assert areas[0] > 0
        assert all(area < 0 for area in areas[1:])
        # Merging within 1e-6 m along at most 30 m of edges.
        assert sum(areas) == pytest.approx(polygon.area_m2, abs=1e-4)
        for ring in polygon.rings_m:
            assert np.all(ring[:, plane.axis] == plane.offset_m)
            turns = np.cross(ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring)
            # No straight corners: the shortest edge of the strategy is 10 cm.
            assert np.linalg.norm(turns, axis=1).min() > 1e-3


@given(plan=plans())
def test_polygons_close_edge_to_edge(plan):
    """Every stretch of a polygon's edge is shared with one other polygon: the faces alone are watertight."""
    _, _, mask, _ = plan
    assume(not touches_by_corner(mask))
    polygons = face_polygons(solid_of(shape_of(plan)))
    corners = {tuple(point) for polygon in polygons for ring in polygon.rings_m for point in ring}
    counts: Counter = Counter()
    for polygon in polygons:
        for ring in polygon.rings_m:
            for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                axis = int(np.argmax(np.abs(end - start)))
                low, high = sorted((start[axis], end[axis]))
                rest = [a for a in range(3) if a != axis]
                # Corners of other faces on this edge cut it into stretches.
                on = sorted(
                    p[axis] for p in corners if low <= p[axis] <= high and all(p[a] == start[a] for a in rest)
                )
                on = list(dict.fromkeys(on))
                for a, b in pairwise(on):
                    counts[(axis, *(float(start[r]) for r in rest), a, b)] += 1
    assert set(counts.values()) == {2}


def test_a_pillar_makes_a_hole_in_floor_and_ceiling():
    mask = np.ones((3, 3), bool)
    mask[1, 1] = False
    shape = shape_from_plan([0.0, 1.0, 2.0, 4.0], [0.0, 1.5, 2.0, 3.0], [mask], [(0.0, 2.5)])
    polygons = face_polygons(solid_of(shape))
    rings = {
        shape.planes[p.plane].face_class: len(p.rings_m) for p in polygons if shape.planes[p.plane].axis == 2
    }
    assert rings == {"floor": 2, "ceiling": 2}
    assert len(polygons) == 10


def test_one_plane_in_two_pieces_gives_two_polygons():
    shape = room_shape("U")
    polygons = face_polygons(solid_of(shape))
    by_plane = Counter(polygon.plane for polygon in polygons)
    assert sorted(by_plane.values()) == [1] * 8 + [2]
    areas = {e.plane: e.area_m2 for e in exposures(shape)}
    (split,) = [plane for plane, n in by_plane.items() if n == 2]
    total = sum(polygon.area_m2 for polygon in polygons if polygon.plane == split)
    assert total == pytest.approx(areas[split], abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_map_sized_rooms_are_closed_too(kind):
    """The Manhattan frame is local, but nothing may depend on where its origin is."""
    shape = room_shape(kind)
    moved = shape.with_offsets(shape.offsets_m + 1e4)
    solid = solid_of(moved)
    assert solid.is_closed
    # Coordinates of 1e4 m have a step of 2e-12 m, volumes of 60 m3 from terms of 1e12 one of 1e-4 m3.
    assert solid.volume_m3 == pytest.approx(solid_of(shape).volume_m3, abs=1e-3)


@pytest.mark.parametrize("offset_m", [-10.0, -1.0], ids=["floor-below", "inverted"])
def test_a_room_turned_inside_out_is_not_closed(offset_m):
    """Two walls that passed each other enclose nothing; that must not be reported as a sound room."""
    shape = room_shape("box")
    offsets = shape.offsets_m
    plane = next(k for k, p in enumerate(shape.planes) if p.axis == 0 and p.outward > 0)
    offsets[plane] = offset_m
    assert not solid_of(shape.with_offsets(offsets)).is_closed
