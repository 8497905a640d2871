"""How good intervals are: coverage with its own uncertainty, interval score, reliability."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Coverage:
    """The share of intervals that hold the truth, and what a sample of this size says of it."""

    share: float
    """NaN without any interval."""
    low: float
    high: float
    """Ends of the 95 % interval of the share."""
    n: int


_Z95 = 1.959963984540054
"""97.5 % quantile of the standard normal distribution."""


def coverage(hits: ArrayLike) -> Coverage:
    """Share of hits with Wilson's interval, which stays inside 0..1 and is no point at 0 or n hits.

    Lengths of one room share planes, so for them the interval is too narrow; it is exact only for
    independent hits.

    Args:
        hits: true where the interval holds the truth.

    Source: E. B. Wilson, Probable inference, the law of succession, and statistical inference, J. Am. Stat.
    Assoc. 22 (1927).
    """
    taken = np.asarray(hits, bool).ravel()
    n = len(taken)
    if n == 0:
        return Coverage(float("nan"), 0.0, 1.0, 0)
    share = float(taken.mean())
    return Coverage(share, *wilson(share, float(n)), n)


def wilson(share: float, n: float) -> tuple[float, float]:
    """Ends of the 95 % interval of a share that was seen in `n` independent cases.

    Args:
        share: 0 to 1.
        n: cases; need not be whole where it is what dependent cases are worth.
    """
    z2 = _Z95**2
    middle = (share + z2 / (2 * n)) / (1 + z2 / n)
    half = _Z95 / (1 + z2 / n) * math.sqrt(share * (1 - share) / n + z2 / (4 * n**2))
    return max(0.0, middle - half), min(1.0, middle + half)


Numbers = float | Float[np.ndarray, "..."]


def interval_score(low: Numbers, high: Numbers, truth: Numbers, level: float) -> Numbers:
    """Width plus 2 / (1 - level) times the distance by which the truth was missed; smaller is better.

    Proper: no other interval has a smaller expected score than the central one of the true distribution.

    Args:
        low: in any unit; the score has the same one.
        high: likewise.
        truth: likewise.
        level: nominal coverage, 0 to 1.

    Source: T. Gneiting & A. E. Raftery, Strictly proper scoring rules, prediction, and estimation, J. Am.
    Stat. Assoc. 102 (2007), eq. 43.
    """
    missed = np.maximum(low - truth, 0.0) + np.maximum(truth - high, 0.0)
    return high - low + 2.0 / (1.0 - level) * missed


def reliability(hits_by_level: Mapping[float, ArrayLike]) -> dict[float, Coverage]:
    """Coverage at each nominal level, in increasing order."""
    return {level: coverage(hits_by_level[level]) for level in sorted(hits_by_level)}
