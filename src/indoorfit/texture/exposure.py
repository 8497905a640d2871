"""Gains that make images of the same wall equally bright."""

import numpy as np
from jaxtyping import Float

from indoorfit.geometry import MAD_TO_STD

_ROUNDS = 6
"""Of reweighting; the weights hardly change after three."""
_PULL = 1e-3
"""Weight of the wish for no gain, in sightings: it settles what the overlaps leave open and no more."""
_LEAST_SPREAD = 0.01
"""Of the logarithms: 8 bits are no finer in dark places."""


def balance(samples: Float[np.ndarray, "images places 3"]) -> Float[np.ndarray, "images 3"]:
    """Factors for every image and channel that make the same places equally bright.

    Least squares of log colours over the gains and the colours of the places; the latter are eliminated, so
    that a linear system as large as the number of images is left. Reweighted as for a Cauchy loss, so that
    glare and moving things count little.

    Args:
        samples: colour of each place in each image, 0 to 255; NaN where it is not seen or saturated.

    Returns:
        positive factors whose geometric mean over the images that have samples is 1; 1 for the others.
    """
    seen = np.isfinite(samples[..., 0])
    used = seen.any(axis=1)
    # A place seen once says nothing of any gain.
    shared = seen.sum(axis=0) > 1
    seen = seen[:, shared]
    if not seen.any():
        return np.ones((len(samples), 3))
    gains = np.zeros((len(samples), 3))
    for channel in range(3):
        values = samples[:, shared, channel]
        logs = np.where(seen, np.log(np.maximum(np.where(seen, values, 1.0), 1.0)), 0.0)
        gains[:, channel] = _gains(logs, seen.astype(float))
    gains[used] -= gains[used].mean(axis=0)
    gains[~used] = 0.0
    return np.exp(gains)


def _gains(
    logs: Float[np.ndarray, "images places"], seen: Float[np.ndarray, "images places"]
) -> Float[np.ndarray, " images"]:
    gains, weights = np.zeros(len(logs)), seen
    for _ in range(_ROUNDS):
        total = np.maximum(weights.sum(axis=0), 1e-9)
        scaled = weights / np.sqrt(total)
        # Normal equations after elimination: deviations from the weighted mean of each place.
        system = np.diag(weights.sum(axis=1) + _PULL) - scaled @ scaled.T
        means = (weights * logs).sum(axis=0) / total
        gains = np.linalg.solve(system, (weights * (means - logs)).sum(axis=1))
        shifted = logs + gains[:, None]
        deviation = shifted - (weights * shifted).sum(axis=0) / total
        spread = MAD_TO_STD * float(np.median(np.abs(deviation[seen > 0.0])))
        weights = seen / (1.0 + (deviation / max(2.0 * spread, _LEAST_SPREAD)) ** 2)
    return gains
