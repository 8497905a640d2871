"""Plane residuals from moments: the least squares cost of any number of points in four rows a plane."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True)
class PlaneMoments:
    """Weighted moments of what was seen of each plane.

    For a plane with normal n and offset b, ``sum w (n.q - b)^2 = |S^(1/2) n|^2 + W (n.mean - b)^2`` exactly,
    with S the scatter about the mean. Centred on purpose: uncentred moments lose five digits.
    """

    weights: Float[np.ndarray, " planes"]
    """Total weight W, 1/m^2; 0 for a plane that was not seen."""
    means_m: Float[np.ndarray, "planes 3"]
    roots: Float[np.ndarray, "planes 3 3"]
    """S^(1/2), no unit."""


def plane_moments(
    points_m: Float[np.ndarray, "points 3"],
    plane: Int[np.ndarray, " points"],
    weights: Float[np.ndarray, " points"],
    n_planes: int,
) -> PlaneMoments:
    """Compress weighted points (or cells) into moments per plane.

    Args:
        points_m: any one frame.
        plane: index of each point's plane, below `n_planes`.
        weights: 1/m^2, >= 0.
        n_planes: number of planes.
    """
    total = np.bincount(plane, weights, n_planes)
    safe = np.where(total > 0, total, 1.0)
    means_m = np.stack([np.bincount(plane, weights * points_m[:, a], n_planes) for a in range(3)], axis=1)
    means_m = means_m / safe[:, None]
    centred = points_m - means_m[plane]
    scatter = np.empty((n_planes, 3, 3))
    for a in range(3):
        for b in range(a, 3):
            product = np.bincount(plane, weights * centred[:, a] * centred[:, b], n_planes)
            scatter[:, a, b] = scatter[:, b, a] = product
    # Symmetric root by eigh: S is nearly singular along the normal, where Cholesky fails.
    values, vectors = np.linalg.eigh(scatter)
    roots = (vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]) @ vectors.transpose(0, 2, 1)
    return PlaneMoments(total, means_m, roots)
