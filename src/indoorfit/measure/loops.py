"""The outline of a room's floor as a loop of walls."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.model import Polygon, Shape

NOT_ENCLOSED = (
    "measure: the walls that were fitted do not enclose a room: two of them have passed each other, as "
    "happens where a step is narrower than the scan is good. Fix: scan that step more closely, or raise "
    "discover.candidates.min_area_m2 so that it is left out."
)


@dataclass(frozen=True)
class FloorEdge:
    """One side of the floor and the wall that stands on it."""

    wall: Polygon
    start_m: Float[np.ndarray, " 3"]
    """Manhattan frame; walls are met counter-clockwise around the room as seen from above."""
    end_m: Float[np.ndarray, " 3"]


@dataclass(frozen=True)
class FloorLoop:
    """A closed outline: the first of a room is the outer one, the others go around pillars."""

    edges: tuple[FloorEdge, ...]


def floor_loops(shape: Shape, pieces: Sequence[Polygon]) -> tuple[FloorLoop, ...]:
    """Match every edge of the floor to its wall.

    Args:
        shape: the grammar.
        pieces: the polygons of one room.

    Raises:
        InputError: an edge of the floor has no wall.
    """
    walls = [piece for piece in pieces if shape.planes[piece.plane].axis < 2]
    floors = [piece for piece in pieces if shape.planes[piece.plane].face_class == "floor"]
    loops = []
    for floor in floors:
        for ring in floor.rings_m:
            following = np.roll(ring, -1, axis=0)
            edges = [
                FloorEdge(_wall_at(shape, walls, start, end), start, end)
                for start, end in zip(ring, following, strict=True)
            ]
            loops.append(FloorLoop(tuple(edges)))
    return tuple(loops)


def _wall_at(
    shape: Shape, walls: Sequence[Polygon], start_m: Float[np.ndarray, " 3"], end_m: Float[np.ndarray, " 3"]
) -> Polygon:
    """The wall polygon whose foot runs from one corner to the other."""
    axis = 0 if start_m[0] == end_m[0] else 1
    along = 1 - axis
    low, high = sorted((start_m[along], end_m[along]))
    for wall in walls:
        ring = wall.rings_m[0]
        if shape.planes[wall.plane].axis == axis and ring[0, axis] == start_m[axis]:
            # Corners are bitwise shared: polygons come from one mesh.
            if ring[:, along].min() <= low and ring[:, along].max() >= high:
                return wall
    raise InputError(NOT_ENCLOSED)
