"""The outline of a room's plan as a loop of walls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.model import Polygon, Shape

from .plan_cells import NOT_ENCLOSED, PlanCells


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


def floor_loops(shape: Shape, pieces: Sequence[Polygon], cells: PlanCells) -> tuple[FloorLoop, ...]:
    """Match every side of the plan to its wall, whatever levels the floor has.

    Args:
        shape: the grammar.
        pieces: the polygons of one room.
        cells: of these polygons.

    Raises:
        InputError: a side of the plan has no wall.
    """
    walls = [piece for piece in pieces if shape.planes[piece.plane].axis < 2]
    loops = []
    for ring in cells.rings_m():
        following = np.roll(ring, -1, axis=0)
        edges = [
            FloorEdge(_wall_at(shape, walls, start, end), start, end)
            for start, end in zip(ring, following, strict=True)
        ]
        loops.append(FloorLoop(tuple(edges)))
    return tuple(loops)


def _wall_at(
    shape: Shape, walls: Sequence[Polygon], start_m: Float[np.ndarray, " 2"], end_m: Float[np.ndarray, " 2"]
) -> Polygon:
    """The wall polygon that runs from one corner to the other and faces the inside, to the left."""
    axis = 0 if start_m[0] == end_m[0] else 1
    along = 1 - axis
    outward = int(np.sign(end_m[along] - start_m[along])) * (1 if axis == 0 else -1)
    low, high = sorted((start_m[along], end_m[along]))
    for wall in walls:
        ring, plane = wall.rings_m[0], shape.planes[wall.plane]
        if (plane.axis, plane.outward) == (axis, outward) and ring[0, axis] == start_m[axis]:
            # Corners are bitwise shared: polygons come from one mesh.
            if ring[:, along].min() <= low and ring[:, along].max() >= high:
                return wall
    raise InputError(NOT_ENCLOSED)
