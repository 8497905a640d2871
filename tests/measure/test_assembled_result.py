"""The result in the scan's frame agrees with the grammar in the Manhattan frame."""

from collections import Counter

import numpy as np
import pytest

from indoorfit.model import FitResult
from indoorfit.pipeline import truth_result
from synthetic import KINDS, is_rotation, virtual


@pytest.fixture(scope="module", params=KINDS)
def result(request) -> FitResult:
    scan = virtual(
        request.param, n_points=10, yaw_deg=50, tilt_deg=8, azimuth_deg=20, translation_m=(4e5, 5e6, 30.0)
    )
    return truth_result(scan.shape, scan.frame, {}, 0)


# Coordinates of 5e6 m have a step of 1e-9 m.
MAP_STEP_M = 5e-9


def test_faces_are_flat_and_their_normals_point_into_the_room(result):
    assert is_rotation(result.frame.R_manhattan_scan)
    for face in result.faces:
        ring = face.rings_m[0] - face.rings_m[0][0]
        assert np.abs(ring @ face.normal).max() < MAP_STEP_M
        assert np.linalg.norm(face.normal) == pytest.approx(1.0, abs=1e-12)
        area = 0.5 * np.sum(np.cross(ring, np.roll(ring, -1, axis=0)), axis=0)
        # Counter-clockwise as seen from inside: the area vector points inside. Any area is above 0.1 m2.
        assert area @ face.normal > 0.1


def test_classes_are_named_by_the_outward_direction(result):
    outward = {
        "front": (0, 1, 0), "back": (0, -1, 0), "right": (1, 0, 0), "left": (-1, 0, 0),
        "ceiling": (0, 0, 1), "floor": (0, 0, -1),
    }  # fmt: skip
    for face in result.faces:
        expected = -result.frame.directions_to_scan(np.array(outward[face.face_class], float))
        np.testing.assert_allclose(face.normal, expected, atol=1e-12)
        assert (face.kind == "wall") == (face.face_class not in ("floor", "ceiling"))


def test_meshes_are_watertight_inward_and_know_their_faces(result):
    normals = {face.id: face.normal for face in result.faces}
    for mesh in result.meshes:
        edges = Counter(
            (int(a), int(b)) for t in mesh.triangles for a, b in zip(t, np.roll(t, -1), strict=True)
        )
        assert set(edges.values()) == {1}
        assert all((b, a) in edges for a, b in edges)
        local = mesh.vertices_m - mesh.vertices_m.mean(axis=0)
        a, b, c = np.moveaxis(local[mesh.triangles], 1, 0)
        cross = np.cross(b - a, c - a)
        assert np.sum(a * np.cross(b, c)) / 6.0 < 0
        assert len(mesh.face_ids) == len(mesh.triangles)
        for normal, face in zip(cross, mesh.face_ids, strict=True):
            assert normal @ normals[face] > 0


def test_dimension_points_are_as_far_apart_as_the_dimension_says(result):
    for dimension in result.dimensions:
        distance = np.linalg.norm(dimension.to_m - dimension.from_m)
        assert distance == pytest.approx(dimension.quantity.value, abs=MAP_STEP_M)
        for name, point in zip(dimension.faces, (dimension.from_m, dimension.to_m), strict=True):
            face = result.face(name)
            assert abs((point - face.rings_m[0][0]) @ face.normal) < MAP_STEP_M


def test_volume_by_divergence_over_the_faces_is_that_of_the_room(result):
    origin = result.frame.origin_scan_m
    total = 0.0
    for face in result.faces:
        for ring in face.rings_m:
            local = ring - origin
            area = 0.5 * np.sum(np.cross(local, np.roll(local, -1, axis=0)), axis=0)
            total += local[0] @ face.normal * (area @ face.normal)
    # Normals point inward. Rounding: 1e-9 m times a surface of 150 m2.
    assert -total / 3.0 == pytest.approx(result.rooms[0].volume.value, abs=1e-6)


def test_unknown_face_is_a_key_error(result):
    with pytest.raises(KeyError):
        result.face("wall-99")
