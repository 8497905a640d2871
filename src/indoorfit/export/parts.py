"""The triangles of one face at a time."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Face, FitResult, RoomMesh


@dataclass(frozen=True)
class FacePart:
    """A face with its own small mesh."""

    face: Face
    vertices_m: Float[np.ndarray, "vertices 3"]
    """Scan frame, metres; the room mesh's own numbers, so neighbours still meet exactly."""
    triangles: Int[np.ndarray, "triangles 3"]
    """Indices into `vertices_m`, counter-clockwise as seen from inside the room."""


def face_parts(result: FitResult, mesh: RoomMesh) -> Iterator[FacePart]:
    """Cut a room's mesh into its faces, in the order of `result.faces`; faces without area are left out."""
    names = np.array(mesh.face_ids)
    for face in result.faces:
        chosen = mesh.triangles[names == face.id]
        if len(chosen):
            used, triangles = np.unique(chosen, return_inverse=True)
            yield FacePart(face, mesh.vertices_m[used], triangles.reshape(-1, 3))
