"""Fusion of two answers, and what is added to them."""

import numpy as np
import pytest

from indoorfit.fitting.uncertainty import (
    FusionConfig,
    Predictive,
    TypeBConfig,
    expand_ends,
    fuse,
    type_b_of,
)


def gaussian(means_m: list[float], stds_m: list[float]) -> Predictive:
    size = len(means_m)
    return Predictive(
        np.ones(1), np.array([means_m]), np.diag(np.square(stds_m))[None], np.ones(size, bool), np.eye(size)
    )


def test_fusing_an_answer_with_itself_changes_nothing() -> None:
    # Full correlation: independent answers would shrink by sqrt(2), the same answer must not.
    answer = gaussian([1.0, 2.0], [0.01, 0.02])
    fused = fuse(answer, answer, FusionConfig())
    np.testing.assert_allclose(fused.mean, answer.mean, rtol=1e-14)
    np.testing.assert_allclose(fused.std, answer.std, rtol=1e-14)
    np.testing.assert_allclose(fused.interval(0.95), answer.interval(0.95), rtol=1e-12)
    np.testing.assert_allclose(fused.covariance(), answer.covariance(), atol=1e-18)


def test_weights_are_inverse_variances() -> None:
    fused = fuse(gaussian([0.0], [0.03]), gaussian([0.01], [0.01]), FusionConfig())
    assert fused.wall_share[0] == pytest.approx(0.1, rel=1e-12)
    assert fused.mean[0] == pytest.approx(0.009, rel=1e-12)
    assert fused.std[0] == pytest.approx(0.1 * 0.03 + 0.9 * 0.01, rel=1e-12)


def test_contradiction_beyond_three_sigmas_leaves_the_pose_field_alone() -> None:
    wall, pose = gaussian([0.0, 0.0], [0.01, 0.01]), gaussian([0.15, 0.02], [0.01, 0.01])
    fused = fuse(wall, pose, FusionConfig())
    assert fused.inconsistent.tolist() == [True, False]
    assert fused.mean[0] == pytest.approx(0.15)
    assert fused.mean[1] == pytest.approx(0.01)
    assert fused.noise["inconsistent"] == 1


def test_derived_quantities_follow_the_same_rule() -> None:
    wall, pose = gaussian([0.0, 0.0], [0.01, 0.01]), gaussian([0.15, 0.02], [0.01, 0.01])
    fused = fuse(wall, pose, FusionConfig())
    derived = fused.derived(lambda theta: theta, np.random.default_rng(0), 40_000, 0.95)
    # 5 standard errors of a 2.5 % quantile of 4e4 draws, sigma = 1 cm.
    np.testing.assert_allclose(derived.low, fused.interval(0.95)[0], atol=7e-4)
    np.testing.assert_allclose(derived.high, fused.interval(0.95)[1], atol=7e-4)


def test_unmeasured_member_gets_no_weight() -> None:
    wall = gaussian([1.0], [0.01])
    pose = Predictive(np.ones(1), np.array([[1.1]]), np.zeros((1, 1, 1)), np.zeros(1, bool), np.eye(1))
    fused = fuse(wall, pose, FusionConfig())
    assert fused.mean[0] == pytest.approx(1.0, abs=1e-9)
    assert fused.std[0] == pytest.approx(0.01, rel=1e-6) or np.isinf(fused.std[0])


def expand_dimensions(answer, level, config):
    """Lengths with Type B added."""
    added = type_b_of(config)
    return expand_ends(
        centre=answer.mean,
        std=answer.std,
        ends=answer.interval(level),
        scale_std=added.scale_std * np.abs(answer.mean),
        definition_std=np.full(len(answer.mean), added.definition_std_m),
        data_dof=answer.variance_dof,
        scale_dof=added.scale_dof,
        level=level,
    )


def test_an_unknown_sensor_adds_nothing_and_says_so() -> None:
    added = type_b_of(TypeBConfig())
    assert (added.scale_std, added.definition_std_m) == (0.0, 0.0)
    assert "no sensor was named" in added.sentence
    assert "measure one length" in added.sentence


def test_settings_win_over_the_sensor_and_are_named_as_the_source() -> None:
    kinect = type_b_of(TypeBConfig(sensor="kinect_v1"))
    assert (kinect.scale_std, kinect.definition_std_m) == (0.004, 0.002)
    measured = type_b_of(TypeBConfig(sensor="kinect_v1", scale_std=0.0005, definition_std_m=0.0))
    assert (measured.scale_std, measured.definition_std_m) == (0.0005, 0.0)
    assert "settings" in measured.source
    assert "0.05 %" in measured.sentence


def test_type_b_parts_add_in_quadrature() -> None:
    answer = gaussian([5.0], [0.003])
    config = TypeBConfig(scale_std=0.002, definition_std_m=0.004)
    expanded = expand_dimensions(answer, 0.95, config)
    combined = np.sqrt(0.003**2 + 0.010**2 + 0.004**2)
    assert expanded.std[0] == pytest.approx(combined, rel=1e-12)
    # For a Gaussian, stretching about the median is the Gaussian of the combined width.
    assert expanded.high[0] - 5.0 == pytest.approx(1.959964 * combined, rel=1e-6)


def test_type_b_switched_off_returns_the_data_interval() -> None:
    answer = gaussian([5.0, 1.0], [0.003, 0.01])
    expanded = expand_dimensions(answer, 0.8, TypeBConfig(scale_std=0.0, definition_std_m=0.0))
    np.testing.assert_allclose([expanded.low, expanded.high], answer.interval(0.8), rtol=1e-12)
    assert np.all(np.isinf(expanded.effective_dof))


def test_perfect_data_leave_the_type_b_interval() -> None:
    expanded = expand_dimensions(
        gaussian([4.0], [0.0]), 0.95, TypeBConfig(scale_std=0.001, definition_std_m=0.0)
    )
    assert expanded.high[0] - expanded.low[0] == pytest.approx(2 * 1.959964 * 0.004, rel=1e-6)
    assert expanded.effective_dof[0] == pytest.approx(50.0)


def test_effective_degrees_of_freedom_follow_welch_satterthwaite() -> None:
    # Two components with variances 1 and 3: mean 2, variance 1, hence 2 * 4 / 1 = 8 degrees of freedom.
    answer = Predictive(
        np.array([0.5, 0.5]),
        np.zeros((2, 1)),
        np.array([1.0, 3.0])[:, None, None] * 1e-4,
        np.ones(1, bool),
        np.eye(1),
    )
    assert answer.variance_dof[0] == pytest.approx(8.0)
    expanded = expand_dimensions(answer, 0.95, TypeBConfig(scale_std=0.0, definition_std_m=0.01))
    # u_data^2 = 2e-4, u_def^2 = 1e-4: (3e-4)^2 / ((2e-4)^2 / 8) = 18.
    assert expanded.effective_dof[0] == pytest.approx(18.0)


def test_infinite_dimension_stays_infinite() -> None:
    blind = Predictive(np.ones(1), np.zeros((1, 1)), np.zeros((1, 1, 1)), np.zeros(1, bool), np.eye(1))
    expanded = expand_dimensions(blind, 0.95, TypeBConfig())
    assert np.isneginf(expanded.low[0])
    assert np.isposinf(expanded.high[0])
