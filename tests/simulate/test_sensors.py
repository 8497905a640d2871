"""Sensors follow their published laws, and registration errors have the size asked for."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.errors import ConfigError
from indoorfit.simulate import SENSOR_PRESETS, Registration, Sensor, load_sensor, pose_errors, regime
from indoorfit.simulate.depth_noise import measured


def residual_std_m(sensor, at_m, rng):
    """Spread of the depth of a wall in front of the sensor, over one per cent of distances.

    Rounding makes the spread at one exact distance depend on where it falls between two steps.
    """
    residuals_m = []
    for distance_m in at_m * np.linspace(0.995, 1.005, 40):
        true_m = np.full((60, 80), distance_m)
        value_m = measured(sensor, true_m, np.zeros_like(true_m), rng)
        residuals_m.append((value_m - true_m)[np.isfinite(value_m)])
    return np.concatenate(residuals_m).std()


@pytest.mark.parametrize("name", SENSOR_PRESETS)
@pytest.mark.parametrize("at_m", [1.0, 2.0, 3.0, 4.0, 5.0])
def test_depth_noise_follows_the_law(name, at_m):
    sensor = replace(load_sensor(name), bowl_m=0.0, max_m=99.0)
    sigma_m = residual_std_m(sensor, at_m, np.random.default_rng(0))
    # 5 % is asked for; 190 thousand samples know a standard deviation to 0.2 % (2 % where correlated).
    assert sigma_m == pytest.approx(float(sensor.law_m(np.array([at_m]))[0]), rel=0.05)


def test_kinect_law_is_the_published_one():
    kinect = load_sensor("kinect_v1")
    assert float(kinect.law_m(np.array([5.0]))[0]) == pytest.approx(0.0356, abs=1e-4)
    assert np.degrees(kinect.width_rad) == pytest.approx(57.0, abs=0.01)
    assert np.degrees(kinect.height_rad) == pytest.approx(43.0, abs=0.01)


def test_kinect_depths_are_whole_steps_of_disparity():
    kinect = load_sensor("kinect_v1")
    true_m = np.random.default_rng(0).uniform(0.8, 4.5, (50, 50))
    depth_m = measured(kinect, true_m, np.zeros_like(true_m), np.random.default_rng(1))
    disparity = 1.0 / (kinect.step_per_m * depth_m[np.isfinite(depth_m)])
    np.testing.assert_allclose(disparity, np.round(disparity), atol=1e-9)


def test_noise_grows_at_grazing_incidence():
    rng = np.random.default_rng(0)
    for name in ("kinect_v1", "tls"):
        sensor, true_m = load_sensor(name), np.full((100, 100), 2.0)
        frontal, grazing = (
            np.nanstd(measured(sensor, true_m, np.full_like(true_m, angle), rng)) for angle in (0.0, 1.3)
        )
        # At 74 degrees the laws give factors of 1.2 (Nguyen) and 3.7 (1 / cos).
        assert grazing > 1.1 * frontal


def test_exact_sensor_changes_nothing_within_its_range():
    sensor = load_sensor("tof_camera").exact()
    true_m = np.random.default_rng(0).uniform(0.6, 3.8, (sensor.rows, sensor.columns))
    value_m = measured(sensor, true_m, np.zeros_like(true_m), np.random.default_rng(1))
    np.testing.assert_array_equal(value_m, true_m)


def test_nothing_returns_beyond_the_limits():
    sensor = load_sensor("kinect_v1").exact()
    true_m = np.array([[0.3, 2.0], [6.0, np.inf]])
    value_m = measured(sensor, true_m, np.zeros_like(true_m), np.random.default_rng(0))
    assert np.isfinite(value_m).tolist() == [[False, True], [False, False]]


def test_mixed_pixels_lie_between_the_two_surfaces():
    sensor = Sensor("camera", 200, 200, 1.0, 1.0, 0.1, 9.0, mixed_share=1.0)
    true_m = np.where(np.arange(200) < 100, 1.0, 3.0) * np.ones((200, 1))
    value_m = measured(sensor, true_m, np.zeros_like(true_m), np.random.default_rng(0))
    between = (value_m > 1.0) & (value_m < 3.0)
    assert between[:, 100].mean() > 0.9
    assert not between[:, 101:].any()


@pytest.mark.parametrize("name", ["5mm", "2cm", "5cm"])
@pytest.mark.parametrize("shares", [(0.6, 0.0), (0.0, 1.0), (1.0, 0.0)], ids=["walk+white", "jumps", "walk"])
def test_drift_has_the_rms_asked_for(name, shares):
    registration = replace(regime(name), walk_share=shares[0], jump_share=shares[1])
    errors = pose_errors(registration, 90, np.random.default_rng(4))
    rms_m = np.sqrt(np.mean(errors.translation_m**2))
    # Scaled to it: rounding only.
    assert rms_m == pytest.approx(registration.rms_m, rel=1e-12)
    rms_rad = np.sqrt(np.mean(errors.rotation_rad**2))
    assert rms_rad == pytest.approx(registration.rms_m / 3.0, rel=1e-12)


def test_walk_closes_its_loop_and_drifts_in_between():
    ends, middles = [], []
    for seed in range(200):
        registration = Registration(rms_m=0.02, walk_share=1.0)
        track_m = pose_errors(registration, 100, np.random.default_rng(seed)).translation_m
        ends.append(np.linalg.norm(track_m[-1]))
        middles.append(np.linalg.norm(track_m[50]))
    assert max(ends) < 1e-12
    assert np.median(middles) > 0.02


def test_jumps_are_constant_within_a_sector():
    registration = Registration(rms_m=0.02, walk_share=0.0, jump_share=1.0, n_sectors=6)
    track_m = pose_errors(registration, 60, np.random.default_rng(0)).translation_m
    assert len(np.unique(track_m.round(12), axis=0)) == 6


def test_slipped_block_is_displaced_as_one():
    registration = Registration(slip_share=0.2, slip_m=0.06)
    errors = pose_errors(registration, 50, np.random.default_rng(0))
    length_m = np.linalg.norm(errors.translation_m, axis=1)
    assert (length_m > 0.0).sum() == 10
    np.testing.assert_allclose(length_m[length_m > 0.0], 0.06, atol=1e-12)


def test_unknown_names_and_impossible_values_are_refused_with_a_remedy(tmp_path):
    (tmp_path / "bad.toml").write_text("kind = 'camera'\nlens = 3")
    for name in ("kinect_v9", tmp_path / "bad.toml"):
        with pytest.raises(ConfigError, match="Fix:"):
            load_sensor(name)
    with pytest.raises(ConfigError, match="Fix:"):
        regime("1km")
    with pytest.raises(ConfigError, match="Fix:"):
        pose_errors(Registration(walk_share=0.8, jump_share=0.5), 10, np.random.default_rng(0))
    with pytest.raises(ConfigError, match="Fix:"):
        load_sensor("kinect_v1").thinned(400)
