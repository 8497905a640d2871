"""The clear length of a wall between the walls at its two ends, whatever their directions."""

import numpy as np

from indoorfit.model import Shape

from .named import Measurand, distance


def clear_length(shape: Shape, before: int, wall: int, after: int) -> Measurand:
    """Length of the foot of a wall, and its derivative.

    Args:
        shape: the grammar.
        before: plane of the wall at the start, walking with the room to the left.
        wall: plane of the wall itself.
        after: plane of the wall at the end.
    """
    if not any(shape.planes[k].oblique for k in (before, wall, after)):
        low, high = sorted((before, after), key=lambda k: shape.planes[k].offset_m)
        return distance(shape, low, high)
    start_m, end_m = shape.corner_m(before, wall), shape.corner_m(wall, after)
    along = (end_m - start_m) / np.linalg.norm(end_m - start_m)
    gradient = _moved(shape, wall, after, end_m, along) - _moved(shape, before, wall, start_m, along)
    return Measurand(float(along @ (end_m - start_m)), gradient)


def _moved(shape: Shape, first: int, second: int, corner_m: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Derivative of a corner's (2,) place along a direction (2,), with respect to all parameters.

    The corner solves ``n.p = d`` for both planes; with a yaw, ``dn = t dyaw``.
    """
    gradient = np.zeros(len(shape.parameters))
    ends = (first, second)
    inverse = np.linalg.inv(np.stack([shape.planes[k].normal[:2] for k in ends]))
    for k, column in zip(ends, (along @ inverse).tolist(), strict=True):
        gradient[k] += column
        if shape.planes[k].oblique:
            gradient[shape.yaw_parameter(k)] -= column * float(shape.planes[k].turn_normal[:2] @ corner_m)
    return gradient


def swept(shape: Shape, plane: int, size: float, middle_m: np.ndarray) -> np.ndarray:
    """Derivative of an area or a volume that a plane bounds, with respect to all parameters.

    Moving a face outward by dx adds its size times dx; turning it moves each place by its distance from the
    axis, on average that of its middle.

    Args:
        shape: the grammar.
        plane: of the face.
        size: length of the edge (m), or area of the face (m²).
        middle_m: (2,) or (3,) its centre, Manhattan frame.
    """
    gradient = np.zeros(len(shape.parameters))
    bound = shape.planes[plane]
    gradient[plane] = bound.outward * size
    if bound.oblique:
        turned = float(bound.turn_normal[:2] @ middle_m[:2])
        gradient[shape.yaw_parameter(plane)] = -bound.outward * size * turned
    return gradient
