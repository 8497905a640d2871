"""Samplers against known answers. A sampler that is 15 % too narrow looks healthy by every other sign."""

import numpy as np
import pytest
from cell_rooms import REGIMES, simulate_cell_room

from indoorfit.fitting.uncertainty import (
    SamplerConfig,
    WallFieldConfig,
    sample_wall_field,
    wall_field_predictive,
)
from indoorfit.fitting.uncertainty.chains import autocorrelation_steps, sample_chain, split_rhat


def test_moves_reproduce_a_standard_normal_in_fourteen_dimensions() -> None:
    rng = np.random.default_rng(7)
    config = SamplerConfig(
        walkers=64, check_steps=3000, max_steps=3000, burn_share=0.0, max_rhat=2.0, min_effective=1.0
    )
    chain, _ = sample_chain(lambda x: -0.5 * np.sum(x**2, axis=1), rng.standard_normal((64, 14)), config, rng)
    # Some 2000 effective draws per coordinate, 14 of them: the mean sd is known to 0.005. The snooker
    # mixture gives 0.93.
    assert np.mean(chain.std(axis=(0, 1))) == pytest.approx(1.0, abs=0.03)
    assert np.abs(chain.mean(axis=(0, 1))).max() < 0.1


def test_same_generator_gives_the_same_chain_whatever_numpys_global_state() -> None:
    config = SamplerConfig(walkers=16, check_steps=50, max_steps=50)
    chains = []
    for _ in range(2):
        rng = np.random.default_rng(3)
        start = rng.standard_normal((16, 3))
        chain, _ = sample_chain(lambda x: -0.5 * np.sum(x**2, axis=1), start, config, rng)
        chains.append(chain)
    np.testing.assert_array_equal(chains[0], chains[1])


def test_autocorrelation_time_of_an_autoregression_is_known() -> None:
    rng = np.random.default_rng(5)
    decay, steps, walkers = 0.8, 20_000, 4
    noise = rng.standard_normal((steps, walkers, 1)) * np.sqrt(1 - decay**2)
    chain = np.empty_like(noise)
    chain[0] = rng.standard_normal((walkers, 1))
    for k in range(1, steps):
        chain[k] = decay * chain[k - 1] + noise[k]
    # (1 + a) / (1 - a) = 9; Sokal's estimate scatters by sqrt(2 (2 W + 1) / N) with W = 45, N = 8e4: 5 %.
    assert autocorrelation_steps(chain)[0] == pytest.approx(9.0, rel=0.15)


def test_split_rhat_sees_walkers_that_disagree_and_chains_that_drift() -> None:
    rng = np.random.default_rng(6)
    good = rng.standard_normal((1000, 8, 1))
    assert split_rhat(good)[0] == pytest.approx(1.0, abs=0.01)
    assert split_rhat(good + np.arange(8)[None, :, None])[0] > 1.5
    assert split_rhat(good + np.linspace(0, 3, 1000)[:, None, None])[0] > 1.1


def test_short_chain_is_refused_with_a_remedy() -> None:
    room = simulate_cell_room(1, REGIMES["p5"])
    config = SamplerConfig(walkers=16, check_steps=20, max_steps=20)
    answer = sample_wall_field(
        room.cells, room.contrasts, WallFieldConfig(), config, np.random.default_rng(0)
    )
    assert answer.predictive is None
    assert not answer.diagnostics.converged
    assert "max_steps" in answer.diagnostics.status


def test_chain_agrees_with_the_laplace_mixture_where_it_should() -> None:
    # Both integrate the same posterior over three well-behaved numbers, so only Monte Carlo error is left:
    # up to 3 % of the mixture of 24, 1 to 2 % of a chain of 300.
    room = simulate_cell_room(1, REGIMES["p5"])
    config = SamplerConfig(walkers=24, check_steps=100, min_effective=300.0, max_rhat=1.08)
    chain = sample_wall_field(room.cells, room.contrasts, WallFieldConfig(), config, np.random.default_rng(0))
    assert chain.predictive is not None, chain.diagnostics.status
    laplace = wall_field_predictive(room.cells, room.contrasts, WallFieldConfig(), np.random.default_rng(0))
    widths = [np.diff(p.interval(0.95), axis=0)[0] for p in (chain.predictive, laplace)]
    np.testing.assert_allclose(widths[0], widths[1], rtol=0.05)
    assert chain.end_error < 0.04
