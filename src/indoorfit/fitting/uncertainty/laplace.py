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
    tolerance: float = 1e-7,
    max_evaluations: int = 60,
) -> tuple[Float[np.ndarray, " hyper"], bool]:
    """Peak of the log posterior inside the bounds; the flag says whether the search stood still.

    Args:
        objective: log posterior and gradient.
        start, bounds: of the search.
        tolerance: relative change of the log posterior that ends it; 1e-7 is a small part of a nat.
        max_evaluations: of the objective.
    """

    def negative(point: Float[np.ndarray, " hyper"]) -> tuple[float, Float[np.ndarray, " hyper"]]:
        value, gradient = objective(point)
        return -value, -gradient

    found = optimize.minimize(
        negative,
        np.clip(start, bounds[:, 0], bounds[:, 1]),
        jac=True,
        method="L-BFGS-B",
        bounds=bounds,
        options={"maxfun": max_evaluations, "ftol": tolerance, "gtol": 1e-3},
    )
    return found.x, bool(found.success)


def hessian_from_gradients(
    objective: Objective, point: Float[np.ndarray, " hyper"], step: float = 1e-3
) -> Float[np.ndarray, "hyper hyper"]:
    """Curvature of an objective with an exact gradient."""
    _, here = objective(point)
    rows = [(objective(point + move)[1] - here) / step for move in step * np.eye(len(point))]
    hessian = np.array(rows)
    return 0.5 * (hessian + hessian.T)


def hessian_from_values(
    log_posterior: Callable[[Float[np.ndarray, " hyper"]], float],
    point: Float[np.ndarray, " hyper"],
    step: float = 0.02,
) -> Float[np.ndarray, "hyper hyper"]:
    """Curvature by one-sided second differences: good to some per cent, enough for a proposal."""
    size = len(point)
    moves = step * np.eye(size)
    here = log_posterior(point)
    single = np.array([log_posterior(point + move) for move in moves])
    hessian = np.empty((size, size))
    for i in range(size):
        for j in range(i + 1):
            pair = log_posterior(point + moves[i] + moves[j])
            hessian[i, j] = hessian[j, i] = (pair - single[i] - single[j] + here) / step**2
    return hessian


def laplace_mode(
    point: Float[np.ndarray, " hyper"],
    hessian: Float[np.ndarray, "hyper hyper"],
    prior_stds: Float[np.ndarray, " hyper"],
    converged: bool,
) -> HyperMode:
    """Gaussian width at the peak from the curvature of the log posterior.

    Directions in which the posterior is no narrower than the prior (or curves the wrong way, as at a bound)
    get the prior's width: the importance weights put right what this gets wrong.
    """
    curvatures, vectors = np.linalg.eigh(-prior_stds[:, None] * hessian * prior_stds)
    widths = 1.0 / np.sqrt(np.maximum(curvatures, 1.0))
    return HyperMode(point, prior_stds[:, None] * vectors * widths, converged)


def draw_student_t(
    mode: HyperMode, draws: int, dof: float, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "draws hyper"], Float[np.ndarray, " draws"]]:
    """Draws of a Student-t (a Gaussian for infinite `dof`) around the mode, with their log densities.

    The draws come in mirrored pairs: with two dozen of them this halves the noise of everything that is
    nearly linear in the hyper-parameters, and costs nothing.
    """
    size = len(mode.point)
    half = (draws + 1) // 2
    normal = rng.standard_normal((half, size))
    stretch = np.sqrt(dof / rng.chisquare(dof, half)) if np.isfinite(dof) else np.ones(half)
    offsets = np.concatenate([normal * stretch[:, None], -normal * stretch[:, None]])[:draws]
    square = np.sum(offsets**2, axis=1)
    log_density = -0.5 * (dof + size) * np.log1p(square / dof) if np.isfinite(dof) else -0.5 * square
    return mode.point + offsets @ mode.root.T, log_density


def truncated_weights(log_ratios: Float[np.ndarray, " draws"]) -> Float[np.ndarray, " draws"]:
    """Normalised importance weights, none above sqrt(draws) times their mean.

    Source: Ionides 2008, Truncated importance sampling. One lucky draw must not become the whole mixture.
    """
    raw = np.exp(log_ratios - np.max(log_ratios))
    raw = np.minimum(raw, raw.mean() * np.sqrt(len(raw)))
    return raw / raw.sum()
