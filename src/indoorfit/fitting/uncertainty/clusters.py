"""Yardsticks: points as if independent (must fail), and cluster-robust intervals on given clusters.

Neither is used for results. The first shows that a coverage study can fail; the second is what a statistician
would reach for, and is right only where errors really are independent between clusters.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.special import stdtrit

from .cells import Cells, Contrasts
from .location import ridge, weighted_map
from .predictive import Predictive


def independent_points(cells: Cells, contrasts: Contrasts) -> Predictive:
    """Least squares of all points as if independent, with their pooled scatter: the Hessian's interval."""
    scatter = np.average(cells.residuals_m**2 + cells.counts * cells.variances_m2, weights=cells.counts)
    return _weighted(cells, contrasts, cells.counts / scatter)


def point_noise_floor(cells: Cells, contrasts: Contrasts) -> Predictive:
    """What the points' own noise leaves, cell means being otherwise perfect: no interval can be narrower."""
    return _weighted(cells, contrasts, 1.0 / cells.variances_m2)


def _weighted(cells: Cells, contrasts: Contrasts, precisions: Float[np.ndarray, " cells"]) -> Predictive:
    linear = weighted_map(cells, precisions)
    theta = contrasts.estimate + linear @ cells.residuals_m
    covariance = (linear / precisions) @ linear.T
    return Predictive(np.ones(1), theta[None], covariance[None], cells.seen, contrasts.matrix)


@dataclass(frozen=True)
class ClusterRobust:
    """Student-t intervals, one per dimension, metres."""

    mean: Float[np.ndarray, " dims"]
    std: Float[np.ndarray, " dims"]
    dof: Float[np.ndarray, " dims"]
    """Satterthwaite's degrees of freedom under independent errors."""

    def interval(self, level: float) -> tuple[Float[np.ndarray, " dims"], Float[np.ndarray, " dims"]]:
        """Central interval, metres."""
        half = stdtrit(self.dof, 0.5 + level / 2) * self.std
        return self.mean - half, self.mean + half


def cluster_robust(
    cells: Cells,
    contrasts: Contrasts,
    clusters: Int[np.ndarray, " cells"],
    weights: Float[np.ndarray, " cells"],
) -> ClusterRobust:
    """CR2 with Satterthwaite's degrees of freedom.

    Args:
        cells: residuals and design.
        contrasts: dimensions; those on planes without cells come back infinite.
        clusters: a label per cell, such as its patch, its frame, or one of 16 blocks of frames.
        weights: of the least squares; errors with variance 1/weight are the working model.

    Source: Bell and McCaffrey 2002; Pustejovsky and Tipton 2018, eq. 6 to 12. The inverse square root is the
    pseudo-inverse: a face seen by one cluster has leverage 1.
    """
    seen = cells.seen
    root = np.sqrt(weights)
    design, target = -cells.design[:, seen] * root[:, None], cells.residuals_m * root
    bread = np.linalg.inv(design.T @ design + np.diag(ridge(cells.n_params)[seen]))
    step = bread @ design.T @ target
    remaining = target - design @ step
    rows = contrasts.matrix[:, seen]
    labels = np.unique(clusters)
    scores, responses = [], []
    for label in labels:
        own = clusters == label
        part = design[own]
        values, vectors = np.linalg.eigh(np.eye(len(part)) - part @ bread @ part.T)
        inverse_root = np.where(values > 1e-8, 1.0 / np.sqrt(np.maximum(values, 1e-8)), 0.0)
        adjusted = (vectors * inverse_root) @ (vectors.T @ part @ bread @ rows.T)  # own x dims
        scores.append(adjusted.T @ remaining[own])
        # (I - H) applied to the adjusted vector, padded with zeros outside the cluster.
        spread = -design @ (bread @ (part.T @ adjusted))
        spread[own] += adjusted
        responses.append(spread)
    variance = np.sum(np.square(scores), axis=0)
    gram = np.einsum("gnd,hnd->dgh", responses, responses, optimize=True)
    trace = np.trace(gram, axis1=1, axis2=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        dof = np.maximum(trace**2 / np.sum(gram**2, axis=(1, 2)), 1.0)
    measured = ~np.any(contrasts.matrix[:, ~seen] != 0.0, axis=1)
    theta = contrasts.estimate.copy()
    theta[seen] += step
    return ClusterRobust(
        contrasts.matrix @ theta,
        np.where(measured, np.sqrt(variance), np.inf),
        np.where(measured, np.nan_to_num(dof, nan=1.0), 1.0),
    )
