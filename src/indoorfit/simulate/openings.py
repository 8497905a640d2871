"""Doors and windows: which walls they pierce, their jambs, and what is seen through them."""

from dataclasses import dataclass

import numpy as np

from indoorfit.errors import ConfigError
from indoorfit.geometry import Exposure
from indoorfit.model import Shape

from .quads import QuadList
from .scene import Opening, Scene
from .surfaces import Surface

Rect = tuple[float, float, float, float]
"""First other axis from, to; second other axis (z on walls) from, to; metres."""


@dataclass(frozen=True)
class Pierced:
    """One wall with a hole."""

    plane: int
    rect: Rect


def pierced(scene: Scene, shape: Shape, found: tuple[Exposure, ...], opening: Opening) -> tuple[Pierced, ...]:
    """The walls that an opening goes through: one, or the two sides of a partition.

    Raises:
        ConfigError: no wall is in reach.
    """
    axis = "xy".index(opening.axis)
    at_m, along_m = opening.centre_m[axis], opening.centre_m[1 - axis]
    u = (along_m - 0.5 * opening.width_m, along_m + 0.5 * opening.width_m)
    walls = []
    for exposure in found:
        plane = shape.planes[exposure.plane]
        if plane.axis != axis or plane.oblique or abs(plane.offset_m - at_m) > opening.reach_m:
            continue
        i, j = np.nonzero(exposure.mask)
        bounds = (
            exposure.u_m[i.min()],
            exposure.u_m[i.max() + 1],
            exposure.v_m[j.min()],
            exposure.v_m[j.max() + 1],
        )
        rect = (
            max(u[0], bounds[0]), min(u[1], bounds[1]),
            max(opening.bottom_m, bounds[2]), min(opening.top_m, bounds[3]),
        )  # fmt: skip
        if rect[1] > rect[0] and rect[3] > rect[2]:
            near, far, low, high = (float(x) for x in rect)
            walls.append((abs(plane.offset_m - at_m), Pierced(exposure.plane, (near, far, low, high))))
    if not walls:
        raise ConfigError(
            f"{scene.name}: no wall within {opening.reach_m:g} m of the {opening.kind} at "
            f"{opening.axis} = {at_m:g} m. Fix: correct its centre_m or axis."
        )
    # Of walls that face the same way only the nearest: a 33 cm step beside a window stays whole.
    nearest = {shape.planes[wall.plane].outward: wall for _, wall in sorted(walls, key=lambda w: -w[0])}
    return tuple(nearest.values())


def without(rect: Rect, holes: list[Rect]) -> list[Rect]:
    """A rectangle minus others, as at most four pieces for each."""
    pieces = [rect]
    for h0, h1, g0, g1 in holes:
        rest: list[Rect] = []
        for u0, u1, v0, v1 in pieces:
            a0, a1, b0, b1 = max(u0, h0), min(u1, h1), max(v0, g0), min(v1, g1)
            if a0 >= a1 or b0 >= b1:
                rest.append((u0, u1, v0, v1))
                continue
            rest += [(u0, a0, v0, v1), (a1, u1, v0, v1), (a0, a1, v0, b0), (a0, a1, b1, v1)]
        pieces = [p for p in rest if p[1] > p[0] and p[3] > p[2]]
    return pieces


def add_openings(
    quads: QuadList, surfaces: list[Surface], shape: Shape, opening: Opening, walls: tuple[Pierced, ...]
) -> None:
    """Append jambs, pane and view of one opening."""
    axis = "xy".index(opening.axis)
    offsets = [shape.planes[wall.plane].offset_m for wall in walls]
    outward = shape.planes[walls[0].plane].outward
    rect = walls[0].rect
    joined = len(walls) > 1
    near = offsets[0]
    far = max(offsets, key=lambda o: abs(o - near)) if joined else near + outward * opening.depth_m
    surfaces.append(Surface(colour=(235, 235, 230)))
    _tunnel(quads, axis, near, far, rect, len(surfaces) - 1)
    if opening.glazed:
        surfaces.append(Surface(colour=(200, 220, 225)))
        middle = 0.5 * (near + far)
        for sign in (-1, 1):
            quads.add_axis_aligned(
                axis, _corner(axis, middle, rect, 0), _corner(axis, middle, rect, 1), sign,
                len(surfaces) - 1, glass=True,
            )  # fmt: skip
    if joined or opening.view_m is None:
        return
    surfaces.append(Surface(colour=(150, 160, 150), texture="stripes"))
    if opening.kind == "window":
        # A facade across the street, wide enough to fill the window from most of the room.
        wide: Rect = (rect[0] - 8.0, rect[1] + 8.0, rect[2] - 4.0, rect[3] + 6.0)
        at = far + outward * opening.view_m
        low, high = _corner(axis, at, wide, 0), _corner(axis, at, wide, 1)
        quads.add_axis_aligned(axis, low, high, -outward, len(surfaces) - 1)
    else:
        _corridor(quads, surfaces, axis, far, outward, opening.view_m, rect)


def _corner(axis: int, at_m: float, rect: Rect, end: int) -> np.ndarray:
    return np.insert([rect[end], rect[2 + end]], axis, at_m)


def _tunnel(quads: QuadList, axis: int, near: float, far: float, rect: Rect, surface: int) -> None:
    """Four rectangles that face each other around an opening."""
    low = _corner(axis, min(near, far), rect, 0)
    high = _corner(axis, max(near, far), rect, 1)
    for side_axis in (1 - axis, 2):
        for sign in (-1, 1):
            a, b = low.copy(), high.copy()
            a[side_axis] = b[side_axis] = (low if sign < 0 else high)[side_axis]
            quads.add_axis_aligned(side_axis, a, b, -sign, surface)


def _corridor(
    quads: QuadList, surfaces: list[Surface], axis: int, start: float, outward: int, depth: float, rect: Rect
) -> None:
    """A corridor across the door: its floor at the sill, 2.5 m high, open at both ends."""
    wall = len(surfaces) - 1
    surfaces.append(Surface(colour=(120, 110, 100), texture="grain"))
    end = start + outward * depth
    wide: Rect = (rect[0] - 4.0, rect[1] + 4.0, rect[2], rect[2] + 2.5)
    quads.add_axis_aligned(axis, _corner(axis, end, wide, 0), _corner(axis, end, wide, 1), -outward, wall)
    low = _corner(axis, min(start, end), wide, 0)
    high = _corner(axis, max(start, end), wide, 1)
    for z, sign in ((wide[2], 1), (wide[3], -1)):
        a, b = low.copy(), high.copy()
        a[2] = b[2] = z
        quads.add_axis_aligned(2, a, b, sign, len(surfaces) - 1)
