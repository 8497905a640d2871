"""Gains that make images of the same wall equally bright."""

import numpy as np
from jaxtyping import Float

_ROUNDS = 30
"""Alternations; images along a path are chained by their overlaps, and each round reaches one further."""
_PULL = 0.02
"""Weight of the wish for no gain, in sightings: it holds images that overlap with no other."""


def balance(samples: Float[np.ndarray, "images places 3"]) -> Float[np.ndarray, "images 3"]:
    """Factors for every image and channel that make the same places equally bright.

    Least squares of log colours, alternating between the colour of each place and the gain of each image;
    places weigh in by their deviation as in a Cauchy loss, so that glare and moving things count little.

    Args:
        samples: colour of each place in each image, 0 to 255; NaN where it is not seen or saturated.

    Returns:
        positive factors whose geometric mean over the images that have samples is 1.
    """
    logs = np.log(np.maximum(samples, 1.0))
    seen = np.isfinite(logs)
    logs = np.where(seen, logs, 0.0)
    n_images = len(samples)
    gains = np.zeros((n_images, 3))
    weights = seen.astype(float)
    for _ in range(_ROUNDS):
        shifted = logs + gains[:, None]
        total = weights.sum(axis=0)
        place = (weights * shifted).sum(axis=0) / np.maximum(total, 1e-9)
        deviation = np.where(seen, place - shifted, 0.0)
        # A place seen once says nothing of any gain.
        voting = weights * (seen.sum(axis=0) > 1)
        gains += (voting * deviation).sum(axis=1) / (voting.sum(axis=1) + _PULL)
        used = seen.any(axis=1)
        gains -= gains.sum(axis=0) / np.maximum(used.sum(axis=0), 1)
        gains[~used] = 0.0
        scale = 1.4826 * np.median(np.abs(deviation[seen])) if seen.any() else 1.0
        weights = seen / (1.0 + (deviation / max(float(scale), 0.01)) ** 2)
    return np.exp(gains)
