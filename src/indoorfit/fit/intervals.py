"""Standard uncertainties and intervals of anything that is smooth in the plane offsets."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.model import Shape

from .residuals import with_inferred
from .uncertainty import Cells, Contrasts, WallFieldConfig, wall_field_predictive


@dataclass(frozen=True)
class IntervalConfig:
    """How intervals are made."""

    wall_field: WallFieldConfig = field(default_factory=WallFieldConfig)
    """The Gaussian-process field of wall residuals."""


@dataclass(frozen=True)
class Intervals:
    """One entry per measurand."""

    std: Float[np.ndarray, " measurands"]
    low: Float[np.ndarray, " measurands"]
    high: Float[np.ndarray, " measurands"]
    noise: dict[str, Any]
    """The estimated noise model, with an `explanation` in plain words."""


_CONDITIONS = (
    "Intervals assume that the scan's scale is true and that different faces were registered "
    "independently: an error of scale, or a whole face that slipped, leaves no trace in a cloud without "
    "frame ids."
)


def intervals(
    cells: Cells,
    shape: Shape,
    values: Float[np.ndarray, " measurands"],
    gradients: Float[np.ndarray, "measurands planes"],
    inferred_std_m: float,
    level: float,
    config: IntervalConfig,
    rng: np.random.Generator,
) -> Intervals:
    """Propagate the wall field to measurands.

    First order in the offsets: exact for lengths; for areas the neglected term is the product of two
    offset errors, a millionth of a square metre for errors of a millimetre.

    Args:
        cells: residuals of the fit at `shape`.
        shape: fitted.
        values: of the measurands, their own unit.
        gradients: unit per metre.
        inferred_std_m: of planes without points.
        level: nominal coverage.
        config: see `IntervalConfig`.
        rng: for the draws of the noise scales.
    """
    matrix = np.concatenate([np.zeros((len(gradients), 3)), gradients], axis=1)
    contrasts = Contrasts(matrix, np.concatenate([np.zeros(3), shape.offsets_m]))
    predictive = wall_field_predictive(
        with_inferred(cells, shape, inferred_std_m), contrasts, config.wall_field, rng
    )
    low, high = predictive.interval(level)
    noise = dict(predictive.noise)
    noise["explanation"] = f"{noise.pop('sentence')} {_CONDITIONS}"
    shift = values - contrasts.values_m
    return Intervals(predictive.std, low + shift, high + shift, noise)
