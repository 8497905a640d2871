"""From a shape to all that can be measured on it, and what was seen of that."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from indoorfit.geometry import SeenPiece
from indoorfit.measure import FaceEvidence, Survey, by_face, survey, with_status, with_thicknesses
from indoorfit.model import Shape
from indoorfit.solid import face_polygons, subtract_cubes


def surveyed(
    shape: Shape, seen: Sequence[SeenPiece], rms_m: Float[np.ndarray, " planes"]
) -> tuple[Survey, FaceEvidence]:
    """The solid of every room, and all that can be measured on and between them; the evidence of each face.

    Args:
        shape: the grammar, with the status of its planes.
        seen: what was seen of the connected parts of the planes.
        rms_m: spread of the points about each plane.
    """
    solids = [subtract_cubes(shape, room) for room in shape.rooms]
    found = survey(shape, solids, [face_polygons(solid) for solid in solids])
    evidence = by_face(shape, found, seen, rms_m)
    return with_thicknesses(shape, with_status(found, evidence)), evidence
