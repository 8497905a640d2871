"""From the lines of the plan to where the surfels are."""

from dataclasses import replace

import numpy as np

from indoorfit.geometry import Exposure, exposures, room_of_planes
from indoorfit.model import Plane, Shape

from .outline import Outline
from .surfaces import Surfaces

_REACH_M = 0.10
"""Surfels this far from a plane's line may be its own, as the points of the fit."""


def placed(shape: Shape, surfaces: Surfaces, outline: Outline) -> Shape:
    """Every plane at the median of the surfels on it; without any it is inferred and stays.

    Args:
        shape: on the lines of the plan, and on the levels that were found.
        surfaces: sorted evidence.
        outline: of the plan, with the walls whose places are guessed: these stay, with their doubt.
    """
    homes, number = room_of_planes(shape), {room.id: k for k, room in enumerate(shape.rooms)}
    planes = []
    for exposure, reach_m in zip(exposures(shape), _reaches(shape), strict=True):
        plane, doubt_m = shape.planes[exposure.plane], 0.0
        if exposure.plane in homes:
            room = number[homes[exposure.plane]]
            doubt_m = outline.doubt_m(room, plane.axis, plane.outward, plane.offset_m)
        planes.append(_place(plane, exposure, surfaces, reach_m, doubt_m))
    return replace(shape, planes=tuple(planes))


def _reaches(shape: Shape) -> list[tuple[float, float]]:
    """How far below and above itself each plane looks for surfels: half the way to the next one of its room.

    So no two of them change places, whatever is seen between them.
    """
    room, offsets_m = room_of_planes(shape), shape.offsets_m
    found = []
    for k, plane in enumerate(shape.planes):
        others = [
            j
            for j, other in enumerate(shape.planes)
            if other.axis == plane.axis and not other.oblique and room.get(j) == room.get(k)
        ]
        gaps_m = offsets_m[others] - plane.offset_m
        below_m, above_m = -gaps_m[gaps_m < 0.0], gaps_m[gaps_m > 0.0]
        found.append(
            (
                min(_REACH_M, 0.5 * float(below_m.min(initial=np.inf))),
                min(_REACH_M, 0.5 * float(above_m.min(initial=np.inf))),
            )
        )
    return found


def _place(
    plane: Plane, exposure: Exposure, surfaces: Surfaces, reach_m: tuple[float, float], doubt_m: float
) -> Plane:
    """One plane; `reach_m` is how far below and above its line surfels may be its own.

    With a doubt its place is a guess.
    """
    if plane.oblique:
        return plane
    if doubt_m > 0.0:
        return replace(plane, status="inferred", doubt_m=doubt_m)
    level_m = surfaces.walls_m[plane.axis] if plane.axis < 2 else surfaces.ceiling_m
    if plane.axis == 2 and plane.outward < 0:
        level_m = surfaces.floor_m
    above_m = level_m[:, plane.axis] - plane.offset_m
    near = (above_m > -reach_m[0]) & (above_m < reach_m[1])
    near[near] = exposure.contains(level_m[near])
    share = near.sum() * (surfaces.pixel_m / 2.0) ** 2 / max(exposure.area_m2, 1e-9)
    if near.sum() < 3 or share < 0.02:
        return replace(plane, status="inferred")
    return replace(plane, offset_m=float(np.median(level_m[near, plane.axis])))
