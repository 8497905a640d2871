"""Many lengths in a few numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .intervals import Coverage, coverage
from .lengths import LengthCheck


@dataclass(frozen=True)
class Summary:
    """Figures over a set of lengths; NaN where there are none."""

    n: int
    rmse_m: float
    mad_m: float
    """Median absolute deviation of the errors from their median; times 1.4826 it is a standard deviation
    that gross errors do not move."""
    bias_m: float
    """Mean error."""
    largest_m: float
    """Largest absolute error."""
    coverage: Coverage
    mean_score_m: float
    """Mean interval score."""
    median_width_m: float
    mean_width_m: float


def summarise(checks: Sequence[LengthCheck]) -> Summary:
    """Summarise lengths, of one room or of many."""
    held = coverage([check.hit for check in checks])
    if not checks:
        nan = float("nan")
        return Summary(0, nan, nan, nan, nan, held, nan, nan, nan)
    errors = np.array([check.error_m for check in checks])
    widths = np.array([check.width_m for check in checks])
    return Summary(
        n=len(checks),
        rmse_m=float(np.sqrt(np.mean(errors**2))),
        mad_m=float(np.median(np.abs(errors - np.median(errors)))),
        bias_m=float(errors.mean()),
        largest_m=float(np.abs(errors).max()),
        coverage=held,
        mean_score_m=float(np.mean([check.score_m for check in checks])),
        median_width_m=float(np.median(widths)),
        mean_width_m=float(widths.mean()),
    )
