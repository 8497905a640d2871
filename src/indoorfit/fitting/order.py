"""Planes that passed each other in the fit: a step narrower than the scan is good."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int

from indoorfit.geometry import passed, reverted
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
        a start for another fit; None if all planes are in order (`passed`).
    """
    planes = list(fitted.planes)
    before_m, after_m = start.offsets_m, fitted.offsets_m
    pairs = passed(start, fitted)
    for pair in pairs:
        weak, strong = sorted(pair, key=lambda k: int(plane_points[k]))
        place_m = float(after_m[strong] + before_m[weak] - before_m[strong])
        planes[weak] = replace(planes[weak], offset_m=place_m, status="inferred")
    return replace(fitted, planes=tuple(planes)) if pairs else None


def as_started(start: Shape, fitted: Shape) -> Shape:
    """The fitted shape with all planes back, and taken as not observed, wherever some passed each other.

    The last resort: a direction of a room that is as it was discovered is in order, and stays so, since what
    is not observed is not fitted.

    Args:
        start: as discovered.
        fitted: the same planes after the fit.
    """
    shape, back = reverted(start, fitted)
    planes = list(shape.planes)
    for k in back:
        planes[k] = replace(planes[k], status="inferred")
    return replace(shape, planes=tuple(planes))
