"""What is believed about theta after the data: a mixture of Gaussians, one per draw of the noise model."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import ndtr

_BISECTIONS = 52
"""Halvings of the bracket: 2^-52 of it is rounding."""


@runtime_checkable
class Distribution(Protocol):
    """What fused and plain predictive distributions have in common; all in metres."""

    @property
    def noise(self) -> Mapping[str, Any]:
        """The estimated noise model in plain values, with a `sentence` in plain words."""
        ...

    @property
    def mean(self) -> Float[np.ndarray, " dims"]:
        """Mean of every dimension."""
        ...

    @property
    def std(self) -> Float[np.ndarray, " dims"]:
        """Standard deviation of every dimension."""
        ...

    @property
    def variance_dof(self) -> Float[np.ndarray, " dims"]:
        """Degrees of freedom of `std`."""
        ...

    def interval(self, level: float) -> tuple[Float[np.ndarray, " dims"], Float[np.ndarray, " dims"]]:
        """Central interval: low and high end of every dimension."""
        ...

    def quantile(self, probability: float) -> Float[np.ndarray, " dims"]:
        """Quantile of every dimension."""
        ...

    def derived(
        self,
        function: Callable[[Float[np.ndarray, "draws params"]], Float[np.ndarray, "draws quantities"]],
        rng: np.random.Generator,
        draws: int,
        level: float,
    ) -> "DerivedQuantities":
        """Distribution of nonlinear functions of theta, such as areas."""
        ...


@dataclass(frozen=True)
class DerivedQuantities:
    """Nonlinear quantities, in whatever unit their function returns."""

    mean: Float[np.ndarray, " quantities"]
    std: Float[np.ndarray, " quantities"]
    low: Float[np.ndarray, " quantities"]
    high: Float[np.ndarray, " quantities"]


@dataclass(frozen=True)
class Predictive:
    """A mixture over draws of the noise model; given one draw, theta is Gaussian.

    A parameter without any cell stays at its estimate in `sample`, and dimensions that use it are
    `measured == False` with an infinite interval: a prior is never reported as a measurement.
    """

    weights: Float[np.ndarray, " draws"]
    """Non-negative, sum 1."""
    means: Float[np.ndarray, "draws params"]
    """theta itself (not the step from the linearisation point): radians, metres."""
    covariances: Float[np.ndarray, "draws params params"]
    seen: Bool[np.ndarray, " params"]
    """Parameters that the cells determine."""
    contrasts: Float[np.ndarray, "dims params"]
    noise: Mapping[str, Any] = field(default_factory=dict)
    screened: Bool[np.ndarray, " cells"] | None = None
    """Cells that the others contradict and that therefore count for little; None where none were judged."""

    def with_contrasts(self, contrasts: Float[np.ndarray, "dims params"]) -> "Predictive":
        """The same belief, asked for other dimensions."""
        return replace(self, contrasts=contrasts)

    @property
    def measured(self) -> Bool[np.ndarray, " dims"]:
        """Dimensions that rest on seen parameters only."""
        return ~np.any(self.contrasts[:, ~self.seen] != 0.0, axis=1)

    @cached_property
    def component_means(self) -> Float[np.ndarray, "draws dims"]:
        """Mean of every dimension given each draw, metres."""
        return self.means @ self.contrasts.T

    @cached_property
    def component_stds(self) -> Float[np.ndarray, "draws dims"]:
        """Standard deviation of every dimension given each draw, metres."""
        # Two steps, the first a product of matrices: einsum takes ten times as long with a storey's.
        variances = ((self.contrasts @ self.covariances) * self.contrasts).sum(axis=2)
        return np.where(self.measured, np.sqrt(np.maximum(variances, 0.0)), np.inf)

    @property
    def mean(self) -> Float[np.ndarray, " dims"]:
        """Mean of every dimension, metres."""
        return self.weights @ self.component_means

    @property
    def std(self) -> Float[np.ndarray, " dims"]:
        """Standard deviation of every dimension, metres; infinite where unmeasured."""
        spread = self.component_means - self.mean
        within = np.where(self.measured, self.component_stds, 0.0)
        total = np.sqrt(self.weights @ (within**2 + spread**2))
        return np.where(self.measured, total, np.inf)

    @property
    def variance_dof(self) -> Float[np.ndarray, " dims"]:
        """Degrees of freedom of `std`, from how much the variance differs between draws (JCGM 100, G.4.2).

        At least 1; infinite where all draws agree.
        """
        variances = np.where(self.measured, self.component_stds, 1.0) ** 2
        average = self.weights @ variances
        scatter = self.weights @ (variances - average) ** 2
        varies = scatter > 0
        dof = 2.0 * average**2 / np.where(varies, scatter, 1.0)
        return np.where(varies, np.maximum(dof, 1.0), np.inf)

    def covariance(self) -> Float[np.ndarray, "dims dims"]:
        """Covariance of all dimensions, m^2; rows of unmeasured dimensions mean nothing."""
        spread = self.component_means - self.mean
        within = np.einsum("k,kpq->pq", self.weights, self.covariances)
        return self.contrasts @ within @ self.contrasts.T + (self.weights[:, None] * spread).T @ spread

    def quantile(self, probability: float) -> Float[np.ndarray, " dims"]:
        """Quantile of every dimension's own mixture, metres."""
        return mixture_quantile(self.weights, self.component_means, self.component_stds, probability)

    def interval(self, level: float) -> tuple[Float[np.ndarray, " dims"], Float[np.ndarray, " dims"]]:
        """Central interval of the given level by mixture quantiles, metres."""
        return self.quantile(0.5 - level / 2), self.quantile(0.5 + level / 2)

    def sample(self, rng: np.random.Generator, draws: int) -> Float[np.ndarray, "draws params"]:
        """Exact draws of theta: first the component, then its Gaussian."""
        chosen = rng.choice(len(self.weights), size=draws, p=self.weights)
        # eigh and not Cholesky: parameters without cells have zero variance.
        values, vectors = np.linalg.eigh(self.covariances)
        roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        normal = rng.standard_normal((draws, self.means.shape[1]))
        return self.means[chosen] + np.einsum("npq,nq->np", roots[chosen], normal)

    def derived(
        self,
        function: Callable[[Float[np.ndarray, "draws params"]], Float[np.ndarray, "draws quantities"]],
        rng: np.random.Generator,
        draws: int,
        level: float,
    ) -> DerivedQuantities:
        """Distribution of nonlinear functions of theta by exact draws.

        Args:
            function: maps draws of theta to draws of the quantities.
            rng: source of the draws.
            draws: 2000 give the ends of a 95 % interval to about 3 % of its width.
            level: of the central interval.
        """
        values = function(self.sample(rng, draws))
        low, high = np.quantile(values, [0.5 - level / 2, 0.5 + level / 2], axis=0)
        return DerivedQuantities(values.mean(axis=0), values.std(axis=0), low, high)


def mixture_quantile(
    weights: Float[np.ndarray, " draws"],
    means: Float[np.ndarray, "draws dims"],
    stds: Float[np.ndarray, "draws dims"],
    probability: float,
) -> Float[np.ndarray, " dims"]:
    """Quantile of Gaussian mixtures, all at once by bisection.

    Args:
        weights: of the components, sum 1.
        means, stds: of each component; an infinite std makes the quantile infinite.
        probability: strictly between 0 and 1.
    """
    finite = np.all(np.isfinite(stds), axis=0)
    result = np.full(means.shape[1], np.inf if probability >= 0.5 else -np.inf)
    mu, sigma = means[:, finite], np.maximum(stds[:, finite], np.finfo(float).tiny)
    # The quantile of a mixture lies between the smallest and the largest quantile of its components;
    # 40 sigma bound those for every probability that a double can hold.
    low, high = np.min(mu - 40 * sigma, axis=0), np.max(mu + 40 * sigma, axis=0)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        below = weights @ ndtr((middle - mu) / sigma) < probability
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    result[finite] = 0.5 * (low + high)
    return result
