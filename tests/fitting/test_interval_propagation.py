"""Intervals of measurands follow from those of the planes."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.fitting import (
    BeliefConfig,
    JointConfig,
    MeasurandPrediction,
    TypeBConfig,
    believe,
    fit_joint,
    type_b_of,
)
from indoorfit.fitting.belief import edge_exchange_covariance
from synthetic import virtual

PIXEL_M = 0.15


@pytest.fixture(scope="module")
def fitted():
    scan = virtual("box", 1, n_points=20_000)
    return fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)


def spread_of(fit, gradients, level=0.95, seed=0, values=None, type_b=None):
    gradients = np.asarray(gradients, float)
    values = gradients @ fit.shape.offsets_m if values is None else values
    rng = np.random.default_rng(seed)
    added = type_b_of(TypeBConfig() if type_b is None else type_b)
    return MeasurandPrediction(belief_of(fit, rng), values, gradients, added).at(level)


def belief_of(fit, rng):
    rms_m = fit.data.plane_rms_m
    return believe(fit.cells, None, fit.shape, fit.frame, rms_m, PIXEL_M, BeliefConfig(), rng)


def rows(fit, *pairs):
    found = np.zeros((len(pairs), len(fit.shape.planes)))
    for row, (low, high) in zip(found, pairs, strict=True):
        row[low], row[high] = -1.0, 1.0
    return found


def test_intervals_hold_their_values_and_grow_with_the_level(fitted):
    widths = []
    for level in (0.5, 0.8, 0.95, 0.99):
        found = spread_of(fitted, rows(fitted, (2, 3), (4, 5)), level)
        values = rows(fitted, (2, 3), (4, 5)) @ fitted.shape.offsets_m
        assert np.all((found.low < values) & (values < found.high))
        widths.append(found.high - found.low)
    assert np.all(np.diff(widths, axis=0) > 0)


def test_scaling_a_measurand_scales_its_spread(fitted):
    one = spread_of(fitted, rows(fitted, (2, 3)))
    ten = spread_of(fitted, 10 * rows(fitted, (2, 3)))
    # The same draws, scaled: rounding.
    np.testing.assert_allclose(ten.std, 10 * one.std, rtol=1e-9)
    np.testing.assert_allclose(ten.high - ten.low, 10 * (one.high - one.low), rtol=1e-6)


def test_spread_does_not_depend_on_the_value(fitted):
    gradient = rows(fitted, (2, 3))
    near, far = (spread_of(fitted, gradient, values=np.array([v])) for v in (0.0, 1000.0))
    # Rounding at 1000 m.
    np.testing.assert_allclose(far.high - 1000.0, near.high, atol=1e-9)
    np.testing.assert_allclose(far.low - 1000.0, near.low, atol=1e-9)


def test_every_level_comes_from_one_belief(fitted):
    values = rows(fitted, (2, 3)) @ fitted.shape.offsets_m
    belief = belief_of(fitted, np.random.default_rng(0))
    prediction = MeasurandPrediction(belief, values, rows(fitted, (2, 3)))
    # The same draws as a run that was asked for that level: bitwise.
    for level in (0.5, 0.99):
        alone = spread_of(fitted, rows(fitted, (2, 3)), level)
        np.testing.assert_array_equal(prediction.at(level).low, alone.low)
        np.testing.assert_array_equal(prediction.at(level).high, alone.high)


def test_a_value_away_from_the_centre_lies_within_its_interval(fitted):
    """A greedy plane stays where greedy put it: 2 cm off, an interval of a millimetre would miss both."""
    moved = fitted.shape.offsets_m + np.array([0, 0, 0, 0.02, 0, 0])
    gradient = rows(fitted, (2, 3))
    belief = belief_of(fitted, np.random.default_rng(0))
    elsewhere = replace(belief, shape=belief.shape.with_offsets(moved))
    spread, value = MeasurandPrediction(elsewhere, gradient @ moved, gradient).at(0.95), gradient @ moved
    centred = spread_of(fitted, gradient)
    # GUM F.2.4.5: U + |b| about the value, which holds the interval about the centre.
    assert np.all((spread.low < value) & (value < spread.high))
    half = 0.5 * (centred.high - centred.low)
    np.testing.assert_allclose(0.5 * (spread.high - spread.low), half + 0.02, atol=0.2 * half[0])
    assert np.all((spread.low <= centred.low + 0.2 * half) & (centred.high - 0.2 * half <= spread.high))


def test_scale_grows_with_the_power_of_the_length_and_definition_with_the_walls(fitted):
    offsets = fitted.shape.offsets_m
    length, width = offsets[1] - offsets[0], offsets[3] - offsets[2]
    area = np.array([[-width, width, -length, length, 0.0, 0.0]])
    settings = TypeBConfig(scale_std=0.004, definition_std_m=0.002)
    gradients, values = np.vstack([rows(fitted, (0, 1)), area]), np.array([length, length * width])
    found = spread_of(fitted, gradients, values=values, type_b=settings)
    # Rounding: u_s L, and twice the relative figure for an area.
    np.testing.assert_allclose(found.scale_std, 0.004 * np.array([length, 2 * length * width]), rtol=1e-9)
    # A length ends at two walls with u_def / sqrt(2) each; an area at four.
    assert found.definition_std[0] == pytest.approx(0.002, rel=1e-9)
    assert found.definition_std[1] == pytest.approx(0.002 * np.hypot(length, width), rel=1e-9)
    parts = found.data_std**2 + found.scale_std**2 + found.definition_std**2
    np.testing.assert_allclose(found.std**2, parts, rtol=1e-12)


def test_a_measurand_without_parameters_has_no_spread(fitted):
    found = spread_of(fitted, np.vstack([rows(fitted, (2, 3)), np.zeros((1, 6))]))
    assert found.std[1] == pytest.approx(0.0, abs=1e-12)


def test_same_seed_same_numbers(fitted):
    a, b = (spread_of(fitted, rows(fitted, (2, 3)), seed=4) for _ in range(2))
    np.testing.assert_array_equal(a.low, b.low)
    np.testing.assert_array_equal(a.high, b.high)


def test_noise_model_is_explained_in_words(fitted):
    noise = belief_of(fitted, np.random.default_rng(0)).noise
    assert "registered independently" in noise["explanation"]
    assert all(isinstance(name, str) for name in noise)


def test_intervals_cover_the_truth_as_often_as_they_say():
    """A check of the plumbing; the noise models' own coverage is tested with them."""
    inside = []
    for seed in range(12):
        scan = virtual("box", 100 + seed, n_points=6_000)
        fit = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
        pairs = rows(fit, (0, 1), (2, 3), (4, 5))
        found = spread_of(fit, pairs, 0.8, seed)
        truth = pairs @ scan.shape.offsets_m
        inside += list((found.low <= truth) & (truth <= found.high))
    # 36 of level 0.8: between 60 % and 100 % but for a chance of 0.3 %.
    assert 0.6 <= np.mean(inside)


def test_noise_along_the_line_of_sight_counts_for_both_faces_of_a_length_and_not_for_a_step():
    shape = virtual("L", 1, n_points=1000).shape
    rms_m = np.full(len(shape.planes), 0.02)
    covariance_m2 = edge_exchange_covariance(shape, rms_m)
    axes = np.array([plane.axis for plane in shape.planes])
    outward = np.array([plane.outward for plane in shape.planes])
    for axis in (0, 1):
        own = np.flatnonzero(axes == axis)
        low, *_, high = own[np.argsort(shape.offsets_m[own])]
        row = np.zeros(len(axes))
        row[low], row[high] = -1.0, 1.0
        mean_m = 4.0 * 0.02**2 / (shape.offsets_m[high] - shape.offsets_m[low])
        # Two means, since both faces come inwards, and two variances of mean^2 / 3.
        assert row @ covariance_m2 @ row == pytest.approx((4.0 + 2.0 / 3.0) * mean_m**2, rel=1e-9)
        pair = own[outward[own] == outward[low]][:2]
        if len(pair) == 2:
            step = np.zeros(len(axes))
            step[pair[0]], step[pair[1]] = -1.0, 1.0
            assert step @ covariance_m2 @ step == pytest.approx(2.0 / 3.0 * mean_m**2, rel=1e-9)


def test_standard_uncertainty_is_one_number_where_two_models_contradict_each_other(fitted):
    values = rows(fitted, (2, 3)) @ fitted.shape.offsets_m
    belief = belief_of(fitted, np.random.default_rng(0))
    means = belief.wall.means.copy()
    means[:, 3 + 3] += 0.03
    torn = replace(belief, pose=replace(belief.wall, means=means), torn=True)
    found = [MeasurandPrediction(torn, values, rows(fitted, (2, 3))).at(level) for level in (0.5, 0.8, 0.99)]
    for other in found[1:]:
        np.testing.assert_array_equal(other.std, found[0].std)
    # A uniform distribution over 3 cm at least, and over little more.
    assert 0.03 / np.sqrt(12.0) < float(found[0].std[0]) < 0.04 / np.sqrt(12.0)
