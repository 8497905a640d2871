"""The same result at other levels, and what is said of its accuracy."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit import RunConfig
from indoorfit.errors import ConfigError
from indoorfit.io import read_model_json, write_model_json
from indoorfit.measure import at_level
from indoorfit.measure.levels import loa_classes
from indoorfit.model import STANDARD_LEVELS, FitResult, Spread
from indoorfit.pipeline import fit_scan
from synthetic import virtual


@pytest.fixture(scope="module")
def result() -> FitResult:
    return fit_scan(virtual("box", 3, n_points=20_000).scan)


def ends(result: FitResult) -> np.ndarray:
    quantities = [d.quantity for d in result.dimensions]
    quantities += [q for room in result.rooms for q in (room.floor_area, room.volume, room.perimeter)]
    return np.array([(q.interval.level, q.interval.low, q.interval.high) for q in quantities])


@pytest.mark.parametrize("level", [0.5, 0.99])
def test_another_level_is_what_another_fit_would_give(result, level):
    refitted = fit_scan(virtual("box", 3, n_points=20_000).scan, RunConfig(level=level))
    np.testing.assert_array_equal(ends(at_level(result, level)), ends(refitted))
    assert at_level(result, level).level == level


def test_standard_levels_are_carried_along(result):
    for dimension in result.dimensions:
        held = dimension.quantity.intervals
        assert tuple(interval.level for interval in held) == STANDARD_LEVELS
        assert held[3] == dimension.quantity.interval  # 95 %
        assert np.all(np.diff([interval.high - interval.low for interval in held]) > 0)


def test_a_model_read_from_a_file_knows_the_standard_levels_only(result, tmp_path):
    write_model_json(tmp_path / "model.json", result)
    read = read_model_json(tmp_path / "model.json")
    np.testing.assert_array_equal(ends(at_level(read, 0.8)), ends(at_level(result, 0.8)))
    with pytest.raises(ConfigError, match=r"0\.5, 0\.8, 0\.9, 0\.95, 0\.99"):
        at_level(read, 0.85)


@pytest.mark.parametrize("level", [0.0, 1.0, 95.0])
def test_an_impossible_level_is_refused(result, level):
    with pytest.raises(ConfigError, match="between 0 and 1"):
        at_level(result, level)


def test_half_the_interval_is_the_coverage_factor_times_the_standard_uncertainty(result):
    for dimension in result.dimensions:
        quantity = dimension.quantity
        half = 0.5 * (quantity.interval.high - quantity.interval.low)
        assert quantity.coverage_factor is not None
        assert quantity.coverage_factor * quantity.std == pytest.approx(half, rel=1e-12)  # rounding
        # Between a Gaussian with half its scale known wrongly and Student's t with 1 degree of freedom.
        assert 1.5 < quantity.coverage_factor < 12.7


def test_no_interval_reaches_below_nothing(result):
    far = 1.0 + max(d.quantity.value for d in result.dimensions)
    n = len(ends(result)) + len(result.shape.planes)
    doubtful = replace(result, prediction=Wide(np.zeros(n), far))
    lows = ends(at_level(doubtful, 0.95))[:, 1]
    np.testing.assert_array_equal(lows, np.zeros_like(lows))


class Wide:
    """Intervals of one width about each value."""

    def __init__(self, values, half):
        self.values, self.half = values, half

    def at(self, level):
        none = 0 * self.values
        return Spread(level, self.values - self.half, self.values + self.half, none, none, none, none, none)


class Normal:
    """A normal distribution about each value."""

    def __init__(self, values, half_95):
        self.values, self.half_95 = values, half_95

    def at(self, level):
        assert level == 0.95
        none = 0 * self.values
        low, high = self.values - self.half_95, self.values + self.half_95
        return Spread(level, low, high, none, none, none, none, none)


@pytest.mark.parametrize(
    ("half_mm", "band"), [(0.9, "LOA50"), (3.0, "LOA40"), (12.0, "LOA30"), (40.0, "LOA20"), (60.0, "LOA10")]
)
def test_accuracy_bands_are_those_of_usibd(half_mm, band):
    values = np.array([3.0, 5.0])
    assert loa_classes(values[:1], Normal(values, half_mm / 1000.0)) == (band,)


def test_the_accuracy_band_does_not_depend_on_the_stated_level(result):
    other = fit_scan(virtual("box", 3, n_points=20_000).scan, RunConfig(level=0.5))
    assert [d.loa for d in other.dimensions] == [d.loa for d in result.dimensions]
