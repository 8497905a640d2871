"""Planes that passed each other in the fit: a step narrower than the scan is good."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int
from scipy import ndimage

from indoorfit.geometry import Exposure, box_exposures, room_of_planes
from indoorfit.model import Shape

from .association import SAME_WALL_M


def unpassed(start: Shape, fitted: Shape, plane_points: Int[np.ndarray, " planes"]) -> Shape | None:
    """The fitted shape with every plane that passed another one put back, and taken as not observed.

    Two parallel planes of one room that change places turn a part of it inside out. Both were fitted to the
    same points, mostly; the one that claimed more of them keeps its place, the other one keeps its distance
    from it. Pieces of one wall that do not meet, such as the fronts of pilasters in a row, have no order:
    which of them is a hair's breadth before the others is noise, and turns nothing.

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
    # Square corners: so that all faces of a room share its grid.
    faces = box_exposures(start.squared)
    for first, second in np.argwhere(before_m[:, None] < before_m[None, :]).tolist():
        if start.planes[first].axis != start.planes[second].axis or room.get(first) != room.get(second):
            continue
        if start.planes[first].oblique or start.planes[second].oblique:
            continue
        if after_m[first] < after_m[second]:
            continue
        if before_m[second] - before_m[first] < SAME_WALL_M and not _meet(faces[first], faces[second]):
            continue
        weak, strong = sorted((first, second), key=lambda k: int(plane_points[k]))
        place_m = float(after_m[strong] + before_m[weak] - before_m[strong])
        planes[weak] = replace(planes[weak], offset_m=place_m, status="inferred")
    return None if planes == list(fitted.planes) else replace(fitted, planes=tuple(planes))


def _meet(first: Exposure, second: Exposure) -> bool:
    """Whether two faces of one room overlap or touch as seen across them; they share the room's grid."""
    grown = ndimage.binary_dilation(first.mask, np.ones((3, 3), bool))
    return bool(np.any(grown & second.mask))
