"""Laws of the mixture: quantiles, draws, contrasts."""

import numpy as np
import pytest
from scipy.stats import norm

from indoorfit.fitting.uncertainty import Predictive
from indoorfit.fitting.uncertainty.predictive import mixture_quantile


def make_predictive(rng: np.random.Generator, draws: int = 5, params: int = 6) -> Predictive:
    roots = rng.standard_normal((draws, params, params)) * 0.01
    weights = rng.uniform(0.5, 1.5, draws)
    return Predictive(
        weights / weights.sum(),
        0.01 * rng.standard_normal((draws, params)),
        roots @ np.swapaxes(roots, 1, 2),
        np.ones(params, bool),
        np.eye(params)[3:] - np.eye(params)[2:-1],
    )


def test_quantiles_of_one_component_are_the_gaussians() -> None:
    mean, std = np.array([[1.0, -2.0]]), np.array([[0.1, 3.0]])
    for probability in (1e-6, 0.025, 0.5, 0.9):
        expected = norm.ppf(probability, mean[0], std[0])
        # Rounding of the bisection: 80 sigma * 2^-52.
        np.testing.assert_allclose(
            mixture_quantile(np.ones(1), mean, std, probability), expected, atol=1e-12, rtol=1e-12
        )


def test_mixture_quantiles_agree_with_monte_carlo() -> None:
    rng = np.random.default_rng(1)
    predictive = make_predictive(rng)
    draws = predictive.sample(rng, 200_000) @ predictive.contrasts.T
    low, high = predictive.interval(0.95)
    # The 2.5 % quantile of 2e5 draws has a standard error of about 0.006 sigma; 5 of them.
    np.testing.assert_allclose(np.quantile(draws, 0.025, axis=0), low, atol=0.03 * predictive.std.max())
    np.testing.assert_allclose(np.quantile(draws, 0.975, axis=0), high, atol=0.03 * predictive.std.max())
    np.testing.assert_allclose(draws.std(axis=0), predictive.std, rtol=0.01)


def test_covariance_has_the_variances_on_its_diagonal() -> None:
    predictive = make_predictive(np.random.default_rng(2))
    np.testing.assert_allclose(predictive.covariance().diagonal(), predictive.std**2, rtol=1e-12)


def test_nested_levels_give_nested_intervals() -> None:
    predictive = make_predictive(np.random.default_rng(3))
    inner, outer = predictive.interval(0.5), predictive.interval(0.99)
    assert np.all(outer[0] < inner[0])
    assert np.all(inner[1] < outer[1])


def test_linear_derived_quantity_agrees_with_its_contrast() -> None:
    rng = np.random.default_rng(4)
    predictive = make_predictive(rng)
    derived = predictive.derived(lambda theta: theta @ predictive.contrasts.T, rng, 100_000, 0.9)
    low, high = predictive.interval(0.9)
    # 5 standard errors of a 5 % quantile of 1e5 draws.
    np.testing.assert_allclose(derived.low, low, atol=0.04 * predictive.std.max())
    np.testing.assert_allclose(derived.high, high, atol=0.04 * predictive.std.max())


def test_dimension_on_an_unseen_plane_is_unmeasured_and_infinite() -> None:
    predictive = make_predictive(np.random.default_rng(5))
    seen = predictive.seen.copy()
    seen[-1] = False
    blind = Predictive(
        predictive.weights, predictive.means, predictive.covariances, seen, predictive.contrasts
    )
    low, high = blind.interval(0.95)
    assert blind.measured.tolist() == [True, True, False]
    assert np.isneginf(low[-1])
    assert np.isposinf(high[-1])
    assert np.isfinite(low[:-1]).all()


@pytest.mark.parametrize("seed", [0, 1])
def test_same_generator_gives_same_draws(seed: int) -> None:
    predictive = make_predictive(np.random.default_rng(6))
    first = predictive.sample(np.random.default_rng(seed), 10)
    np.testing.assert_array_equal(first, predictive.sample(np.random.default_rng(seed), 10))
