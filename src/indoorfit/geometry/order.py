"""Parallel planes of one room stand in an order: one that passes another turns a part of it inside out."""

import numpy as np
from scipy import ndimage

from indoorfit.model import Shape

from .boxes import box_exposures, room_of_planes
from .exposure import Exposure

SAME_WALL_M = 0.06
"""Parallel planes that are nearer are one wall seen in two places, as for the candidates of discovery."""


def passed(before: Shape, after: Shape) -> list[tuple[int, int]]:
    """Which planes of one room have changed places, the one that was lower first.

    Pieces of one wall that do not meet, such as the fronts of pilasters in a row, have no order: which of
    them is a hair's breadth before the others is noise, and turns nothing; unless one of them is a side of
    the room's own box, which the other one then leaves. Oblique planes have none either.

    Args:
        before: the same planes in order.
        after: where they went.
    """
    room = room_of_planes(before)
    before_m, after_m = before.offsets_m, after.offsets_m
    # Square corners: so that all faces of a room share its grid.
    faces = box_exposures(before.squared)
    found = []
    for first, second in np.argwhere(
        (before_m[:, None] < before_m[None, :]) & (after_m[:, None] >= after_m[None, :])
    ).tolist():
        pair = before.planes[first], before.planes[second]
        if (
            pair[0].axis != pair[1].axis
            or room.get(first) != room.get(second)
            or any(p.oblique for p in pair)
        ):
            continue
        near = before_m[second] - before_m[first] < SAME_WALL_M
        if not near or _meet(faces[first], faces[second]) or _lost(after, first, second):
            found.append((first, second))
    return found


def _lost(after: Shape, first: int, second: int) -> bool:
    """Whether one of two planes has no face any more."""
    left = box_exposures(after.squared)
    return not (left[first].mask.any() and left[second].mask.any())


def reverted(before: Shape, after: Shape) -> tuple[Shape, tuple[int, ...]]:
    """All planes of a direction of a room back in their places, wherever some of them passed each other.

    The order in one direction of a room is a matter of its planes in that direction alone.

    Args:
        before: the same planes in order.
        after: where they went.

    Returns:
        the shape, in order; and the planes that went back.
    """
    room = room_of_planes(before)
    broken = {(room.get(k), before.planes[k].axis) for pair in passed(before, after) for k in pair}
    back = [
        k
        for k, plane in enumerate(before.planes)
        if (room.get(k), plane.axis) in broken and not plane.oblique
    ]
    offsets_m = after.offsets_m
    offsets_m[back] = before.offsets_m[back]
    return after.with_offsets(offsets_m), tuple(back)


def _meet(first: Exposure, second: Exposure) -> bool:
    """Whether two faces of one room overlap or touch as seen across them; they share the room's grid."""
    grown = ndimage.binary_dilation(first.mask, np.ones((3, 3), bool))
    return bool(np.any(grown & second.mask))
