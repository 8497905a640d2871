"""How far everything that was measured may be off: at one level, and at any."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

STANDARD_LEVELS = (0.5, 0.8, 0.9, 0.95, 0.99)
"""Nominal coverages whose intervals every result carries, whichever level it was asked for."""


@dataclass(frozen=True)
class Spread:
    """Uncertainty of every measurand at one level, each in the measurand's own unit (m, m² or m³)."""

    level: float
    """Nominal coverage of the interval, 0 to 1."""
    low: Float[np.ndarray, " measurands"]
    high: Float[np.ndarray, " measurands"]
    std: Float[np.ndarray, " measurands"]
    """Combined standard uncertainty: the root of the sum of the squares of the three parts below."""
    data_std: Float[np.ndarray, " measurands"]
    """Seen in the residuals of the scan (Type A)."""
    scale_std: Float[np.ndarray, " measurands"]
    """From a possible error of the scan's scale (Type B)."""
    definition_std: Float[np.ndarray, " measurands"]
    """From what the wall is taken to be: plaster, skirting, walls out of parallel (Type B)."""
    effective_dof: Float[np.ndarray, " measurands"]
    """Welch and Satterthwaite's degrees of freedom of `std`; infinite where it is as good as known."""


@runtime_checkable
class Prediction(Protocol):
    """All that is known of the measurands, to be asked for one level at a time; nothing is fitted again."""

    def at(self, level: float) -> Spread:
        """Uncertainty with intervals of this nominal coverage (0 to 1, both excluded)."""
        ...
