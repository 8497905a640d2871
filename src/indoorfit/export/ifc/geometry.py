"""Bodies and surfaces of rooms and faces."""

import math
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.model import Doorway, Face, FitResult, RoomMesh

from ..palette import face_colour
from .document import IfcDocument


def room_body(ifc: IfcDocument, body: Any, result: FitResult, mesh: RoomMesh, floor_m: float) -> Any:
    """The air of a room as a closed body.

    Args:
        ifc: the file.
        body: representation context.
        result: the model.
        mesh: of the room.
        floor_m: height of the storey, Manhattan frame; its own coordinates begin there.
    """
    corners = result.frame.to_manhattan(mesh.vertices_m) - [0.0, 0.0, floor_m]
    coordinates = ifc.make("IfcCartesianPointList3D", (corners + 0.0).tolist())
    # Ours look into the room, a body's look out of it; IFC counts from 1.
    triangles = (mesh.triangles[:, ::-1] + 1).tolist()
    item = ifc.make("IfcTriangulatedFaceSet", coordinates, None, True, triangles, None)
    return _shape(ifc, body, "Tessellation", item)


def face_surface(ifc: IfcDocument, body: Any, result: FitResult, face: Face, floor_m: float) -> Any:
    """A face as the surface that was measured, without a thickness, looking into the room.

    A wall's other side was not seen from here, so a body would need an invented number.
    """
    bounds = []
    for k, ring_m in enumerate(face.rings_m):
        corners = result.frame.to_manhattan(ring_m) - [0.0, 0.0, floor_m]
        loop = ifc.make("IfcPolyLoop", ifc.points(corners))
        bounds.append(ifc.make("IfcFaceBound" if k else "IfcFaceOuterBound", loop, True))
    faces = ifc.make("IfcConnectedFaceSet", [ifc.make("IfcFace", bounds)])
    item = ifc.make("IfcFaceBasedSurfaceModel", [faces])
    ifc.colour(item, face_colour(face))
    return _shape(ifc, body, "SurfaceModel", item)


def face_area_m2(face: Face) -> float:
    """Area of a face: half the length of its rings' summed vector area; holes run the other way round."""
    return 0.5 * float(np.linalg.norm(sum((_vector_area(ring) for ring in face.rings_m), np.zeros(3))))


def opening_height_m(result: FitResult, doorway: Doorway) -> float:
    """Clear height of a doorway; where no lintel was seen, up to the top of the lower of its two walls."""
    if doorway.height_m is not None:
        return doorway.height_m
    sill, *tops = (
        float(result.frame.to_manhattan(corners_m)[:, 2].max())
        for corners_m in (
            doorway.sill_m[None],
            *(np.concatenate(result.face(face).rings_m) for face in doorway.faces),
        )
    )
    return min(tops) - sill


def opening_area_m2(result: FitResult, face: Face) -> float:
    """Area of a wall's doorways."""
    return math.fsum(
        doorway.width_m * opening_height_m(result, doorway)
        for doorway in result.adjacency
        if face.id in doorway.faces
    )


def _vector_area(ring_m: Float[np.ndarray, "corners 3"]) -> Float[np.ndarray, " 3"]:
    # Relative to a corner: map coordinates would cost nine digits.
    local = ring_m - ring_m[0]
    return np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)


def _shape(ifc: IfcDocument, body: Any, kind: str, item: Any) -> Any:
    representation = ifc.make("IfcShapeRepresentation", body, "Body", kind, [item])
    return ifc.make("IfcProductDefinitionShape", None, None, [representation])
