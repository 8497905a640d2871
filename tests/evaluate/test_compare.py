"""The judge tells right models from wrong ones, and says what is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.evaluate import compare
from indoorfit.geometry import shape_from_plan
from indoorfit.model import FitResult, Frame, Shape
from indoorfit.pipeline import truth_result
from indoorfit.simulate import room_shape, scan_frame

FRAME = scan_frame(0.4, 0.05, 1.0, (10.0, 20.0, 0.0))
ROUNDING_M = 1e-9
"""Coordinates of some ten metres through a rotation and back; 1e-9 is what the judge itself merges."""


def exact(shape: Shape, frame: Frame = FRAME) -> FitResult:
    return truth_result(shape, frame, {}, 0)


def box(length_m: float, width_m: float, height_m: float = 2.5) -> Shape:
    return shape_from_plan([0.0, length_m], [0.0, width_m], [np.ones((1, 1), bool)], [(0.0, height_m)])


def moved(shape: Shape, face_class: str, by_m: float) -> Shape:
    offsets = shape.offsets_m.copy()
    offsets[next(k for k, plane in enumerate(shape.planes) if plane.face_class == face_class)] += by_m
    return shape.with_offsets(offsets)


@pytest.mark.parametrize("kind", ["box", "L", "U", "X", "T", "Z", "stair"])
def test_a_model_agrees_with_itself(kind):
    truth = exact(room_shape(kind))
    comparison = compare(truth, truth)
    assert comparison.right
    assert comparison.faults == ()
    assert not comparison.lost
    assert comparison.solid_iou == pytest.approx(1.0, abs=1e-12)
    assert comparison.footprint_iou == pytest.approx(1.0, abs=1e-12)
    assert all(length.hit for length in comparison.lengths)
    np.testing.assert_allclose([length.error_m for length in comparison.lengths], 0.0, atol=ROUNDING_M)


def test_each_pair_of_planes_counts_once():
    truth = exact(box(5.0, 4.0))
    # Length, width and height; the four walls' clear lengths are the first two again.
    assert len(truth.dimensions) == 7
    assert len(compare(truth, truth).lengths) == 3


def test_a_moved_wall_shows_in_its_lengths_alone():
    shape = room_shape("L")
    comparison = compare(exact(moved(shape, "right", 0.004)), exact(shape))
    assert comparison.right
    errors = np.array([length.error_m for length in comparison.lengths])
    changed = np.abs(errors) > ROUNDING_M
    assert 1 <= changed.sum() < len(changed)
    np.testing.assert_allclose(errors[changed], 0.004, atol=ROUNDING_M)
    assert [length.hit for length in comparison.lengths] == (~changed).tolist()


def test_iou_of_a_stretched_box_is_the_ratio_of_volumes():
    comparison = compare(exact(box(5.0, 4.0, 2.6)), exact(box(4.9, 4.0, 2.5)))
    assert comparison.footprint_iou == pytest.approx(4.9 / 5.0, abs=1e-12)
    assert comparison.solid_iou == pytest.approx(4.9 * 2.5 / (5.0 * 2.6), abs=1e-12)


def test_a_wall_in_the_wrong_place_is_named_with_its_distance():
    truth, model = exact(box(5.0, 4.0)), exact(moved(box(5.0, 4.0), "right", -0.5))
    comparison = compare(model, truth)
    (wrong,) = comparison.misplaced
    assert truth.face(wrong.truth).face_class == "right"
    # Half a metre into the room.
    assert wrong.distance_m == pytest.approx(0.5, abs=ROUNDING_M)
    assert not comparison.missing
    assert not comparison.extra
    assert not comparison.right
    assert "+0.50 m" in comparison.faults[0]
    # Somebody will read the wrong length, so it counts.
    assert min(length.error_m for length in comparison.lengths) == pytest.approx(-0.5, abs=ROUNDING_M)


@pytest.mark.parametrize(("std_m", "right"), [(0.1, False), (0.2, True)])
def test_an_inferred_wall_may_be_off_by_what_it_claims(std_m, right):
    truth, model = exact(box(5.0, 4.0)), exact(moved(box(5.0, 4.0), "right", -0.3))
    faces = tuple(
        replace(face, status="inferred", offset_std_m=std_m) if face.face_class == "right" else face
        for face in model.faces
    )
    assert compare(replace(model, faces=faces), truth).right == right


def test_a_notch_that_was_not_found_is_missing_and_one_that_was_invented_is_extra():
    notched, plain = exact(room_shape("L", length_m=5.0, width_m=4.0)), exact(box(5.0, 4.0, 2.7))
    lacking, inventing = compare(plain, notched), compare(notched, plain)
    # Two walls of the notch; the walls beside it are still there, only longer.
    assert len(lacking.missing) == 2
    assert lacking.extra == ()
    assert len(lacking.lost) > 0
    assert len(inventing.extra) == 2
    assert inventing.missing == ()
    assert not lacking.right
    assert not inventing.right
    assert lacking.solid_iou == pytest.approx(inventing.solid_iou)
    assert lacking.solid_iou == pytest.approx(1.0 - 0.33 * 1.5 / 20.0, abs=1e-12)


def test_a_model_turned_by_a_right_angle_is_the_same_model():
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    # Axes turned so that x becomes -y and y becomes x: the same room of 5 m by 4 m lies elsewhere in them.
    floor = [np.ones((1, 1), bool)]
    truth = exact(shape_from_plan([-5.0, 0.0], [0.0, 4.0], floor, [(0.0, 2.5)]))
    along_others = shape_from_plan([0.0, 4.0], [0.0, 5.0], floor, [(0.0, 2.5)])
    comparison = compare(
        exact(along_others, Frame(quarter @ FRAME.R_manhattan_scan, FRAME.origin_scan_m)), truth
    )
    assert comparison.right, comparison.faults
    # The angle comes from a cosine near 1, which has half of the digits.
    assert comparison.turn_rad < 1e-7
    assert comparison.solid_iou == pytest.approx(1.0, abs=1e-9)


def test_a_small_turn_costs_little_and_a_large_one_is_a_fault():
    shape = room_shape("L")
    truth = exact(shape)
    little, large = (
        exact(shape, scan_frame(0.4 + turn, 0.05, 1.0, (10.0, 20.0, 0.0))) for turn in (1e-3, 0.1)
    )
    comparison = compare(little, truth)
    assert comparison.right
    assert comparison.turn_rad == pytest.approx(1e-3, abs=1e-9)
    # The room lies up to 6 m from the axis of the turn: 6 mm of a room of 3.2 m.
    assert comparison.solid_iou > 0.99
    assert any("axes 5.7 degrees" in fault for fault in compare(large, truth).faults)


def test_rooms_are_matched_by_the_volume_they_share():
    lines = ([0.0, 4.0, 4.2, 7.0], [0.0, 3.0])
    left, right = (
        np.array([[cell] for cell in cells]) for cells in ([True, False, False], [False, False, True])
    )
    truth = exact(shape_from_plan(*lines, [left, right], [(0.0, 2.5)] * 2))
    swapped = exact(shape_from_plan(*lines, [right, left], [(0.0, 2.5)] * 2))
    comparison = compare(swapped, truth)
    assert {(pair.truth, pair.model) for pair in comparison.rooms} == {
        ("room-1", "room-2"),
        ("room-2", "room-1"),
    }
    assert comparison.right
    alone = compare(exact(shape_from_plan(*lines, [left], [(0.0, 2.5)])), truth)
    assert "1 room(s) instead of 2" in alone.faults
    assert alone.footprint_iou == pytest.approx(12.0 / 20.4, abs=1e-12)


def test_status_is_judged_where_it_is_known_whether_a_plane_was_seen():
    shape = box(5.0, 4.0)
    planes = list(shape.planes)
    planes[1] = replace(planes[1], status="inferred")
    model, truth = exact(replace(shape, planes=tuple(planes))), exact(shape)
    named = {face.plane: face.id for face in truth.faces}
    seen = {named[0]: True, named[1]: False}
    verdicts = {s.expected: s.found for s in compare(model, truth, seen).statuses}
    assert verdicts == {"observed": planes[0].status, "inferred": "inferred"}
    (wrong,) = compare(model, truth, {named[1]: True}).statuses
    assert (wrong.expected, wrong.found) == ("observed", "inferred")
    assert compare(model, truth).statuses == ()


def test_a_missing_wall_that_the_scan_does_not_show_is_said_to_be_unseen():
    notched, plain = exact(room_shape("L", length_m=5.0, width_m=4.0)), exact(box(5.0, 4.0, 2.7))
    lacking = compare(plain, notched).missing
    seen = {face.id: True for face in notched.faces} | {lacking[0]: False}
    del seen[lacking[1]]
    excuses = [fault.split("(")[-1] for fault in compare(plain, notched, seen).faults]
    assert excuses == ["not seen)", "hardly seen)"]


def test_an_open_mesh_is_a_fault():
    truth = exact(box(5.0, 4.0))
    mesh = truth.meshes[0]
    holed = replace(mesh, triangles=mesh.triangles[1:], face_ids=mesh.face_ids[1:])
    assert "not watertight" in compare(replace(truth, meshes=(holed,)), truth).faults
