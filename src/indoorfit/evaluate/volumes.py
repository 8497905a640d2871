"""Shared volume and floor plan of two models, exactly: both are unions of cells of one common grid."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.model import Cube, Shape

Boxes = Mapping[str, Float[np.ndarray, "2 3"]]


def common_grid(*boxes: Boxes) -> tuple[Float[np.ndarray, " _"], ...]:
    """Grid lines along the three axes that hold every side of every box."""
    corners = np.concatenate([box for group in boxes for box in group.values()])
    return tuple(np.unique(corners[:, axis]) for axis in range(3))


def occupied(
    shape: Shape, room: Cube, boxes: Boxes, lines_m: tuple[Float[np.ndarray, " _"], ...]
) -> Bool[np.ndarray, "nx ny nz"]:
    """Cells inside a room: its cube minus what is taken away from it, from the leaves (thesis 3.2.5)."""
    low, high = boxes[room.id]
    ranges = [slice(*np.searchsorted(lines_m[a], (low[a], high[a])).tolist()) for a in range(3)]
    inside = np.zeros([len(line) - 1 for line in lines_m], bool)
    inside[tuple(ranges)] = True
    for child in shape.children(room.id):
        inside &= ~occupied(shape, child, boxes, lines_m)
    return inside


def solid_iou(
    first: Bool[np.ndarray, "nx ny nz"],
    second: Bool[np.ndarray, "nx ny nz"],
    lines_m: tuple[Float[np.ndarray, " _"], ...],
) -> float:
    """Volume in both over volume in either; 0 where both are empty."""
    x, y, z = (np.diff(line) for line in lines_m)

    def volume(mask: Bool[np.ndarray, "nx ny nz"]) -> float:
        return float(np.einsum("xyz,x,y,z->", mask.astype(float), x, y, z))

    either = volume(first | second)
    return volume(first & second) / either if either > 0.0 else 0.0


def footprint_iou(
    first: Bool[np.ndarray, "nx ny nz"],
    second: Bool[np.ndarray, "nx ny nz"],
    lines_m: tuple[Float[np.ndarray, " _"], ...],
) -> float:
    """The same of the two plans, each seen from above."""
    x, y = (np.diff(line) for line in lines_m[:2])
    plans = first.any(axis=2), second.any(axis=2)
    both, either = (float(x @ plan @ y) for plan in (plans[0] & plans[1], plans[0] | plans[1]))
    return both / either if either > 0.0 else 0.0
