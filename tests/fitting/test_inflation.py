"""One factor on all intervals, and the covariance that goes with them."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit import ConfigError, RunConfig
from indoorfit.config import config_from_dict
from indoorfit.pipeline import fit_scan
from synthetic import virtual


@pytest.fixture(scope="module")
def pair():
    scan = virtual("L", 3, n_points=20_000, tilt_deg=2).scan
    plain = RunConfig()
    return fit_scan(scan, plain), fit_scan(scan, replace(plain, belief=replace(plain.belief, inflation=1.7)))


def test_everything_is_wider_by_the_factor_and_nothing_else_changes(pair):
    plain, wide = pair
    for a, b in zip(plain.dimensions, wide.dimensions, strict=True):
        qa, qb = a.quantity, b.quantity
        assert qb.value == qa.value
        # Rounding of sums of metres.
        assert qb.std == pytest.approx(1.7 * qa.std, rel=1e-9)
        assert qb.interval.high - qb.value == pytest.approx(1.7 * (qa.interval.high - qa.value), abs=1e-12)
        assert qb.value - qb.interval.low == pytest.approx(1.7 * (qa.value - qa.interval.low), abs=1e-12)
    np.testing.assert_allclose(wide.plane_covariance_m2, 1.7**2 * plain.plane_covariance_m2, rtol=1e-9)


def test_the_covariance_says_what_the_standard_uncertainties_say(pair):
    for result in pair:
        for d in result.dimensions:
            row = np.zeros(len(result.shape.planes))
            row[result.face(d.faces[0]).plane], row[result.face(d.faces[1]).plane] = -1.0, 1.0
            std_m = float(np.sqrt(row @ result.plane_covariance_m2 @ row))
            assert std_m == pytest.approx(d.quantity.std, rel=1e-9)


@pytest.mark.parametrize("factor", [0.0, -1.0])
def test_a_factor_must_be_positive(factor):
    with pytest.raises(ConfigError):
        config_from_dict({"belief": {"inflation": factor}})
