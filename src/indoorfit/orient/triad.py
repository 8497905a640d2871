"""The three perpendicular directions that most surfaces of a Manhattan world follow."""

import numpy as np
from jaxtyping import Float, Int

_COARSE_RAD = np.deg2rad(8.0)
"""First catchment of a direction: twice the spread of normals on the noisiest sensor that we model."""
_FINE_RAD = np.deg2rad(3.0)
"""Last catchment: walls of one room differ by less (DIN 18202), oblique walls by more."""
_SAMPLE = 3_000
"""Normals that judge a proposal: a share of support is known to one percent."""
_SEEDS = 400
"""Normals tried as a direction. One surface in fifty is hit eight times."""


def dominant_triad(
    normals: Float[np.ndarray, "surfels 3"], weights: Float[np.ndarray, " surfels"], rng: np.random.Generator
) -> tuple[Float[np.ndarray, "3 3"], float]:
    """The rotation whose axes are followed by the largest weight of normals.

    Pairs of perpendicular normals propose a triad, the weight of the normals near any of its axes
    chooses between them, and orthogonal Procrustes refines it, which is equation 4-1 of the thesis for
    all normals at once instead of a few picked by hand.

    Args:
        normals: unit, scan axes, arbitrary sign.
        weights: >= 0, no unit.
        rng: source of the proposals.

    Returns:
        rows are the three axes (det +1, order and signs arbitrary), and the share of the weight that
        lies within three degrees of one of them.
    """
    directions = normals[rng.choice(len(normals), size=_SAMPLE, p=weights / weights.sum())]
    seeds = directions[:_SEEDS]
    near = (np.abs(directions @ seeds.T) > np.cos(_COARSE_RAD)).sum(axis=0)
    best, best_support = np.eye(3), -1.0
    for first in _distinct(seeds, near, count=4):
        across = np.abs(seeds @ first) < np.sin(_COARSE_RAD)
        for second in _distinct(seeds[across], near[across], count=3):
            triad = _refine(_triad(first, second), directions)
            support = _support(triad, directions)
            if support > best_support:
                best, best_support = triad, support
    triad = _refine(best, normals[weights > 0], weights[weights > 0])
    return triad, _support(triad, directions)


def _distinct(
    seeds: Float[np.ndarray, "seeds 3"], score: Int[np.ndarray, " seeds"], count: int
) -> list[Float[np.ndarray, " 3"]]:
    """The best-supported seeds that are not neighbours of a better one."""
    chosen: list[Float[np.ndarray, " 3"]] = []
    for k in np.argsort(-score, kind="stable"):
        if all(abs(seeds[k] @ other) < np.cos(_COARSE_RAD) for other in chosen):
            chosen.append(seeds[k])
        if len(chosen) == count:
            break
    return chosen


def _triad(first: Float[np.ndarray, " 3"], second: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    second = second - (second @ first) * first
    second = second / np.linalg.norm(second)
    return np.stack([first, second, np.cross(first, second)])


def _refine(
    triad: Float[np.ndarray, "3 3"],
    normals: Float[np.ndarray, "n 3"],
    weights: Float[np.ndarray, " n"] | None = None,
) -> Float[np.ndarray, "3 3"]:
    """Procrustes of the normals to their nearest axes, in a narrowing catchment."""
    for reach_rad in (_COARSE_RAD, 0.5 * (_COARSE_RAD + _FINE_RAD), _FINE_RAD, _FINE_RAD):
        cosines = normals @ triad.T
        axis = np.argmax(np.abs(cosines), axis=1)
        cosine = cosines[np.arange(len(normals)), axis]
        # Tukey's biweight in the angle; the catchment is its cut-off.
        angle = np.arccos(np.minimum(np.abs(cosine), 1.0))
        weight = np.square(1.0 - np.square(np.minimum(angle / reach_rad, 1.0)))
        if weights is not None:
            weight = weight * weights
        signed = normals * (weight * np.sign(cosine))[:, None]
        moment = np.stack([signed[axis == a].sum(axis=0) for a in range(3)])
        left, _, right = np.linalg.svd(moment)
        triad = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return triad


def _support(triad: Float[np.ndarray, "3 3"], normals: Float[np.ndarray, "n 3"]) -> float:
    return float(np.mean(np.abs(normals @ triad.T).max(axis=1) > np.cos(_FINE_RAD)))
