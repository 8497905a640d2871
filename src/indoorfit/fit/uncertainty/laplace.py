"""Hyper-parameters: their mode, and a weighted set of draws around it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import optimize

Objective = Callable[[Float[np.ndarray, " hyper"]], tuple[float, Float[np.ndarray, " hyper"]]]
"""Log posterior density and its gradient at one point."""


@dataclass(frozen=True)
class HyperMode:
    """Where the posterior of the hyper-parameters peaks, and how wide it is there."""

    point: Float[np.ndarray, " hyper"]
    root: Float[np.ndarray, "hyper hyper"]
    """A square root of the covariance: ``root @ root.T``."""
    converged: bool


@dataclass(frozen=True)
class HyperDraws:
    """Draws of the hyper-parameters with importance weights that sum to 1."""

    points: Float[np.ndarray, "draws hyper"]
    weights: Float[np.ndarray, " draws"]

    @property
    def mean(self) -> Float[np.ndarray, " hyper"]:
        """Posterior mean."""
        return self.weights @ self.points

    @property
    def std(self) -> Float[np.ndarray, " hyper"]:
        """Posterior standard deviation."""
        return np.sqrt(self.weights @ (self.points - self.mean) ** 2)


def find_mode(
    objective: Objective,
    start: Float[np.ndarray, " hyper"],
    bounds: Float[np.ndarray, "hyper 2"],
    max_evaluations: int = 60,
) -> tuple[Float[np.ndarray, " hyper"], bool]:
    """Peak of the log posterior inside the bounds; the flag says whether the search stood still."""

    def negative(point: Float[np.ndarray, " hyper"]) -> tuple[float, Float[np.ndarray, " hyper"]]:
        value, gradient = objective(point)
        return -value, -gradient

    # 1e-7 relative: the draws need the peak to a small part of a nat.
    found = optimize.minimize(
        negative,
        np.clip(start, bounds[:, 0], bounds[:, 1]),
        jac=True,
        method="L-BFGS-B",
        bounds=bounds,
        options={"maxfun": max_evaluations, "ftol": 1e-7, "gtol": 1e-3},
    )
    return found.x, bool(found.success)


def laplace_mode(
    objective: Objective,
    point: Float[np.ndarray, " hyper"],
    prior_stds: Float[np.ndarray, " hyper"],
    converged: bool,
) -> HyperMode:
    """Curvature at the peak from differences of the gradient.

    Directions in which the posterior is no narrower than the prior (or curves the wrong way, as at a bound)
    get the prior's width: the importance weights put right what this gets wrong.
    """
    size = len(point)
    step = 1e-3
    _, here = objective(point)
    hessian = np.empty((size, size))
    for k in range(size):
        _, moved = objective(point + step * np.eye(size)[k])
        hessian[k] = (here - moved) / step
    scaled = prior_stds[:, None] * (0.5 * (hessian + hessian.T)) * prior_stds
    curvatures, vectors = np.linalg.eigh(scaled)
    widths = 1.0 / np.sqrt(np.maximum(curvatures, 1.0))
    return HyperMode(point, prior_stds[:, None] * vectors * widths, converged)


def draw_student_t(
    mode: HyperMode, draws: int, dof: float, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "draws hyper"], Float[np.ndarray, " draws"]]:
    """Draws of a Student-t around the mode and their log densities up to a constant.

    The draws come in mirrored pairs: with two dozen of them this halves the noise of everything that is
    nearly linear in the hyper-parameters, and costs nothing.
    """
    size = len(mode.point)
    half = (draws + 1) // 2
    normal = rng.standard_normal((half, size))
    stretch = np.sqrt(dof / rng.chisquare(dof, half))
    offsets = np.concatenate([normal * stretch[:, None], -normal * stretch[:, None]])[:draws]
    log_density = -0.5 * (dof + size) * np.log1p(np.sum(offsets**2, axis=1) / dof)
    return mode.point + offsets @ mode.root.T, log_density


def truncated_weights(log_ratios: Float[np.ndarray, " draws"]) -> Float[np.ndarray, " draws"]:
    """Normalised importance weights, none above sqrt(draws) times their mean.

    Source: Ionides 2008, Truncated importance sampling. One lucky draw must not become the whole mixture.
    """
    raw = np.exp(log_ratios - np.max(log_ratios))
    raw = np.minimum(raw, raw.mean() * np.sqrt(len(raw)))
    return raw / raw.sum()
