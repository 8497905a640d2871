"""Conservative fusion of two predictive distributions of the same dimensions.

Both come from the same points, so they are taken as fully correlated: quantiles are averaged, and the fused
width is the average and not the root of the sum of squares. Weights are 1/u^2. Where the two contradict each
other the wall field is blind to a displaced face, and the pose field stands alone.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from .predictive import DerivedQuantities, Predictive


@dataclass(frozen=True)
class FusionConfig:
    """When two answers are too far apart to be averaged."""

    inconsistent_sigmas: float = 3.0
    """Difference over its standard uncertainty beyond which a dimension is REGISTRATION_INCONSISTENT; 3 gives
    at most 0.6 % false alarms on rooms without displaced faces, 2 gives 2.6 %."""


@dataclass(frozen=True)
class FusedPredictive:
    """Quantile average of a wall-field and a pose-field distribution."""

    wall: Predictive
    pose: Predictive
    config: FusionConfig

    @property
    def inconsistent(self) -> Bool[np.ndarray, " dims"]:
        """Dimensions with REGISTRATION_INCONSISTENT: only the pose field's answer counts."""
        return _inconsistent(self.wall.mean, self.wall.std, self.pose.mean, self.pose.std, self.config)

    @property
    def wall_share(self) -> Float[np.ndarray, " dims"]:
        """Weight of the wall field, 0 to 1."""
        return _wall_share(self.wall.std, self.pose.std, self.inconsistent)

    @property
    def measured(self) -> Bool[np.ndarray, " dims"]:
        """Dimensions that rest on planes with cells."""
        return self.wall.measured | self.pose.measured

    @property
    def mean(self) -> Float[np.ndarray, " dims"]:
        """Weighted mean, metres."""
        return _blend(self.wall_share, self.wall.mean, self.pose.mean)

    @property
    def std(self) -> Float[np.ndarray, " dims"]:
        """Standard deviation under full correlation, metres."""
        return _blend(self.wall_share, self.wall.std, self.pose.std)

    @property
    def variance_dof(self) -> Float[np.ndarray, " dims"]:
        """Degrees of freedom of `std`: those of the less certain member."""
        return np.minimum(self.wall.variance_dof, self.pose.variance_dof)

    def interval(self, level: float) -> tuple[Float[np.ndarray, " dims"], Float[np.ndarray, " dims"]]:
        """Averaged quantiles, metres."""
        wall, pose, share = self.wall.interval(level), self.pose.interval(level), self.wall_share
        return _blend(share, wall[0], pose[0]), _blend(share, wall[1], pose[1])

    def quantile(self, probability: float) -> Float[np.ndarray, " dims"]:
        """Averaged quantile, metres."""
        return _blend(self.wall_share, self.wall.quantile(probability), self.pose.quantile(probability))

    def covariance(self) -> Float[np.ndarray, "dims dims"]:
        """Fused variances with the mean of the two correlations, m^2."""
        correlations = []
        for member in (self.wall, self.pose):
            covariance = member.covariance()
            scale = np.sqrt(np.maximum(covariance.diagonal(), np.finfo(float).tiny))
            correlations.append(covariance / np.outer(scale, scale))
        return np.outer(self.std, self.std) * 0.5 * (correlations[0] + correlations[1])

    def derived(
        self,
        function: Callable[[Float[np.ndarray, "draws params"]], Float[np.ndarray, "draws quantities"]],
        rng: np.random.Generator,
        draws: int,
        level: float,
    ) -> DerivedQuantities:
        """The same rule, weights and flag included, applied to nonlinear quantities of each member."""
        wall = self.wall.derived(function, rng, draws, level)
        pose = self.pose.derived(function, rng, draws, level)
        share = _wall_share(
            wall.std, pose.std, _inconsistent(wall.mean, wall.std, pose.mean, pose.std, self.config)
        )
        return DerivedQuantities(
            _blend(share, wall.mean, pose.mean),
            _blend(share, wall.std, pose.std),
            _blend(share, wall.low, pose.low),
            _blend(share, wall.high, pose.high),
        )

    @property
    def noise(self) -> Mapping[str, Any]:
        """Both noise models, the weights, and a sentence."""
        flagged = int(self.inconsistent.sum())
        sentence = (
            f"The wall field got {100 * float(np.mean(self.wall_share)):.0f} % of the weight, the pose field "
            f"the rest. {self.pose.noise.get('sentence', '')}"
        )
        if flagged:
            sentence += (
                f" For {flagged} of {len(self.inconsistent)} dimensions the two contradict each other: "
                "a block of frames is displaced, and the pose field alone is reported there."
            )
        return {
            "model": "fusion",
            "wall_field": dict(self.wall.noise),
            "pose_field": dict(self.pose.noise),
            "wall_share": [float(share) for share in self.wall_share],
            "inconsistent": flagged,
            "prior_dominated": bool(self.pose.noise.get("prior_dominated", False)),
            "sentence": sentence,
        }


def fuse(wall: Predictive, pose: Predictive, config: FusionConfig) -> FusedPredictive:
    """Fuse two answers to the same contrasts."""
    assert np.array_equal(wall.contrasts, pose.contrasts), "only answers to the same question can be fused"
    return FusedPredictive(wall, pose, config)


def _inconsistent(
    wall_mean: Float[np.ndarray, " n"],
    wall_std: Float[np.ndarray, " n"],
    pose_mean: Float[np.ndarray, " n"],
    pose_std: Float[np.ndarray, " n"],
    config: FusionConfig,
) -> Bool[np.ndarray, " n"]:
    return np.abs(wall_mean - pose_mean) > config.inconsistent_sigmas * np.hypot(wall_std, pose_std)


def _wall_share(
    wall_std: Float[np.ndarray, " n"],
    pose_std: Float[np.ndarray, " n"],
    inconsistent: Bool[np.ndarray, " n"],
) -> Float[np.ndarray, " n"]:
    # 1e-12 m: noise-free simulations have two zeros, which then share equally.
    wall, pose = np.maximum(wall_std, 1e-12), np.maximum(pose_std, 1e-12)
    share = 1.0 / (1.0 + (np.minimum(wall, 1e6) / np.minimum(pose, 1e6)) ** 2)
    return np.where(inconsistent, 0.0, share)


def _blend(
    share: Float[np.ndarray, " n"], wall: Float[np.ndarray, " n"], pose: Float[np.ndarray, " n"]
) -> Float[np.ndarray, " n"]:
    """share * wall + (1 - share) * pose, without 0 * inf."""
    with np.errstate(invalid="ignore"):
        mixed = share * wall + (1.0 - share) * pose
    return np.where(share == 0.0, pose, np.where(share == 1.0, wall, mixed))
