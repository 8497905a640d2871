"""Standard uncertainties and intervals of anything that is smooth in the plane offsets."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .belief import Belief
from .uncertainty import Predictive


@dataclass(frozen=True)
class Intervals:
    """One entry per measurand."""

    std: Float[np.ndarray, " measurands"]
    low: Float[np.ndarray, " measurands"]
    high: Float[np.ndarray, " measurands"]


def intervals(
    belief: Belief,
    values: Float[np.ndarray, " measurands"],
    gradients: Float[np.ndarray, "measurands planes"],
    level: float,
) -> Intervals:
    """Propagate what is believed of the planes to measurands.

    First order in the offsets: exact for lengths; for areas the neglected term is the product of two
    offset errors, a millionth of a square metre for errors of a millimetre.

    Args:
        belief: of the planes.
        values: of the measurands at `belief.shape`, their own unit.
        gradients: unit per metre.
        level: nominal coverage.
    """
    matrix = np.concatenate([np.zeros((len(gradients), 3)), gradients], axis=1)
    std, low, high = _spread(belief.wall.with_contrasts(matrix), level)
    if belief.pose is not None:
        pose = _spread(belief.pose.with_contrasts(matrix), level)
        if belief.torn:
            low, high = np.minimum(low, pose[1]), np.maximum(high, pose[2])
            # A uniform distribution over the hull.
            std = np.maximum(std, (high - low) / np.sqrt(12.0))
        else:
            share = belief.wall_share
            std, low, high = (
                share * a + (1.0 - share) * b for a, b in zip((std, low, high), pose, strict=True)
            )
    # Quantiles of linear functions of the offsets; the measurand itself may have a constant besides.
    shift = values - gradients @ belief.shape.offsets_m
    return Intervals(std, low + shift, high + shift)


def _spread(
    predictive: Predictive, level: float
) -> tuple[Float[np.ndarray, " m"], Float[np.ndarray, " m"], Float[np.ndarray, " m"]]:
    low, high = predictive.interval(level)
    return predictive.std, low, high
