"""The outline of a room's plan as a loop of walls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.model import Polygon, Shape

from .outline import outline_rings
from .plan_cells import NOT_ENCLOSED


@dataclass(frozen=True)
class FloorEdge:
    """One side of the plan and the wall that stands on it."""

    wall: Polygon
    start_m: Float[np.ndarray, " 2"]
    """Manhattan frame, x and y; walls are met counter-clockwise around the room as seen from above."""
    end_m: Float[np.ndarray, " 2"]


@dataclass(frozen=True)
class FloorLoop:
    """A closed outline: the first of a room is the outer one, the others go around pillars."""

    edges: tuple[FloorEdge, ...]


def floor_loops(shape: Shape, pieces: Sequence[Polygon]) -> tuple[FloorLoop, ...]:
    """Match every side of the plan to its wall, whatever levels the floor has.

    Args:
        shape: the grammar.
        pieces: the polygons of one room.

    Raises:
        InputError: a side of the plan has no wall.
    """
    walls = [piece for piece in pieces if shape.planes[piece.plane].axis < 2]
    loops = []
    for ring in outline_rings(shape, pieces):
        following = np.roll(ring, -1, axis=0)
        edges = [
            FloorEdge(_wall_at(shape, walls, start, end), start, end)
            for start, end in zip(ring, following, strict=True)
        ]
        loops.append(FloorLoop(tuple(edges)))
    return tuple(loops)


_SAME_M = 1e-7
"""A tenth of the length that the solid is simplified by; corners of one place agree far better."""


def _wall_at(
    shape: Shape, walls: Sequence[Polygon], start_m: Float[np.ndarray, " 2"], end_m: Float[np.ndarray, " 2"]
) -> Polygon:
    """The wall polygon that runs from one corner to the other and faces the inside, to the left."""
    along = (end_m - start_m) / np.linalg.norm(end_m - start_m)
    outward = np.array([along[1], -along[0]])
    low, high = start_m @ along, end_m @ along
    for wall in walls:
        ring, plane = wall.rings_m[0][:, :2], shape.planes[wall.plane]
        if plane.outward * plane.normal[:2] @ outward < 0.5 or abs((ring[0] - start_m) @ outward) > _SAME_M:
            continue
        if np.ptp(ring @ outward) < _SAME_M:
            reach = ring @ along
            if reach.min() <= low + _SAME_M and reach.max() >= high - _SAME_M:
                return wall
    raise InputError(NOT_ENCLOSED)
