"""Slips of frames: taken out of the cloud, and where lines of sight meet planes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from indoorfit.config import RunConfig
from indoorfit.fitting import BeliefConfig, register
from indoorfit.fitting.sight import sight_of
from indoorfit.model import Frame, FrameMotion, Plane, Scan, SensorFrame
from indoorfit.pipeline import fit_scan
from indoorfit.simulate import (
    RandomSceneSettings,
    ScanSettings,
    handheld_path,
    load_sensor,
    random_scene,
    regime,
    virtual_scan,
)


@pytest.fixture(scope="module")
def drifted():
    """A bare room, 2 cm drift, frame ids."""
    rng = np.random.default_rng(3)
    scene = random_scene(rng, RandomSceneSettings(n_walls=6, n_furniture=0, n_windows=0, n_doors=0))
    path = handheld_path(scene, 40, rng, "spin")
    settings = ScanSettings(pixel_step=16, yaw_rad=0.3, translation_m=(400.0, -70.0, 3.0))
    return virtual_scan(scene, load_sensor("kinect_v1"), path, regime("2cm"), rng, settings)


@pytest.fixture(scope="module")
def result(drifted):
    return fit_scan(drifted.scan, RunConfig(belief=BeliefConfig(use_frames=True)))


def spread_m(virtual, points_m):
    """Robust spread of every true plane's points about their own best plane, on average."""
    spreads = []
    for plane in range(len(virtual.shape.planes)):
        own = points_m[virtual.point_plane == plane]
        if len(own) > 200:
            centred = own - own.mean(axis=0)
            normal = np.linalg.svd(centred, full_matrices=False)[2][2]
            spreads.append(np.median(np.abs(centred @ normal)))
    return float(np.mean(spreads))


def test_registering_a_drifted_scan_makes_its_walls_thinner(drifted, result):
    before = spread_m(drifted, drifted.scan.points_m)
    after = spread_m(drifted, register(drifted.scan, result.registration).points_m)
    # 2 cm and 0.4 degrees on top of the sensor's own 5 to 15 mm: without them a third at least is gone.
    assert after < 0.67 * before


def test_registered_frames_stand_relative_to_each_other_as_they_did(drifted, result):
    moved = {sensor.id: sensor.position_m for sensor in register(drifted.scan, result.registration).frames}
    true = {sensor.id: sensor.position_m for sensor in drifted.true_frames}
    believed = {sensor.id: sensor.position_m for sensor in drifted.scan.frames}
    ids = sorted(true)

    def scatter(places):
        off = np.array([places[k] - true[k] for k in ids])
        return float(np.sqrt(np.mean((off - off.mean(axis=0)) ** 2)))

    # Statistical: a third at least of 20 mm is gone. A shift and a turn that all frames share are left alone,
    # and so is what a frame that sees one wall only cannot tell along that wall.
    assert scatter(moved) < 0.67 * scatter(believed)


def test_every_frame_with_a_motion_tells_how_well_it_is_known(result):
    assert len(result.registration) > 35
    for motion in result.registration:
        assert 0.0 < motion.shift_std_m < 0.1
        assert 0.0 < motion.turn_std_rad < 0.1
        # Rounding.
        np.testing.assert_allclose(motion.rotation @ motion.rotation.T, np.eye(3), atol=1e-12)


def test_register_moves_only_the_frames_that_have_a_motion():
    turn = Rotation.from_rotvec([0.0, 0.0, 0.1]).as_matrix()
    pivot_m, shift_m = np.array([1e5, 2e5, 0.0]), np.array([0.01, 0.0, -0.02])
    points_m = pivot_m + np.random.default_rng(1).normal(size=(20, 3))
    scan = Scan(points_m, frame_ids=np.repeat([7, 9], 10), frames=(SensorFrame(9, pivot_m, np.eye(3)),))
    moved = register(scan, (FrameMotion(9, pivot_m, turn, shift_m, 1e-3, 1e-3, False),))
    np.testing.assert_array_equal(moved.points_m[:10], points_m[:10])
    # Rounding at map coordinates of 2e5 m.
    expected_m = (points_m[10:] - pivot_m) @ turn.T + pivot_m + shift_m
    np.testing.assert_allclose(moved.points_m[10:], expected_m, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(moved.frames[0].position_m, pivot_m + shift_m, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(moved.frames[0].rotation, turn, atol=1e-15)


def seen_wall(noise_m, limit_m=np.inf):
    """A wall at x = 4 seen from the origin with noise along the line of sight; its true places."""
    rng = np.random.default_rng(5)
    true_m = np.column_stack([np.full(4000, 4.0), rng.uniform(-3, 3, 4000), rng.uniform(-1, 1, 4000)])
    length_m = np.linalg.norm(true_m, axis=1)
    points_m = true_m * (1.0 + rng.normal(0.0, noise_m, 4000) / length_m)[:, None]
    keep = np.linalg.norm(points_m, axis=1) < limit_m
    scan = Scan(
        points_m[keep],
        frame_ids=rng.integers(0, 8, keep.sum()),
        frames=tuple(SensorFrame(k, np.zeros(3)) for k in range(8)),
    )
    return scan, true_m[keep]


def test_lines_of_sight_meet_the_plane_where_the_point_was_taken():
    scan, true_m = seen_wall(0.02)
    sight = sight_of(scan, Frame(np.eye(3), np.zeros(3)))
    met = sight.meet(scan.points_m, np.arange(scan.n_points), Plane(0, 1, 4.0), 0.2)
    # Rounding: noise along the line of sight is undone exactly.
    np.testing.assert_allclose(met.places_m, true_m, atol=1e-12)
    assert met.faces.all()


def test_a_plane_seen_from_behind_is_told():
    scan, _ = seen_wall(0.02)
    sight = sight_of(scan, Frame(np.eye(3), np.zeros(3)))
    met = sight.meet(scan.points_m, np.arange(scan.n_points), Plane(0, -1, 4.0), 0.2)
    assert not met.faces.any()


def test_the_largest_range_shows_where_many_frames_end_at_it():
    scan, _ = seen_wall(0.02, limit_m=4.5)
    sight = sight_of(scan, Frame(np.eye(3), np.zeros(3)))
    # 500 points a frame, a tenth of them within 10 cm of the limit: the last one is 1 cm away.
    assert sight.limit_m == pytest.approx(4.5, abs=0.01)


def test_no_lines_of_sight_without_every_frames_pose():
    scan, _ = seen_wall(0.02)
    assert sight_of(replace(scan, frames=scan.frames[1:]), Frame(np.eye(3), np.zeros(3))) is None
    assert sight_of(replace(scan, frame_ids=None), Frame(np.eye(3), np.zeros(3))) is None
