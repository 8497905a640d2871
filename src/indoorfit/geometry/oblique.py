"""Oblique walls in the tree of cubes: a cube with a yaw of its own at a corner of a room."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from indoorfit.model import SIDES, Cube, Plane, Shape, Side

from .boxes import room_of_planes
from .exposures import corner_of


def with_oblique_wall(
    shape: Shape, between: tuple[int, int], yaw_rad: float, offset_m: float, opens: bool = False
) -> Shape:
    """Cut off the corner between two walls of a room.

    A corner of the room is taken away from it, as a notch; the edge of a notch or a pillar is taken away from
    that, as a part, and is room again.

    Args:
        shape: the grammar.
        between: planes of the two walls, perpendicular to x and to y in either order.
        yaw_rad: direction out of the room through the new wall, from the Manhattan x axis.
        offset_m: of the new wall along that direction, Manhattan frame.
        opens: whether it is the edge of a notch.

    Returns:
        the shape with one more plane, its last, and one more cube.
    """
    front = len(shape.planes)
    sides: dict[Side, int | None] = dict.fromkeys(SIDES)
    # The room is on the lower side of the plane: there lies what is opened, beyond it what is taken away.
    sides["+x" if opens else "-x"] = front
    room = room_of_planes(shape)[between[0]]
    cube = Cube(f"cube-{len(shape.cubes)}", "part" if opens else "notch", room, sides, between)
    planes = (*shape.planes, Plane(0, 1, offset_m, yaw_rad=_principal(yaw_rad)))
    middle_m = corner_of(Shape(planes, (*shape.cubes, cube)), cube).corners_m.mean(axis=0)
    return Shape(planes, (*shape.cubes, replace(cube, parent=_holder(shape, room, middle_m, opens))))


def _principal(angle_rad: float) -> float:
    return float(np.arctan2(np.sin(angle_rad), np.cos(angle_rad)))


def _holder(shape: Shape, room: str, xy_m: Float[np.ndarray, " 2"], opens: bool) -> str:
    """The innermost cube of the room's tree in the plan that holds a place: of rooms and parts, or notches."""
    bounds_m = shape.squared.bounds_m()
    found = room
    for cube in shape.squared.cubes:
        low_m, high_m = bounds_m[cube.id]
        wanted = ("notch", "pillar") if opens else ("room", "part")
        if cube.role in wanted and np.all((xy_m > low_m[:2]) & (xy_m < high_m[:2])):
            if cube.id == room or _root(shape, cube) == room:
                found = cube.id
    return found


def _root(shape: Shape, cube: Cube) -> str | None:
    """The room of a cube of the plan; None for what belongs to a level of floor or ceiling."""
    by_id = {other.id: other for other in shape.cubes}
    while cube.parent is not None:
        if cube.role in ("step", "platform", "beam"):
            return None
        cube = by_id[cube.parent]
    return cube.id
