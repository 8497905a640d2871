"""`sample = true`: the noise model by Markov chains, or no answer."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit import RunConfig, SamplingError
from indoorfit.fitting import SamplerConfig
from indoorfit.io import to_document
from indoorfit.pipeline import fit_scan
from synthetic import virtual

QUICK = SamplerConfig(walkers=16, check_steps=100, min_effective=100.0, max_rhat=1.15, min_lengths=15.0)
"""Enough for interval ends to 3 %: the limits of a real run make them good to 1 %."""


@pytest.fixture(scope="module")
def scan():
    """A box on which patches differ by some millimetres, as registration leaves them."""
    made = virtual("box", 5, n_points=15_000)
    rng, points_m = np.random.default_rng(5), made.frame.to_manhattan(made.scan.points_m)
    for k, plane in enumerate(made.shape.planes):
        own = np.flatnonzero(made.point_plane == k)
        within = [axis for axis in range(3) if axis != plane.axis]
        _, patch = np.unique(np.floor(points_m[own][:, within] / 0.9), axis=0, return_inverse=True)
        patch = patch.ravel()
        points_m[own, plane.axis] += 0.004 * rng.standard_normal(patch.max() + 1)[patch]
    return replace(made.scan, points_m=made.frame.to_scan(points_m), colours=None)


@pytest.fixture(scope="module")
def sampled(scan):
    return fit_scan(scan, RunConfig(sample=True, sampler=QUICK))


def test_sampled_and_analytic_half_widths_agree(scan, sampled):
    """Given the noise scales the geometry is exactly Gaussian in both, so they differ only in how they
    integrate over three scales: 24 importance draws around the mode (1 to 3 % in the ends) against a chain
    (3 % here). Where the posterior is wide and skewed, as on noise-free scans, its mode is no longer its
    centre, and up to 10 % are left."""
    analytic = fit_scan(scan)
    for a, b in zip(analytic.dimensions, sampled.dimensions, strict=True):
        assert a.quantity.value == b.quantity.value
        halves = [d.quantity.interval.high - d.quantity.value for d in (a, b)]
        assert halves[1] == pytest.approx(halves[0], rel=0.10)


def test_the_chain_is_reported(sampled):
    chain = to_document(sampled)["noise"]["sampler"]
    assert 1.0 <= chain["rhat"] <= QUICK.max_rhat
    assert chain["effective"] >= QUICK.min_effective
    assert chain["autocorrelation_steps"] >= 1.0
    assert 0.0 < chain["end_error"] < 0.05
    assert "Markov chains" in sampled.noise["explanation"]


def test_chains_that_have_not_converged_are_not_reported(scan):
    short = SamplerConfig(walkers=16, check_steps=20, max_steps=20)
    with pytest.raises(SamplingError, match=r"have not converged.*Fix: raise sampler\.max_steps"):
        fit_scan(scan, RunConfig(sample=True, sampler=short))
