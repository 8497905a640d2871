"""What no residual shows: a global scale error, and what the length of a room is defined to be.

Source: JCGM 100:2008 (GUM), 4.3 (Type B), 5.1.2 (quadrature), G.4 (effective degrees of freedom).
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from jaxtyping import Float
from scipy.special import ndtri

SensorName = Literal["unknown", "kinect_v1", "kinect_v1_calibrated", "phone_lidar", "laser"]


@dataclass(frozen=True)
class TypeBConfig:
    """Uncertainties that come from knowledge of the sensor and of the wall, not from the scan."""

    sensor: SensorName = "unknown"
    """Sets the two figures below: `kinect_v1` 0.4 % and 2 mm, `kinect_v1_calibrated` 0.15 % and 2 mm,
    `phone_lidar` 0.5 % and 2 mm, `laser` 0.001 % and 2.3 mm. With `unknown` nothing is added, and the output
    says so: a figure without a source would make the intervals of some sensors too wide, of others too
    narrow."""
    scale_std: float | None = None
    """Relative standard uncertainty of all lengths; default: the sensor's. One length over 3 m measured by
    tape or laser is a better source than any data sheet: then give that measurement's relative
    uncertainty."""
    scale_dof: float = 50.0
    """Degrees of freedom of that figure: a data sheet's, good to about 10 %."""
    definition_std_m: float | None = None
    """Where the wall is: plaster, skirting, walls that are not quite parallel; default: the sensor's. 0 is
    right for the distance of the mean planes of what was seen, 2 mm for what a tape will read elsewhere."""


@dataclass(frozen=True)
class TypeB:
    """The figures in use, and where they come from."""

    scale_std: float = 0.0
    scale_dof: float = 50.0
    definition_std_m: float = 0.0
    source: str = "no sensor was named"

    @property
    def sentence(self) -> str:
        """In plain words, for the output."""
        if self.scale_std == 0.0 and self.definition_std_m == 0.0:
            return (
                "Nothing is added for the scan's scale, which leaves no trace in the points, nor for plaster "
                f"and skirting ({self.source}): name the sensor, or measure one length over 3 m by hand."
            )
        return (
            f"Added for what the points cannot show ({self.source}): {100 * self.scale_std:.3g} % of every "
            f"length for the scan's scale, and {1e3 * self.definition_std_m:.2g} mm for where the wall is "
            "(standard uncertainties)."
        )

    def as_noise(self) -> dict[str, Any]:
        """The figures as part of the noise model."""
        return {
            "scale_std": self.scale_std,
            "scale_dof": self.scale_dof,
            "definition_std_m": self.definition_std_m,
            "source": self.source,
        }


_PRESETS: dict[SensorName, TypeB] = {
    "unknown": TypeB(),
    # Relative scale of an uncalibrated depth camera, and after calibration of its intrinsics (Khoshelham and
    # Oude Elberink 2012 find no large systematic error once calibrated); 2 mm of plaster and skirting.
    "kinect_v1": TypeB(4e-3, 50.0, 2e-3, "an uncalibrated Kinect v1"),
    "kinect_v1_calibrated": TypeB(1.5e-3, 50.0, 2e-3, "a calibrated Kinect v1"),
    # No data sheet says; the scale of a phone's visual-inertial track is good to about this. Few degrees of
    # freedom, for it is our own estimate.
    "phone_lidar": TypeB(5e-3, 10.0, 2e-3, "a phone with LiDAR, our own estimate"),
    # Data sheets: 10 ppm and an additive error of up to 1 mm, which moves opposite walls apart by twice that;
    # as a uniform distribution 1.15 mm, with 2 mm of plaster 2.3 mm.
    "laser": TypeB(1e-5, 50.0, 2.3e-3, "a terrestrial laser scanner's data sheet"),
}


def type_b_of(config: TypeBConfig) -> TypeB:
    """The sensor's figures, with those replaced that were given."""
    preset = _PRESETS[config.sensor]
    source = preset.source
    if config.scale_std is not None or config.definition_std_m is not None:
        source = "settings" if config.sensor == "unknown" else f"{source}; settings"
    return TypeB(
        preset.scale_std if config.scale_std is None else config.scale_std,
        # A preset without a scale term has no degrees of freedom of its own.
        config.scale_dof if config.scale_std is not None or preset.scale_std == 0.0 else preset.scale_dof,
        preset.definition_std_m if config.definition_std_m is None else config.definition_std_m,
        source,
    )


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
    effective_dof: Float[np.ndarray, " n"]
    """Welch-Satterthwaite."""


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
    """Stretch an interval of any quantity about its centre by sqrt(1 + (u_B / u_data)^2).

    Args:
        centre, std, ends: value, standard deviation and interval from the data alone.
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
    return ExpandedUncertainty(low, high, combined, std, scale_std, definition_std, dof)
