"""Walls of two rooms that back onto each other, and the thickness between them."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from indoorfit.model import Shape

from .named import NamedDimension, NamedFace, Survey, distance

MAX_WALL_M = 0.5
"""Rooms further apart than the thickest masonry have more than one wall between them."""
_MIN_WALL_M = 0.03
"""Thinner than boards on a frame: one surface that both rooms claim, such as a screen or a lintel's face."""
_MIN_OVERLAP_M = 0.3
"""Least extent, along and up, over which two faces are opposite: less is a corner next to a corner."""


@dataclass(frozen=True)
class Backing:
    """Two opposite faces of one wall and the rectangle in which they overlap, Manhattan frame."""

    low: NamedFace
    """The face at the lower coordinate; its room lies on that side."""
    high: NamedFace
    axis: int
    """The axis across the wall."""
    span_m: tuple[float, float]
    """Along the wall."""
    rise_m: tuple[float, float]
    """Heights."""


def backings(shape: Shape, found: Survey) -> tuple[Backing, ...]:
    """All pairs of walls of different rooms with nothing but wall between them."""
    pairs = []
    # The two sides of an oblique wall have a yaw each, and no distance.
    walls = [f for f in found.faces if f.kind == "wall" and not shape.planes[f.polygon.plane].oblique]
    lows = [face for face in walls if shape.planes[face.polygon.plane].outward > 0]
    highs = [face for face in walls if shape.planes[face.polygon.plane].outward < 0]
    for low, high in product(lows, highs):
        first, second = shape.planes[low.polygon.plane], shape.planes[high.polygon.plane]
        thick_m = second.offset_m - first.offset_m
        if low.room == high.room or first.axis != second.axis or not _MIN_WALL_M <= thick_m <= MAX_WALL_M:
            continue
        span_m, rise_m = (_overlap(low, high, axis) for axis in (1 - first.axis, 2))
        if min(span_m[1] - span_m[0], rise_m[1] - rise_m[0]) >= _MIN_OVERLAP_M:
            pairs.append(Backing(low, high, first.axis, span_m, rise_m))
    return tuple(pairs)


def _overlap(first: NamedFace, second: NamedFace, axis: int) -> tuple[float, float]:
    rings = [face.polygon.rings_m[0][:, axis] for face in (first, second)]
    return float(max(ring.min() for ring in rings)), float(min(ring.max() for ring in rings))


def with_thicknesses(shape: Shape, found: Survey) -> Survey:
    """The survey with the thickness of every wall that was seen from both sides, after all else.

    A thickness between faces of which one is inferred would be the thickness of a guess, so there is none.

    Args:
        shape: the grammar that was surveyed.
        found: its survey, with the status of the faces.
    """
    dimensions = [
        _thickness(shape, backing)
        for backing in backings(shape, found)
        if backing.low.status == backing.high.status == "observed"
    ]
    return replace(found, dimensions=(*found.dimensions, *dimensions))


def _thickness(shape: Shape, backing: Backing) -> NamedDimension:
    planes = backing.low.polygon.plane, backing.high.polygon.plane
    offsets_m = [shape.planes[k].offset_m for k in planes]
    ends_m = np.zeros((2, 3))
    ends_m[:, backing.axis] = offsets_m
    ends_m[:, 1 - backing.axis] = np.mean(backing.span_m)
    ends_m[:, 2] = np.mean(backing.rise_m)
    return NamedDimension(
        kind="thickness",
        room=backing.low.room,
        faces=(backing.low.id, backing.high.id),
        wall=None,
        planes=planes,
        from_m=ends_m[0],
        to_m=ends_m[1],
        measurand=distance(shape, *planes),
    )
