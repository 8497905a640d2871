"""Oblique walls in the tree of cubes: a cube with a yaw of its own at a corner of a room."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from indoorfit.model import SIDES, Cube, Plane, Shape, Side

from .boxes import room_of_planes
from .exposure import Corner
from .exposures import corner_of, exposures

_SAME_M = 1e-9
"""Coordinates that agree to a nanometre are meant to be the same."""
_BEYOND_M = 0.2
"""How far beyond its corner an oblique wall crosses one that it replaces: more than a fit moves it."""


def with_oblique_wall(
    shape: Shape,
    between: tuple[int, int],
    yaw_rad: float,
    offset_m: float,
    opens: bool = False,
    least_m: float = _SAME_M,
) -> Shape:
    """Cut off the corner between two walls of a room.

    A corner of the room is taken away from it, as a notch; the edge of a notch or a pillar is taken away from
    that, as a part, and is room again. A wall of which nothing is left is moved out of the way: then the
    oblique wall stands in its place, and ends at the wall beyond.

    Args:
        shape: the grammar.
        between: planes of the two walls, perpendicular to x and to y in either order.
        yaw_rad: direction out of the room through the new wall, from the Manhattan x axis.
        offset_m: of the new wall along that direction, Manhattan frame.
        opens: whether it is the edge of a notch.
        least_m: walls of which less than this is left are none.

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
    shape = Shape(planes, (*shape.cubes, replace(cube, parent=_holder(shape, room, middle_m, opens))))
    for k in between:
        left = exposures(shape)[k]
        if float(np.diff(left.u_m) @ left.mask.any(axis=1)) < least_m:
            shape = _out_of_the_way(shape, k)
    return shape


def _out_of_the_way(shape: Shape, plane: int) -> Shape:
    """Move a wall outward until the newest oblique wall crosses it well beyond the room."""
    wall, front = shape.planes[plane], shape.planes[-1]
    steepness = abs(front.normal[1 - wall.axis] / front.normal[wall.axis])
    offset_m = wall.offset_m + wall.outward * _BEYOND_M * float(steepness)
    moved = replace(wall, offset_m=offset_m, status="inferred")
    return replace(shape, planes=(*shape.planes[:plane], moved, *shape.planes[plane + 1 :]))


def walls_at(shape: Shape, corner: Corner) -> tuple[int, int] | None:
    """The walls across x and across y that meet in the tip of a corner; None where there is no such corner.

    Args:
        shape: the grammar, before that corner is cut off.
        corner: its first end lies on the wall across x, its second on the one across y.
    """
    found: list[int] = []
    tip_m = corner.corners_m[2]
    for axis in (0, 1):
        away = np.sign(tip_m - corner.corners_m[1 - axis])[axis]
        # What stands in the room is left through its walls the other way round.
        outward = -away if corner.floor else away
        middle_m = 0.5 * (corner.corners_m[axis] + tip_m)
        for exposure in exposures(shape):
            plane = shape.planes[exposure.plane]
            same = (plane.axis, plane.outward, plane.oblique) == (axis, outward, False)
            if same and abs(plane.offset_m - tip_m[axis]) < _SAME_M:
                heights_m = 0.5 * (exposure.v_m[1:] + exposure.v_m[:-1])
                places_m = np.column_stack([np.tile(middle_m, (len(heights_m), 1)), heights_m])
                if exposure.contains(places_m).any():
                    found.append(exposure.plane)
                    break
    return (found[0], found[1]) if len(found) == 2 else None


def _principal(angle_rad: float) -> float:
    return float(np.arctan2(np.sin(angle_rad), np.cos(angle_rad)))


def _holder(shape: Shape, room: str, xy_m: Float[np.ndarray, " 2"], opens: bool) -> str:
    """The innermost cube of the room that holds a place of the plan: of rooms and parts, or notches."""
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
