"""Which of three perpendicular directions is up, and how sure that is."""

from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

Up = Literal["auto", "x", "y", "z", "-x", "-y", "-z"]

_CONE_RAD = np.deg2rad(20.0)
"""A scan that is roughly levelled is tilted by up to 15 degrees; 20 leave room for the estimate."""


_OUTER_CONE_RAD = np.deg2rad(45.0)
"""Beyond this a direction is nearer to another axis of the file, and no habit speaks for it."""
_USUAL_HEIGHT_M = 2.6
_HEIGHT_SPREAD = 0.3
"""Storeys are 2.4 to 3.5 m high between the finished surfaces; halls are not ruled out (floor of -3)."""
_MIN_HEIGHT_M = 1.8
"""Two layers nearer than this are a floor and a table, or a ceiling and a beam."""
_LAYER_M = 0.1
"""Height of a bin: holds a surface with its noise and tilt, some centimetres, but no table and floor."""
_MAX_BINS = 10_000
"""A kilometre of height in such bins."""
_MAX_LAYERS = 4
"""Floor, ceiling, a step in one of them, and the ground outside."""


@dataclass(frozen=True)
class UpChoice:
    """The chosen direction and the evidence for it."""

    direction: Float[np.ndarray, " 3"]
    """Scan axes, one of the triad's axes with its sign."""
    runner_up: Float[np.ndarray, " 3"]
    margin: float
    """How much better than the runner-up, in the units of the scores below; below
    `OrientConfig.min_margin` it is a guess."""


def named_direction(up: str) -> Float[np.ndarray, " 3"]:
    """Unit vector of an axis name such as ``-y``; not for ``auto``."""
    direction = np.zeros(3)
    direction["xyz".index(up[-1])] = -1.0 if up.startswith("-") else 1.0
    return direction


def choose_up(
    triad: Float[np.ndarray, "3 3"],
    positions_m: Float[np.ndarray, "surfels 3"],
    normals: Float[np.ndarray, "surfels 3"],
    up: Up,
    single_view: bool,
) -> UpChoice:
    """Pick the up direction among the six that a triad offers.

    The scores are log odds, roughly: the file's habit (z up, then y up), a height that rooms have,
    floor and ceiling that cover the same ground, walls that run from one to the other, and furniture in
    the lower half.

    Args:
        triad: rows are the axes, scan axes.
        positions_m: metres, scan axes relative to the centroid.
        normals: unit, arbitrary sign.
        up: a named axis decides alone, by the nearest axis of the triad.
        single_view: the scan is one picture in a depth camera's own axes, whose y points down.
    """
    directions = np.concatenate([triad, -triad])
    if up != "auto":
        scores = directions @ named_direction(up)
    else:
        upright = np.array([_upright_score(axis, positions_m, normals) for axis in triad])
        lean = np.array([_furniture_score(axis, positions_m, normals) for axis in triad])
        habit = np.array([_habit(direction, single_view) for direction in directions])
        scores = habit + np.tile(upright, 2) + np.concatenate([lean, -lean])
    order = np.argsort(-scores, kind="stable")
    return UpChoice(directions[order[0]], directions[order[1]], float(scores[order[0]] - scores[order[1]]))


def is_single_view(points_m: Float[np.ndarray, "points 3"]) -> bool:
    """Whether all points lie in one camera's field of view: z forward, at most 45 degrees off its axis.

    Args:
        points_m: in the file's own coordinates, whose origin would be the camera.
    """
    ahead = (points_m[:, 2] > 0) & (np.abs(points_m[:, :2]).max(axis=1) < points_m[:, 2])
    return bool(np.mean(ahead) > 0.99)


def _habit(direction: Float[np.ndarray, " 3"], single_view: bool) -> float:
    """Scanners write z up, phones and graphics tools y up, depth cameras y down; seldom the rest."""
    habits = {"z": 2.5, "y": 1.5, "-y": 1.0} if not single_view else {"-y": 4.0}
    full, none = np.cos(_CONE_RAD), np.cos(_OUTER_CONE_RAD)
    return max(
        score * np.clip((direction @ named_direction(name) - none) / (full - none), 0, 1)
        for name, score in habits.items()
    )


def _upright_score(
    axis: Float[np.ndarray, " 3"],
    positions_m: Float[np.ndarray, "surfels 3"],
    normals: Float[np.ndarray, "surfels 3"],
) -> float:
    """Height as rooms have it, and how much of the ground the two end faces share.

    The end faces are the two layers for which this speaks most: what lies beyond them was seen through
    windows, a street or the house opposite.
    """
    heights_m = positions_m @ axis
    ground = _pixels(positions_m, axis)
    cosines = np.abs(normals @ axis)
    flat = cosines > np.cos(_CONE_RAD)
    low_m, high_m = np.percentile(heights_m, [1, 99])
    layers_m = _layers(heights_m[flat])
    pairs = [(low_m, high_m), *((a, b) for a, b in combinations(layers_m, 2) if b - a > _MIN_HEIGHT_M)]
    scores = []
    for low_m, high_m in pairs:
        # Of a floor and little else all heights are one.
        height_m = max(high_m - low_m, 1e-9)
        reach_m = 0.15 * height_m
        likely = max(-3.0, -0.5 * (np.log(height_m / _USUAL_HEIGHT_M) / _HEIGHT_SPREAD) ** 2)
        bottom = np.unique(ground[flat & (np.abs(heights_m - low_m) < reach_m)])
        top = np.unique(ground[flat & (np.abs(heights_m - high_m) < reach_m)])
        between = (heights_m > low_m - reach_m) & (heights_m < high_m + reach_m)
        shared = len(np.intersect1d(bottom, top)) / max(1, len(np.unique(ground[between])))
        upright = between & (cosines < np.sin(_CONE_RAD))
        scores.append(likely + 2.0 * shared + 2.0 * _spanning(ground[upright], heights_m[upright], height_m))
    return max(scores)


def _layers(heights_m: Float[np.ndarray, " flat"]) -> Float[np.ndarray, " layers"]:
    """Heights where most level surfels lie, at most `_MAX_LAYERS`, from below."""
    if len(heights_m) == 0:
        return np.zeros(0)
    low_m, high_m = np.percentile(heights_m, [0.5, 99.5])
    # A unit taken wrongly makes a room of kilometres.
    step_m = max(_LAYER_M, (high_m - low_m) / _MAX_BINS)
    edges = np.arange(low_m - step_m, high_m + 2.0 * step_m, step_m)
    counts = np.convolve(np.histogram(heights_m, edges)[0], [0.5, 1.0, 0.5], mode="same")
    peaks = np.flatnonzero((counts[1:-1] > counts[:-2]) & (counts[1:-1] >= counts[2:])) + 1
    most = peaks[np.argsort(-counts[peaks], kind="stable")[:_MAX_LAYERS]]
    return np.sort(edges[most] + 0.5 * step_m)


def _spanning(
    ground: Int[np.ndarray, " walls"], heights_m: Float[np.ndarray, " walls"], height_m: float
) -> float:
    """Share of the columns with wall in them where it runs from near one end to near the other.

    Walls go from floor to ceiling; laid on its side, a room with a notch has faces that stop half-way.
    """
    if len(ground) == 0:
        return 0.0
    _, column = np.unique(ground, return_inverse=True)
    low_m = np.full(column.max(initial=0) + 1, np.inf)
    high_m = np.full(column.max(initial=0) + 1, -np.inf)
    np.minimum.at(low_m, column, heights_m)
    np.maximum.at(high_m, column, heights_m)
    return float(np.mean(high_m - low_m > 0.8 * height_m))


def _pixels(
    positions_m: Float[np.ndarray, "surfels 3"], axis: Float[np.ndarray, " 3"]
) -> Int[np.ndarray, " surfels"]:
    """The 25 cm square of the ground that each surfel lies over, as one integer."""
    other = np.eye(3)[np.argmin(np.abs(axis))]
    u = np.cross(axis, other)
    v = np.cross(axis, u)
    i = np.floor(positions_m @ u / (0.25 * np.linalg.norm(u))).astype(np.int64)
    j = np.floor(positions_m @ v / (0.25 * np.linalg.norm(v))).astype(np.int64)
    return i * 1_000_003 + j


def _furniture_score(
    axis: Float[np.ndarray, " 3"],
    positions_m: Float[np.ndarray, "surfels 3"],
    normals: Float[np.ndarray, "surfels 3"],
) -> float:
    """Where level surfaces between floor and ceiling lie: +0.5 all in the half that `-axis` points to."""
    heights_m = positions_m @ axis
    low_m, high_m = np.percentile(heights_m, [1, 99])
    relative = (heights_m - low_m) / max(high_m - low_m, 1e-9)
    between = (np.abs(normals @ axis) > np.cos(_CONE_RAD)) & (relative > 0.12) & (relative < 0.88)
    if between.sum() < 0.01 * len(heights_m):
        return 0.0
    return float(0.5 * (np.mean(relative[between] < 0.5) - np.mean(relative[between] > 0.5)))
