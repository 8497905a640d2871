"""Diagnostics of Markov chains, and emcee set up so that its widths are right.

Never `emcee.moves.DESnookerMove`: in emcee 3.1.6 it divides the direction by the root of its norm and has a
spurious exponent in its Jacobian, so a standard normal comes out 15 to 25 % too narrow, with healthy-looking
acceptance and autocorrelation. The tests hold the moves used here against a known Gaussian.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

LogProb = Callable[[Float[np.ndarray, "walkers dim"]], Float[np.ndarray, " walkers"]]
"""Log density of many points at once; -inf is allowed, NaN is not."""


@dataclass(frozen=True)
class SamplerConfig:
    """How long to sample, and when to believe it."""

    walkers: int = 32
    """Evaluated sixteen at a time; more make single steps dearer without mixing faster."""
    check_steps: int = 200
    """Between two looks at the diagnostics."""
    max_steps: int = 4000
    """Where sampling gives up."""
    burn_share: float = 0.25
    """Leading part of the chain that is thrown away; the walkers start at the Laplace approximation."""
    max_rhat: float = 1.03
    """Of 64 half walkers: each has then some 17 effective draws of its own, all of them a thousand. (The
    customary 1.01 is meant for four long chains; here it would ask for three thousand draws.)"""
    min_lengths: float = 30.0
    """Autocorrelation times that the kept chain must span, or tau itself is not known."""
    min_effective: float = 1000.0
    """Effective draws: 1 % Monte Carlo error of 95 % interval ends, since the geometry is integrated."""


@dataclass(frozen=True)
class ChainDiagnostics:
    """What the chain looks like; `converged` decides whether anything may be reported from it."""

    rhat: Float[np.ndarray, " dim"]
    """Split R-hat per coordinate, 1 when walkers and halves agree."""
    autocorrelation_steps: Float[np.ndarray, " dim"]
    """Integrated autocorrelation time."""
    effective: Float[np.ndarray, " dim"]
    """Effective sample size."""
    acceptance: float
    steps: int
    """Steps per walker, burn-in included."""
    converged: bool
    status: str
    """`converged`, or what is wrong and what to do."""


def split_rhat(chain: Float[np.ndarray, "steps walkers dim"]) -> Float[np.ndarray, " dim"]:
    """Between-chain over within-chain spread, each walker cut in two.

    Source: Gelman et al. 2013, Bayesian Data Analysis, 11.4. Walkers of an ensemble are not independent, so
    this is an optimistic figure; the limit on the chain's length in autocorrelation times covers that.
    """
    half = len(chain) // 2
    halves = np.concatenate([chain[:half], chain[half : 2 * half]], axis=1)
    within = np.mean(np.var(halves, axis=0, ddof=1), axis=0)
    between = half * np.var(np.mean(halves, axis=0), axis=0, ddof=1)
    return np.sqrt((half - 1) / half + between / (half * np.maximum(within, np.finfo(float).tiny)))


def autocorrelation_steps(chain: Float[np.ndarray, "steps walkers dim"]) -> Float[np.ndarray, " dim"]:
    """Integrated autocorrelation time, averaged over walkers, with Sokal's window of five times itself."""
    steps = len(chain)
    centred = chain - chain.mean(axis=(0, 1))
    spectrum = np.fft.rfft(centred, n=2 * steps, axis=0)
    lagged = np.fft.irfft(np.abs(spectrum) ** 2, axis=0)[:steps].mean(axis=1)
    correlation = lagged / np.maximum(lagged[0], np.finfo(float).tiny)
    times = 2.0 * np.cumsum(correlation, axis=0) - 1.0
    beyond = np.arange(steps)[:, None] >= 5.0 * times
    window = np.where(beyond.any(axis=0), np.argmax(beyond, axis=0), steps - 1)
    return np.maximum(times[window, np.arange(chain.shape[2])], 1.0)


def sample_chain(
    log_prob: LogProb,
    start: Float[np.ndarray, "walkers dim"],
    config: SamplerConfig,
    rng: np.random.Generator,
) -> tuple[Float[np.ndarray, "steps walkers dim"], ChainDiagnostics]:
    """Steps until the diagnostics hold or `max_steps`.

    Half of them propose from a kernel density estimate of the other half of the walkers: a scale that the
    data hardly tell has a tail far longer than its mode is wide, which steps of one width cross slowly (on
    rooms drawn from the prior the autocorrelation time is half of what it is without, or less). The rest are
    differential-evolution and stretch moves, which do not hang on how well so few walkers give a density.

    Args:
        log_prob: vectorised.
        start: finite log density everywhere, in coordinates whitened as well as one can.
        config: lengths and limits.
        rng: seeds emcee, which would otherwise seed itself from numpy's global state.

    Returns:
        the chain after burn-in, and its diagnostics. Not converged is a status and not an exception.
    """
    import emcee  # two seconds of start-up for a sampler that few runs ask for

    moves = [(emcee.moves.KDEMove(), 0.5), (emcee.moves.DEMove(), 0.25), (emcee.moves.StretchMove(), 0.25)]
    walkers, dim = start.shape
    sampler = emcee.EnsembleSampler(walkers, dim, log_prob, moves=moves, vectorize=True)
    # emcee wants a legacy state; this is its only way in, and it is local to the sampler.
    legacy = np.random.RandomState(int(rng.integers(2**31)))
    state = emcee.State(start, random_state=legacy.get_state())
    while True:
        state = sampler.run_mcmc(state, config.check_steps)
        steps = sampler.iteration
        full = np.asarray(sampler.get_chain())
        kept = full[int(config.burn_share * steps) :]
        acceptance = float(np.mean(sampler.acceptance_fraction))
        diagnostics = diagnose(kept, steps, acceptance, config)
        if diagnostics.converged or steps >= config.max_steps:
            return kept, diagnostics


def diagnose(
    chain: Float[np.ndarray, "steps walkers dim"], steps: int, acceptance: float, config: SamplerConfig
) -> ChainDiagnostics:
    """Judge a chain after burn-in."""
    rhat, times = split_rhat(chain), autocorrelation_steps(chain)
    effective = chain.shape[0] * chain.shape[1] / times
    faults = []
    if float(rhat.max()) > config.max_rhat:
        faults.append(f"split R-hat {rhat.max():.3f}, needs <= {config.max_rhat}")
    if len(chain) < config.min_lengths * float(times.max()):
        faults.append(
            f"{len(chain)} kept steps at an autocorrelation time of {times.max():.0f}, "
            f"needs {config.min_lengths:.0f} times that"
        )
    if float(effective.min()) < config.min_effective:
        faults.append(f"{effective.min():.0f} effective draws, needs {config.min_effective:.0f}")
    status = "converged" if not faults else "; ".join(faults) + ". Fix: raise sampler.max_steps."
    return ChainDiagnostics(rhat, times, effective, acceptance, steps, not faults, status)
