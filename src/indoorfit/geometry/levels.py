"""Levels of floor and ceiling as cubes with one free z-face: steps, platforms, beams, lowered ceilings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.model import Cube, Plane, Role, Shape, Side

from .boxes import room_of_planes
from .exposure import Exposure
from .exposures import exposures
from .plan import bounding_box, components

_PLAN_SIDES: tuple[Side, ...] = ("-x", "+x", "-y", "+y")
_Box = tuple[int, int, int, int]
"""First and last-plus-one cell along x, then along y."""


@dataclass(frozen=True)
class Level:
    """A part of a room's plan over which floor or ceiling lies nearer to the other than elsewhere."""

    room: int
    """Index in the shape's rooms."""
    on: Literal["floor", "ceiling"]
    offset_m: float
    """Height, Manhattan frame."""
    cells: Bool[np.ndarray, "nx ny"]
    """Cells of the plan at this level; no cell has two levels of one kind."""


def with_levels(
    shape: Shape,
    x_lines_m: Sequence[float],
    y_lines_m: Sequence[float],
    rooms: Sequence[Bool[np.ndarray, "nx ny"]],
    levels: Sequence[Level],
) -> Shape:
    """Take away one cube for every rectangular piece of a level.

    A piece that is no rectangle is its bounding box, from which parts are taken away again. A side at
    the end of the room stays open; one that only meets a wall, or continues it, shares the wall's plane;
    every other side is a plane of its own.

    Args:
        shape: rooms with flat floors and ceilings at their lowest and highest level; the plan's walls lie
            on grid lines, with equal numbers.
        x_lines_m: nx + 1 increasing grid lines, Manhattan frame, metres.
        y_lines_m: ny + 1 increasing grid lines.
        rooms: the cells of each room of the shape.
        levels: what differs from the room's own floor and ceiling.

    Returns:
        the shape with further cubes and planes at its end; all of these planes `observed`.
    """
    lines = (np.asarray(x_lines_m, float), np.asarray(y_lines_m, float))
    for room, mask in enumerate(rooms):
        kinds: tuple[Literal["floor", "ceiling"], ...] = ("floor", "ceiling")
        for on in kinds:
            own = [level for level in levels if level.room == room and level.on == on]
            builder = _LevelBuilder(shape, lines, np.asarray(mask, bool), room, on)
            # The sides of what reaches further into the room are there first, to be shared.
            for level in sorted(own, key=lambda level: -builder.rise_m(level)):
                builder.add(level)
            shape = builder.shape
    return shape


class _LevelBuilder:
    """Adds the cubes of one room's floor or ceiling."""

    def __init__(
        self,
        shape: Shape,
        lines_m: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
        mask: Bool[np.ndarray, "nx ny"],
        room: int,
        on: Literal["floor", "ceiling"],
    ):
        self.shape = shape
        self.lines_m = lines_m
        self.on = on
        self.room = shape.rooms[room]
        base = self.room.sides["-z" if on == "floor" else "+z"]
        assert base is not None, "a room has no open side"
        self.base_m = shape.planes[base].offset_m
        self.mask = mask
        # Cells that reach as far into the room as the level at work, or further, are no side to see.
        self.done = np.zeros_like(mask)

    def rise_m(self, level: Level) -> float:
        """How far a level reaches into the room."""
        return (level.offset_m - self.base_m) * (1.0 if self.on == "floor" else -1.0)

    def add(self, level: Level) -> None:
        """One level: as one cube if that covers all of it and nothing else, else piece by piece."""
        assert self.rise_m(level) > 0.0, "the room's own floor and ceiling are its outermost levels"
        wanted = level.cells & self.mask & ~self.done
        kept = self.mask & ~wanted & ~self.done
        pieces = components(wanted)
        if pieces and not (_window(bounding_box(wanted), kept) & kept).any():
            pieces = [wanted]
        for piece in pieces:
            top = self._plane(2, -1 if self.on == "floor" else 1, level.offset_m)
            z: tuple[int | None, int | None] = (None, top) if self.on == "floor" else (top, None)
            self._carve(piece, kept | (wanted & ~piece), self.room.id, bounding_box(self.mask), 0, z)
        self.done |= wanted

    def _plane(self, axis: int, outward: int, offset_m: float) -> int:
        planes = (*self.shape.planes, Plane(axis, outward, float(offset_m)))
        self.shape = Shape(planes, self.shape.cubes)
        return len(planes) - 1

    def _carve(
        self,
        wanted: Bool[np.ndarray, "nx ny"],
        kept: Bool[np.ndarray, "nx ny"],
        parent: str,
        around: _Box,
        depth: int,
        z_planes: tuple[int | None, int | None],
    ) -> None:
        """The bounding box of `wanted` minus what of it is `kept`; all other cells do not matter."""
        box = bounding_box(wanted)
        # A level is taken from the room, so its outside is room; a part of it the other way round.
        turn = -1 if depth % 2 == 0 else 1
        seen = [_seen(k, box, wanted, kept) for k in range(4)]
        # Open only at the end of all: a side that reached through a wall would claim what is behind.
        sides: dict[Side, int | None] = {
            side: None if box[k] == around[k] else self._side(k, box, wanted, seen[k], turn)
            for k, side in enumerate(_PLAN_SIDES)
        }
        sides["-z"], sides["+z"] = z_planes
        cube = Cube(
            f"cube-{len(self.shape.cubes)}",
            self._role(depth, [bool(line.any()) for line in seen]),
            parent,
            sides,
        )
        self.shape = Shape(self.shape.planes, (*self.shape.cubes, cube))
        for missing in components(_window(box, kept) & kept):
            self._carve(missing, wanted, cube.id, box, depth + 1, (None, None))

    def _side(
        self,
        k: int,
        box: _Box,
        wanted: Bool[np.ndarray, "nx ny"],
        seen: Bool[np.ndarray, " n"],
        turn: int,
    ) -> int:
        """The plane of one side of a box: of a wall that it meets or continues, or a new one."""
        axis, sign = k // 2, (1 if k % 2 else -1)
        line_m = float(self.lines_m[axis][box[k]])
        along = seen if seen.any() else np.moveaxis(wanted, axis, 0)[box[k] if sign < 0 else box[k] - 1]
        place = np.flatnonzero(along)
        ends_m = float(self.lines_m[1 - axis][place[0]]), float(self.lines_m[1 - axis][place[-1] + 1])
        homes = room_of_planes(self.shape)
        for exposure in _visible(self.shape, homes, self.room.id):
            plane = self.shape.planes[exposure.plane]
            same = plane.axis == axis and plane.offset_m == line_m
            if same and (plane.outward == turn * sign or not seen.any()) and _touches(exposure, ends_m):
                return exposure.plane
        return self._plane(axis, turn * sign, line_m)

    def _role(self, depth: int, free: list[bool]) -> Role:
        if depth > 0:
            return "part"
        if self.on == "ceiling":
            return "beam" if all(free[:2]) or all(free[2:]) else "step"
        return "platform" if sum(free) > 1 else "step"


def _seen(
    k: int, box: _Box, wanted: Bool[np.ndarray, "nx ny"], kept: Bool[np.ndarray, "nx ny"]
) -> Bool[np.ndarray, " n"]:
    """Along one side of a box, where the level ends within the room."""
    axis, inner = k // 2, box[k] - (k % 2)
    outer = box[k] - 1 + (k % 2)
    lines = np.moveaxis(wanted, axis, 0), np.moveaxis(kept, axis, 0)
    if not 0 <= outer < len(lines[1]):
        return np.zeros(lines[0].shape[1], bool)
    return lines[0][inner] & lines[1][outer]


def _visible(shape: Shape, homes: dict[int, str], room: str) -> list[Exposure]:
    """The visible planes of one room; a plane that no cube has yet is not among them."""
    used = Shape(shape.planes[: max(homes) + 1], shape.cubes)
    return [e for e in exposures(used) if homes[e.plane] == room and e.mask.any()]


def _touches(exposure: Exposure, ends_m: tuple[float, float]) -> bool:
    """Whether an upright plane's visible part meets an interval along it."""
    rows = np.flatnonzero(exposure.mask.any(axis=1))
    low_m, high_m = exposure.u_m[rows], exposure.u_m[rows + 1]
    return bool(np.any((low_m <= ends_m[1]) & (high_m >= ends_m[0])))


def _window(box: _Box, like: Bool[np.ndarray, "nx ny"]) -> Bool[np.ndarray, "nx ny"]:
    window = np.zeros_like(like)
    window[box[0] : box[1], box[2] : box[3]] = True
    return window
