"""The true cube grammar of a scene."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.errors import ConfigError
from indoorfit.geometry import Corner, exposures, shape_from_plan, walls_at, with_oblique_wall
from indoorfit.model import Cube, Plane, Shape, Side

from .scene import ObliqueWall, RoomPlan, Scene, Step

_TOUCHING_M = 1e-9
"""Coordinates of a scene that agree to a nanometre are meant to be the same."""


def scene_shape(scene: Scene) -> Shape:
    """Rooms, notches, pillars, steps and oblique walls of a scene, Manhattan frame.

    Raises:
        ConfigError: a room's plan is not a plan, or a step lies outside its room.
    """
    if not scene.rooms:
        raise ConfigError(f"{scene.name}: a scene without rooms. Fix: add an entry [[rooms]].")
    for k, room in enumerate(scene.rooms):
        _check_room(scene.name, k, room)
    x_lines = np.unique(np.concatenate([room.x_lines_m for room in scene.rooms]))
    y_lines = np.unique(np.concatenate([room.y_lines_m for room in scene.rooms]))
    masks = [_mask_on(room, x_lines, y_lines) for room in scene.rooms]
    z_ranges = [(room.floor_m, room.ceiling_m) for room in scene.rooms]
    shape = shape_from_plan(x_lines.tolist(), y_lines.tolist(), masks, z_ranges)
    for step in scene.steps:
        shape = _with_step(scene.name, shape, step)
    for wall in scene.oblique_walls:
        shape = _with_oblique(scene.name, shape, wall)
    return shape


def _with_oblique(name: str, shape: Shape, wall: ObliqueWall) -> Shape:
    start_m, end_m = np.array(wall.start_m), np.array(wall.end_m)
    across_m = end_m - start_m
    outward = np.array([across_m[1], -across_m[0]]) / np.linalg.norm(across_m)
    for tip_m in (np.array([start_m[0], end_m[1]]), np.array([end_m[0], start_m[1]])):
        on_x, on_y = (start_m, end_m) if tip_m[0] == start_m[0] else (end_m, start_m)
        # On the side of the room the tip is that of something standing in it.
        opens = bool(outward @ (tip_m - start_m) < 0.0)
        between = walls_at(shape, Corner(np.stack([on_x, on_y, tip_m]), opens))
        if between is not None:
            yaw_rad = float(np.arctan2(outward[1], outward[0]))
            return with_oblique_wall(shape, between, yaw_rad, float(outward @ start_m), opens)
    raise ConfigError(
        f"{name}: an oblique wall from {wall.start_m} to {wall.end_m}, which cuts no corner off. Fix: begin "
        "and end on two walls that meet in a corner, one across x and one across y."
    )


def room_mask(room: RoomPlan) -> Bool[np.ndarray, "nx ny"]:
    """The cells of a plan as an array, x first, both axes increasing."""
    rows = np.array([[cell == "#" for cell in row] for row in reversed(room.cells)])
    return rows.T


def _check_room(name: str, k: int, room: RoomPlan) -> None:
    nx, ny = len(room.x_lines_m) - 1, len(room.y_lines_m) - 1
    where = f"{name}: room {k}"
    if len(room.cells) != ny or any(len(row) != nx or set(row) - {"#", "."} for row in room.cells):
        raise ConfigError(
            f"{where}: cells are not {ny} rows of {nx} characters '#' or '.', as its lines ask for. "
            "Fix: one row for each gap between y lines, one character for each gap between x lines."
        )
    increasing = (np.diff(room.x_lines_m) > 0).all() and (np.diff(room.y_lines_m) > 0).all()
    if not increasing or not room.ceiling_m > room.floor_m or not room_mask(room).any():
        raise ConfigError(
            f"{where}: lines must increase, the ceiling must lie above the floor and some cell must be room. "
            "Fix: correct x_lines_m, y_lines_m, cells, floor_m or ceiling_m."
        )


def _mask_on(
    room: RoomPlan, x_lines: Float[np.ndarray, " nx1"], y_lines: Float[np.ndarray, " ny1"]
) -> Bool[np.ndarray, "nx ny"]:
    """The room's cells on a finer grid that holds all of its lines."""
    x, y = 0.5 * (x_lines[1:] + x_lines[:-1]), 0.5 * (y_lines[1:] + y_lines[:-1])
    i = np.searchsorted(room.x_lines_m, x)
    j = np.searchsorted(room.y_lines_m, y)
    return np.pad(room_mask(room), 1)[np.ix_(i, j)]


def _with_step(name: str, shape: Shape, step: Step) -> Shape:
    if not 0 <= step.room < len(shape.rooms):
        raise ConfigError(
            f"{name}: a step in room {step.room}, which does not exist. Fix: number the rooms from 0."
        )
    room = shape.rooms[step.room]
    low_m, high_m = shape.bounds_m()[room.id]
    if not 0.0 < step.height_m < high_m[2] - low_m[2]:
        raise ConfigError(
            f"{name}: a step of {step.height_m:g} m in a room of height {high_m[2] - low_m[2]:g} m. "
            "Fix: the height must lie between the two."
        )
    planes = list(shape.planes)
    sides: dict[Side, int | None] = {}
    ends: tuple[tuple[Side, int, float, float, int], ...] = (
        ("-x", 0, step.low_m[0], low_m[0], -1),
        ("+x", 0, step.high_m[0], high_m[0], 1),
        ("-y", 1, step.low_m[1], low_m[1], -1),
        ("+y", 1, step.high_m[1], high_m[1], 1),
    )
    for side, axis, at_m, outer_m, sign in ends:
        sides[side] = None
        if (at_m - outer_m) * sign < -_TOUCHING_M:
            sides[side] = len(planes)
            # The room is outside the step: leaving the room means going into it.
            planes.append(Plane(axis, -sign, float(at_m)))
    top = len(planes)
    if step.on == "floor":
        planes.append(Plane(2, -1, float(low_m[2] + step.height_m)))
        sides["-z"], sides["+z"] = None, top
    else:
        planes.append(Plane(2, 1, float(high_m[2] - step.height_m)))
        sides["-z"], sides["+z"] = top, None
    cube = Cube(f"cube-{len(shape.cubes)}", "step" if step.on == "floor" else "beam", room.id, sides)
    stepped = Shape(tuple(planes), (*shape.cubes, cube))
    return _open_unseen_sides(name, stepped)


def _open_unseen_sides(name: str, shape: Shape) -> Shape:
    """Open the last cube's sides that end inside a wall: no one can see them, so they carry no plane.

    A step may end in a notch. Its hidden side then runs on to the outside, if that changes nothing.
    """
    cube = shape.cubes[-1]
    areas_m2 = np.array([e.area_m2 for e in exposures(shape)])
    if sum(areas_m2[k] for k in (cube.sides["-z"], cube.sides["+z"]) if k is not None) == 0.0:
        raise ConfigError(f"{name}: a step that lies outside its room. Fix: correct low_m and high_m.")
    for side, index in cube.sides.items():
        if index is None or areas_m2[index] > 0.0:
            continue
        candidate = _opened(shape, side, index)
        changed_m2 = np.abs(np.delete(areas_m2, index) - [e.area_m2 for e in exposures(candidate)])
        if changed_m2.max() < _TOUCHING_M:
            return _open_unseen_sides(name, candidate)
    return shape


def _opened(shape: Shape, side: Side, index: int) -> Shape:
    """The last cube without the plane at one of its sides; later planes move up by one."""
    last = replace(shape.cubes[-1], sides={**shape.cubes[-1].sides, side: None})

    def moved(k: int | None) -> int | None:
        return None if k is None else k - (k > index)

    cubes = tuple(
        replace(cube, sides={name: moved(k) for name, k in cube.sides.items()})
        for cube in (*shape.cubes[:-1], last)
    )
    return Shape(shape.planes[:index] + shape.planes[index + 1 :], cubes)
