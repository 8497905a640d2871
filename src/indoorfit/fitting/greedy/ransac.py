"""Planes by RANSAC (thesis 3.2.2, second method; Fischler and Bolles 1981)."""

import numpy as np
from jaxtyping import Bool, Float

from .config import GreedyConfig
from .record import FittedPlane

_SCORED = 2000
"""Triples are judged on at most this many points: 1 % of inliers is then known to 1 %."""
_BATCH = 16
"""Triples drawn at once; the stop rule is looked at after each batch."""


def ransac_inliers(
    points_m: Float[np.ndarray, "points 3"], config: GreedyConfig, rng: np.random.Generator
) -> Bool[np.ndarray, " points"]:
    """The points near the plane that has the most points near it.

    Args:
        points_m: at least three, any frame.
        config: threshold and stop rule.
        rng: draws the triples.
    """
    scored = points_m
    if len(points_m) > _SCORED:
        scored = points_m[rng.choice(len(points_m), _SCORED, replace=False)]
    best, best_plane = 0, _least_squares_plane(points_m)
    draws, needed = 0, float(config.max_draws)
    while draws < needed:
        triples = scored[rng.integers(len(scored), size=(_BATCH, 3))]
        normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        # Points drawn twice or on one line span no plane; they count as a draw without inliers.
        normals = normals / np.where(lengths > 1e-12, lengths, np.inf)[:, None]
        gaps_m = np.einsum("tpd,td->tp", scored[None] - triples[:, :1], normals)
        counts = np.where(lengths > 1e-12, (np.abs(gaps_m) < config.inlier_m).sum(axis=1), 0)
        winner = int(np.argmax(counts))
        if counts[winner] > best:
            best, best_plane = int(counts[winner]), (normals[winner], triples[winner, 0])
        draws += _BATCH
        needed = min(config.max_draws, _draws_needed(best / len(scored), config.confidence))
    # One least squares step on the inliers frees the selection from the noise of three points.
    inliers = _near(points_m, best_plane, config.inlier_m)
    return _near(points_m, _least_squares_plane(points_m[inliers]), config.inlier_m)


def ransac_plane(
    name: str,
    points_m: Float[np.ndarray, "points 3"],
    origin_m: Float[np.ndarray, " 3"],
    config: GreedyConfig,
    rng: np.random.Generator,
) -> FittedPlane:
    """Least squares plane of the RANSAC inliers, its normal pointing away from `origin_m` (4.2.2)."""
    inliers = points_m[ransac_inliers(points_m, config, rng)]
    normal, centre_m = _least_squares_plane(inliers)
    rms_m = float(np.sqrt(np.mean(np.square((inliers - centre_m) @ normal))))
    plane = FittedPlane(name, normal, centre_m, len(points_m), len(inliers), rms_m)
    return oriented(plane, origin_m)


def oriented(plane: FittedPlane, origin_m: Float[np.ndarray, " 3"]) -> FittedPlane:
    """The same plane with its normal pointing away from an origin."""
    sign = 1.0 if plane.distance_m(origin_m) >= 0.0 else -1.0
    return FittedPlane(
        plane.name, sign * plane.normal, plane.centre_m, plane.n_points, plane.n_inliers, plane.rms_m
    )


def _draws_needed(share: float, confidence: float) -> float:
    hit = min(share**3, 1.0 - 1e-12)
    return np.inf if hit <= 0.0 else float(np.log(1.0 - confidence) / np.log(1.0 - hit))


_Plane = tuple[Float[np.ndarray, " 3"], Float[np.ndarray, " 3"]]
"""Unit normal and a point of the plane."""


def _near(
    points_m: Float[np.ndarray, "points 3"], plane: _Plane, reach_m: float
) -> Bool[np.ndarray, " points"]:
    return np.abs((points_m - plane[1]) @ plane[0]) < reach_m


def _least_squares_plane(points_m: Float[np.ndarray, "points 3"]) -> _Plane:
    centre_m = points_m.mean(axis=0)
    centred = points_m - centre_m
    return np.linalg.eigh(centred.T @ centred)[1][:, 0], centre_m
