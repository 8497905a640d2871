"""What no residual shows: a global scale error, and what the length of a room is defined to be.

Source: JCGM 100:2008 (GUM), 4.3 (Type B), 5.1.2 (quadrature), G.4 (effective degrees of freedom).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.special import ndtri

from .predictive import Distribution


@dataclass(frozen=True)
class TypeBConfig:
    """Uncertainties that come from knowledge of the sensor and of the wall, not from the scan."""

    scale_std: float = 0.004
    """Relative standard uncertainty of all lengths: 0.4 % for an uncalibrated Kinect v1, 0.15 % after
    calibration, 1e-5 to 1e-4 for a laser scanner. A tape measure of one long wall replaces it."""
    scale_dof: float = 50.0
    """Degrees of freedom of that figure: a data sheet's, good to about 10 %."""
    definition_std_m: float = 0.002
    """Where the wall is: plaster, skirting, walls that are not quite parallel."""


@dataclass(frozen=True)
class ExpandedUncertainty:
    """Interval and budget of quantities, all in the quantity's unit."""

    low: Float[np.ndarray, " n"]
    high: Float[np.ndarray, " n"]
    std: Float[np.ndarray, " n"]
    """Combined standard uncertainty u_c."""
    data_std: Float[np.ndarray, " n"]
    scale_std: Float[np.ndarray, " n"]
    definition_std: Float[np.ndarray, " n"]
    coverage_factor: Float[np.ndarray, " n"]
    """Half width of the interval over u_c."""
    effective_dof: Float[np.ndarray, " n"]
    """Welch-Satterthwaite."""


def expand_dimensions(distribution: Distribution, level: float, config: TypeBConfig) -> ExpandedUncertainty:
    """Interval of every dimension with scale and definition included, metres."""
    low, high = distribution.interval(level)
    return expand_ends(
        centre=distribution.quantile(0.5),
        std=distribution.std,
        ends=(low, high),
        scale_std=config.scale_std * np.abs(distribution.mean),
        definition_std=np.full(len(low), config.definition_std_m),
        data_dof=distribution.variance_dof,
        scale_dof=config.scale_dof,
        level=level,
    )


def expand_ends(
    centre: Float[np.ndarray, " n"],
    std: Float[np.ndarray, " n"],
    ends: tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]],
    scale_std: Float[np.ndarray, " n"],
    definition_std: Float[np.ndarray, " n"],
    data_dof: Float[np.ndarray, " n"],
    scale_dof: float,
    level: float,
) -> ExpandedUncertainty:
    """Stretch an interval of any quantity about its median by sqrt(1 + (u_B / u_data)^2).

    Args:
        centre, std, ends: median, standard deviation and interval from the data alone.
        scale_std: of the quantity: u_s times a length, 2 u_s times an area, 3 u_s times a volume.
        definition_std: of the quantity.
        data_dof, scale_dof: degrees of freedom of the first two parts; the definition's count as infinite.
        level: of the interval.
    """
    type_b = np.hypot(scale_std, definition_std)
    combined = np.hypot(std, type_b)
    finite = np.isfinite(std)
    # Where the data leave (nearly) nothing, only the Type B part remains, and it is Gaussian.
    factor = float(ndtri(0.5 + level / 2))
    dominant = std > 1e-6 * type_b
    stretch = np.where(dominant & finite, combined / np.where(dominant & finite, std, 1.0), 1.0)
    centre = np.where(finite, centre, 0.0)
    low, high = (centre + stretch * (np.where(finite, end, 0.0) - centre) for end in ends)
    low, high = (
        np.where(dominant, end, centre + sign * factor * combined) for end, sign in ((low, -1), (high, 1))
    )
    low, high = np.where(finite, low, -np.inf), np.where(finite, high, np.inf)
    parts = np.where(finite, std, 0.0) ** 4 / data_dof + scale_std**4 / scale_dof
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(parts > 0, np.where(finite, combined, 0.0) ** 4 / parts, np.inf)
        coverage = np.where(finite & (combined > 0), (high - low) / (2 * combined), factor)
    return ExpandedUncertainty(low, high, combined, std, scale_std, definition_std, coverage, dof)
