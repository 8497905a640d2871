"""Classes, and the farthest segments of a class (thesis 3.2.3 to 3.2.5)."""

from collections.abc import Iterable, Mapping

import numpy as np
from jaxtyping import Float

from indoorfit.model import FaceClass

from .config import GreedyConfig
from .ransac import oriented
from .record import FittedPlane

CLASS_SIDES: dict[FaceClass, tuple[int, int]] = {
    "left": (0, -1),
    "right": (0, 1),
    "back": (1, -1),
    "front": (1, 1),
    "floor": (2, -1),
    "ceiling": (2, 1),
}
"""Axis and sign of each class' outward direction (table 3-1)."""

WALLS: tuple[FaceClass, ...] = ("left", "right", "back", "front")


def wall_classes(
    planes: Mapping[int, FittedPlane],
    segments: Iterable[int],
    origin_m: Float[np.ndarray, " 3"],
    config: GreedyConfig,
) -> dict[FaceClass, list[int]]:
    """Table 3-1 for walls, with normals pointing away from a component's centroid (3.2.5)."""
    found: dict[FaceClass, list[int]] = {}
    for segment in segments:
        normal = oriented(planes[segment], origin_m).normal
        for name in WALLS:
            axis, sign = CLASS_SIDES[name]
            if sign * normal[axis] >= config.along and np.delete(np.abs(normal), axis).max() <= config.across:
                found.setdefault(name, []).append(segment)
    return found


def farthest_groups(
    planes: Mapping[int, FittedPlane],
    segments: Iterable[int],
    origin_m: Float[np.ndarray, " 3"],
    join_m: float,
) -> list[tuple[int, ...]]:
    """Split a class: the farthest segment with all within `join_m` of it first (3.2.4), then the rest alike.

    Returns:
        groups by decreasing distance of their farthest segment from the origin.
    """
    distances_m = {segment: abs(planes[segment].distance_m(origin_m)) for segment in segments}
    order = sorted(distances_m, key=lambda segment: (-distances_m[segment], segment))
    groups: list[tuple[int, ...]] = []
    while order:
        limit_m = distances_m[order[0]] - join_m
        groups.append(tuple(segment for segment in order if distances_m[segment] >= limit_m))
        order = order[len(groups[-1]) :]
    return groups
