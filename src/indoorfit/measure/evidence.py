"""What was seen of every face, and which were not seen at all."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from indoorfit.geometry import SeenPiece
from indoorfit.model import RoomSolid, Shape

from .named import NamedFace, Survey, triangles_of

_LEAST_SHARE = 0.02
"""Of a face's area: what lies on less of it may be stray points of a face that was not seen."""


@dataclass(frozen=True)
class FaceEvidence:
    """What the points say of every face of a survey, in its order."""

    n_points: Int[np.ndarray, " faces"]
    coverage: Float[np.ndarray, " faces"]
    """Share of each face's area that points were seen on."""
    rms_m: Float[np.ndarray, " faces"]
    """Spread of the points about the plane of each face."""


def by_face(
    shape: Shape, found: Survey, seen: Sequence[SeenPiece], rms_m: Float[np.ndarray, " planes"]
) -> FaceEvidence:
    """What was seen of each face: of the piece of its plane that it lies in.

    Args:
        shape: that was surveyed.
        found: its survey.
        seen: of the connected parts of the planes; the shape may have moved a little since.
        rms_m: spread of the points about each plane.
    """
    solids = {room.id: room.solid for room in found.rooms}
    n_points, coverage = np.zeros(len(found.faces), int), np.zeros(len(found.faces))
    for k, face in enumerate(found.faces):
        own = [piece for piece in seen if piece.part.plane == face.polygon.plane]
        if len(own) > 1:
            middle_m = shape.planes[face.polygon.plane].to_own(_inner_point_m(solids[face.room], face)[None])
            own = [piece for piece in own if piece.part.contains(middle_m).any()]
        for piece in own:
            n_points[k], coverage[k] = piece.n_points, piece.coverage
    return FaceEvidence(n_points, coverage, rms_m[[face.polygon.plane for face in found.faces]])


def _inner_point_m(solid: RoomSolid, face: NamedFace) -> Float[np.ndarray, " 3"]:
    """A place well within a face: the middle of its largest triangle."""
    middles_m, areas_m2 = triangles_of(solid, face.polygon)
    return middles_m[int(np.argmax(areas_m2))]


def with_status(found: Survey, evidence: FaceEvidence) -> Survey:
    """The survey with the faces that were not seen as inferred, where their plane was seen on others.

    Args:
        found: a survey, with the status of the planes.
        evidence: of its faces.
    """
    on_plane = Counter(face.polygon.plane for face in found.faces)
    faces = [
        replace(face, status="inferred")
        if on_plane[face.polygon.plane] > 1 and share < _LEAST_SHARE
        else face
        for face, share in zip(found.faces, evidence.coverage, strict=True)
    ]
    return replace(found, faces=tuple(faces))
