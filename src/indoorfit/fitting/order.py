"""Planes that passed each other in the fit: a step narrower than the scan is good."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from indoorfit.geometry import room_of_planes
from indoorfit.model import Shape


def unpassed(start: Shape, fitted: Shape, plane_points: Int[np.ndarray, " planes"]) -> Shape | None:
    """The fitted shape with every plane that passed another one put back, and taken as not observed.

    Two parallel planes of one room that change places turn a part of it inside out. Both were fitted to the
    same points, mostly; the one that claimed more of them keeps its place, the other one keeps its distance
    from it.

    Args:
        start: as discovered.
        fitted: the same planes after the fit.
        plane_points: points claimed by each plane.

    Returns:
        a start for another fit; None if all planes are in order.
    """
    room = room_of_planes(start)
    planes = list(fitted.planes)
    before_m, after_m = start.offsets_m, fitted.offsets_m
    for first, second in np.argwhere(before_m[:, None] < before_m[None, :]).tolist():
        if start.planes[first].axis != start.planes[second].axis or room.get(first) != room.get(second):
            continue
        if after_m[first] < after_m[second]:
            continue
        weak, strong = sorted((first, second), key=lambda k: int(plane_points[k]))
        place_m = float(after_m[strong] + before_m[weak] - before_m[strong])
        planes[weak] = replace(planes[weak], offset_m=place_m, status="inferred")
    return None if planes == list(fitted.planes) else replace(fitted, planes=tuple(planes))
