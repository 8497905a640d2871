"""Face polygons that meet corner to corner."""

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Face, FitResult, RoomMesh

_TOLERANCE_M = 1e-7
"""How far a corner may be from an edge to lie on it: far below the micrometre that the solid merges at its
coarsest, far above rounding at map coordinates (1e-9 m)."""


def closed_rings(result: FitResult, mesh: RoomMesh, face: Face) -> list[Int[np.ndarray, " _"]]:
    """The rings of a face as indices of its room's mesh, with every vertex that lies on their edges.

    `Face.rings_m` leaves out corners of neighbouring faces in the middle of an edge. A surface made of such
    rings has slits of no width; formats that demand closed bodies need all vertices.

    Args:
        result: the model.
        mesh: of the face's room.
        face: a face with area.

    Returns:
        the outer ring, counter-clockwise as seen from inside the room, then the holes, clockwise.
    """
    vertices_m = result.frame.to_manhattan(mesh.vertices_m)
    return [_with_all_corners(result.frame.to_manhattan(ring), vertices_m) for ring in face.rings_m]


def _with_all_corners(
    ring_m: Float[np.ndarray, "corners 3"], vertices_m: Float[np.ndarray, "vertices 3"]
) -> Int[np.ndarray, " _"]:
    found: list[int] = []
    for a, b in zip(ring_m, np.roll(ring_m, -1, axis=0), strict=True):
        along = (b - a) / np.linalg.norm(b - a)
        reach = (vertices_m - a) @ along
        away = np.linalg.norm(vertices_m - a - np.outer(reach, along), axis=1)
        on_edge = (away < _TOLERANCE_M) & (reach > -_TOLERANCE_M)
        # Without the end, which is the next edge's start.
        on_edge &= reach < np.linalg.norm(b - a) - _TOLERANCE_M
        chosen = np.flatnonzero(on_edge)
        found += chosen[np.argsort(reach[chosen])].tolist()
    return np.array(found, dtype=np.int64)
