"""Rooms of the thesis' kinds through the whole pipeline: structure right, dimensions within their noise."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.config import RunConfig
from indoorfit.pipeline import fit as pipeline_fit
from indoorfit.pipeline import fit_scan
from synthetic import KINDS, expected_limit_m, largest_error_m, truth_of, virtual


def assert_sound(result) -> None:
    assert result.converged
    assert [note.code for note in result.notes] == []
    assert all(face.status == "observed" for face in result.faces)
    for quantity in [d.quantity for d in result.dimensions] + [room.volume for room in result.rooms]:
        assert quantity.interval.low < quantity.value < quantity.interval.high
        assert quantity.std > 0


@pytest.mark.parametrize("number", range(len(KINDS)), ids=KINDS)
def test_thesis_rooms_in_any_pose(number):
    scan = virtual(
        KINDS[number],
        number,
        n_points=60_000,
        yaw_deg=53 * number,
        tilt_deg=number % 7,
        azimuth_deg=70 * number,
    )
    result = fit_scan(scan.scan)
    truth = truth_of(scan)
    assert_sound(result)
    assert largest_error_m(result, truth) < expected_limit_m(scan, 0.005)
    found, true = result.rooms[0], truth.rooms[0]
    # Each of a dozen walls may be off by the limit along 5 m.
    area_m2 = 20.0 * expected_limit_m(scan, 0.005)
    assert found.floor_area.value == pytest.approx(true.floor_area.value, abs=area_m2)
    assert found.volume.value == pytest.approx(true.volume.value, abs=5 * area_m2)
    assert found.perimeter.value == pytest.approx(true.perimeter.value, abs=area_m2)


def test_full_size_thesis_room_reaches_the_figures_asked_for():
    """150 000 points: RMS 0.02 cm and 0.08 cm at most over many rooms; one room is held to the latter."""
    scan = virtual("L", 20, n_points=150_000, yaw_deg=-20, tilt_deg=6)
    result = fit_scan(scan.scan)
    assert_sound(result)
    assert largest_error_m(result, truth_of(scan)) < 0.0008


@pytest.mark.parametrize("kind", ["box", "L", "X"])
def test_line_of_sight_noise_of_a_depth_camera_levelled_and_turned(kind):
    for pose in ({}, {"yaw_deg": 40, "tilt_deg": 5, "azimuth_deg": 100}):
        scan = virtual(kind, 21, n_points=150_000, noise="kinect", **pose)
        result = fit_scan(scan.scan)
        assert_sound(result)
        # Requirement: 0.15 cm.
        assert largest_error_m(result, truth_of(scan)) < 0.0015


@pytest.mark.parametrize("kind", ["box", "U", "T", "stair"])
def test_five_thousand_points_with_outliers(kind):
    scan = virtual(
        kind, 22, n_points=5_000, noise="isotropic", sigma_m=0.01, outlier_share=0.02, yaw_deg=30, tilt_deg=3
    )
    result = fit_scan(scan.scan)
    assert result.converged
    assert largest_error_m(result, truth_of(scan)) < expected_limit_m(scan, 0.01)


@pytest.mark.parametrize("kind", ["box", "L", "Z"])
@pytest.mark.parametrize("hides", [False, True], ids=["see-through", "hiding"])
def test_furniture_and_a_window(kind, hides):
    scan = virtual(
        kind, 23, n_points=60_000, n_furniture=1, n_windows=1, furniture_hides=hides, yaw_deg=75, tilt_deg=2
    )
    result = fit_scan(scan.scan)
    assert result.converged
    assert [note.code for note in result.notes] == []
    assert largest_error_m(result, truth_of(scan)) < expected_limit_m(scan, 0.005)


def test_a_glass_wall_is_inferred_and_said():
    scan = virtual("box", 24, n_points=60_000, missing_planes=(3,))
    result = fit_scan(scan.scan)
    (unseen,) = [face for face in result.faces if face.status == "inferred"]
    assert unseen.n_points == 0
    (note,) = [note for note in result.notes if note.code == "FACE_INFERRED"]
    assert unseen.id in note.message
    for dimension in result.dimensions:
        expected = "inferred" if unseen.id in dimension.faces else "observed"
        assert dimension.status == expected
    errors = [
        (abs(d.quantity.value - t), d.quantity.std)
        for d, t in zip(result.dimensions[:3], (5.0, 4.0, 2.7), strict=True)
        if d.status == "inferred"
    ]
    # Floor and ceiling end within a surfel or two of it, and the interval says so.
    assert all(error < 0.1 and error < 4 * std for error, std in errors)


def test_rms_and_coverage_of_faces_describe_the_scan():
    scan = virtual("box", 25, n_points=60_000)
    result = fit_scan(scan.scan)
    for face in result.faces:
        # MAD of thousands of points: 2 %, twice that.
        assert face.rms_m == pytest.approx(0.005, rel=0.08)
        assert 0.8 < face.coverage <= 1.0
        assert face.n_points > 3000
        assert 0 < face.offset_std_m < 0.001


def test_greedy_is_recorded_as_what_it_is():
    scan = virtual("L", 26, n_points=60_000)
    greedy = fit_scan(scan.scan, RunConfig(method="greedy"))
    joint = fit_scan(scan.scan)
    assert greedy.method == "greedy"
    assert joint.method == "joint"
    # Two different estimators never agree to a micrometre in all dimensions.
    assert len(greedy.dimensions) == len(joint.dimensions)
    values = [[d.quantity.value for d in result.dimensions] for result in (greedy, joint)]
    assert np.max(np.abs(np.diff(values, axis=0))) > 1e-6
    # Thesis: 10 cm is the reach of the selection; both must describe the same room.
    assert largest_error_m(greedy, truth_of(scan)) < 0.05


def test_a_wall_with_two_places_is_named_and_its_intervals_reach_over_both(monkeypatch):
    scan, swing_m, fitted = virtual("box", 5, n_points=8_000).scan, 0.03, pipeline_fit.fit_joint

    def called_to_and_fro(*arguments):
        fit = fitted(*arguments)
        return replace(fit, swing_m=np.eye(len(fit.swing_m))[wall.plane] * swing_m)

    plain = fit_scan(scan)
    wall = next(face for face in plain.faces if face.kind == "wall")
    monkeypatch.setattr(pipeline_fit, "fit_joint", called_to_and_fro)
    result = fit_scan(scan)
    (note,) = (note for note in result.notes if note.code == "TWO_PLACES")
    assert result.converged
    assert note.faces == (wall.id,)
    for length, before in zip(result.dimensions, plain.dimensions, strict=True):
        reach_m = 0.5 * (length.quantity.interval.high - length.quantity.interval.low)
        # Two places alike are half their distance off the middle, and 1.96 times that is 95 %.
        assert (reach_m > swing_m) == (wall.id in length.faces)
        assert length.quantity.value == pytest.approx(before.quantity.value, abs=1e-9)


def test_a_step_that_was_put_back_is_named(monkeypatch):
    scan, fitted = virtual("box", 5, n_points=8_000).scan, pipeline_fit.fit_joint
    wall = next(face for face in fit_scan(scan).faces if face.kind == "wall")
    monkeypatch.setattr(pipeline_fit, "fit_joint", lambda *a: replace(fitted(*a), put_back=(wall.plane,)))
    (note,) = (note for note in fit_scan(scan).notes if note.code == "STEP_UNRESOLVED")
    assert note.faces == (wall.id,)


def test_a_fit_that_does_not_rest_says_at_which_face():
    config = RunConfig()
    # Nothing stands still to a tenth of a nanometre.
    config = replace(config, joint=replace(config.joint, settle=1e-9, max_rounds=3))
    result = fit_scan(virtual("box", 5, n_points=8_000).scan, config)
    (note,) = (note for note in result.notes if note.code == "NOT_CONVERGED")
    assert not result.converged
    assert any(face.id in note.message for face in result.faces)
