"""Scores of intervals, against their definitions and against what is known of them."""

import math

import numpy as np
import pytest
from scipy import stats

from indoorfit.evaluate import LengthCheck, coverage, interval_score, reliability, summarise


def check(error_m: float, half_m: float, level: float = 0.95) -> LengthCheck:
    low_m, high_m = 4.0 + error_m - half_m, 4.0 + error_m + half_m
    return LengthCheck("A", "A", "wall", 4.0, 4.0 + error_m, half_m / 2, low_m, high_m, level, "observed")


@pytest.mark.parametrize(("hits", "n"), [(0, 10), (9, 10), (10, 10), (190, 200)])
def test_coverage_has_wilsons_interval(hits, n):
    found = coverage(np.arange(n) < hits)
    expected = stats.binomtest(hits, n).proportion_ci(0.95, "wilson")
    assert found.share == hits / n
    # The same formula in another library: rounding only.
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_coverage_of_nothing_says_nothing():
    found = coverage([])
    assert math.isnan(found.share)
    assert (found.low, found.high, found.n) == (0.0, 1.0, 0)


def test_interval_score_is_the_width_plus_forty_times_the_miss_at_95_percent():
    assert interval_score(1.0, 1.2, 1.1, 0.95) == pytest.approx(0.2)
    assert interval_score(1.0, 1.2, 1.25, 0.95) == pytest.approx(0.2 + 40 * 0.05)
    assert interval_score(1.0, 1.2, 0.9, 0.8) == pytest.approx(0.2 + 10 * 0.1)


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_interval_score_prefers_the_true_quantiles(factor):
    truth = np.random.default_rng(0).standard_normal(20_000)
    half = stats.norm.ppf(0.975)
    right = interval_score(-half, half, truth, 0.95).mean()
    # The expected scores differ by 15 % and 11 %; the mean of 20 000 is good to about 1 %.
    assert interval_score(-factor * half, factor * half, truth, 0.95).mean() > 1.05 * right


def test_reliability_lists_the_levels_in_order():
    table = reliability({0.95: [True, True], 0.5: [True, False]})
    assert list(table) == [0.5, 0.95]
    assert table[0.5].share == 0.5


def test_summary_of_known_lengths():
    summary = summarise([check(0.01, 0.02), check(-0.03, 0.02), check(0.0, 0.04)])
    assert summary.n == 3
    assert summary.rmse_m == pytest.approx(math.sqrt((0.01**2 + 0.03**2) / 3))
    # Median error 0; deviations 0.01, 0.03 and 0.
    assert summary.mad_m == pytest.approx(0.01)
    assert summary.bias_m == pytest.approx(-0.02 / 3)
    assert summary.largest_m == pytest.approx(0.03)
    assert summary.coverage.share == pytest.approx(2 / 3)
    assert summary.median_width_m == pytest.approx(0.04)
    # The second is missed by 1 cm.
    assert summary.mean_score_m == pytest.approx((0.04 + 0.04 + 40 * 0.01 + 0.08) / 3)


def test_summary_of_nothing_is_not_a_number():
    assert math.isnan(summarise([]).rmse_m)
