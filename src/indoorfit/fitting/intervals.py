"""What is believed of the planes carried over to anything that is smooth in them, at any level."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from indoorfit.model import Spread

from .belief import Belief
from .uncertainty import TypeB, expand_ends
from .uncertainty.cells import ROTATIONS

_HULL = 0.95
"""Level of the intervals whose hull tells the standard uncertainty where two models contradict each other."""


@dataclass(frozen=True)
class MeasurandPrediction:
    """The distribution of every measurand: a `model.Prediction`.

    First order in the offsets: exact for lengths; for areas the neglected term is the product of two
    offset errors, a millionth of a square metre for errors of a millimetre. First order in yaws, too.
    """

    belief: Belief
    values: Float[np.ndarray, " measurands"]
    """At `belief.shape`, each in its own unit."""
    gradients: Float[np.ndarray, "measurands parameters"]
    """With respect to the plane offsets, unit per metre, then the yaws of oblique planes, unit per radian."""
    type_b: TypeB = field(default_factory=TypeB)
    """Added in quadrature."""
    inflation: float = 1.0
    """Factor on all of it, about the value; see `BeliefConfig.inflation`."""

    def at(self, level: float) -> Spread:
        """Standard uncertainties, their parts, and intervals of this nominal coverage.

        Source: JCGM 100:2008, 5.1.2 and 6.3; F.2.4.5 for a value that is not the centre.
        """
        std, low, high, centre, dof = self._data(level)
        if not self.belief.torn:
            # A value that was not moved to the centre of its distribution, as the greedy one, is off by a
            # known amount: U + |b| about the value.
            off = self.values - centre
            std, low, high = np.hypot(std, off), low + off - np.abs(off), high + off + np.abs(off)
        # The definition's figure is that of a distance of two planes.
        per_plane_m = self.type_b.definition_std_m / np.sqrt(2.0)
        expanded = expand_ends(
            centre=np.clip(self.values, low, high),
            std=std,
            ends=(low, high),
            scale_std=self.type_b.scale_std * np.abs(self._grown),
            definition_std=per_plane_m * np.linalg.norm(self._by_offsets, axis=1),
            data_dof=dof,
            scale_dof=self.type_b.scale_dof,
            level=level,
        )
        factor = self.inflation
        return Spread(
            level=level,
            low=self.values + factor * (expanded.low - self.values),
            high=self.values + factor * (expanded.high - self.values),
            std=factor * expanded.std,
            data_std=factor * expanded.data_std,
            scale_std=factor * expanded.scale_std,
            definition_std=factor * expanded.definition_std,
            effective_dof=expanded.effective_dof,
        )

    @property
    def _grown(self) -> Float[np.ndarray, " measurands"]:
        """By how much each measurand grows per unit of relative scale: once a length, twice an area."""
        return self._by_offsets @ self.belief.shape.offsets_m

    @property
    def _by_offsets(self) -> Float[np.ndarray, "measurands planes"]:
        return self.gradients[:, : len(self.belief.shape.planes)]

    def _data(self, level: float) -> tuple[Float[np.ndarray, " measurands"], ...]:
        """Standard deviation, interval, mean and degrees of freedom from the scan alone."""
        belief = self.belief
        matrix = np.concatenate([np.zeros((len(self.gradients), ROTATIONS)), self.gradients], axis=1)
        wall = belief.wall.with_contrasts(matrix)
        low, high = wall.interval(level)
        parts = (wall.std, low, high, wall.mean)
        dof = wall.variance_dof
        if belief.pose is not None:
            pose = belief.pose.with_contrasts(matrix)
            pose_low, pose_high = pose.interval(level)
            dof = np.minimum(dof, pose.variance_dof)
            if belief.torn:
                low, high = np.minimum(low, pose_low), np.maximum(high, pose_high)
                # A uniform distribution over the hull at 95 %, whatever level is asked for.
                ends = np.stack([*wall.interval(_HULL), *pose.interval(_HULL)])
                std = np.maximum(wall.std, np.ptp(ends, axis=0) / np.sqrt(12.0))
                parts = (std, low, high, wall.mean)
            else:
                share = belief.wall_share
                others = (pose.std, pose_low, pose_high, pose.mean)
                parts = tuple(share * a + (1.0 - share) * b for a, b in zip(parts, others, strict=True))
        # So far these are linear functions of the parameters; the measurand may have a constant besides.
        shift = self.values - self.gradients @ belief.shape.parameters
        return parts[0], parts[1] + shift, parts[2] + shift, parts[3] + shift, dof
