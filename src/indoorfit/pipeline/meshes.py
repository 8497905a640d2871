"""The meshes of a model that was read from a file: model.json holds the cubes, not the triangles."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NoReturn

import numpy as np

from indoorfit.errors import InputError
from indoorfit.model import Face, FitResult, Frame, Polygon, Room, RoomMesh, RoomSolid
from indoorfit.solid import face_polygons, subtract_cubes

_TOLERANCE_M = 1e-6
"""How far a corner in the file may be from the solid's own. Written coordinates are exact to rounding (1e-9 m
at map distance); a micrometre is what the solid merges at its coarsest."""


def with_meshes(result: FitResult, name: str = "model.json") -> FitResult:
    """The same model with the triangles that follow from its cubes and planes.

    Args:
        result: as `io.read_model_json` gives it.
        name: of the file, for messages.

    Raises:
        InputError: the faces in the file are not those of its cubes, or a room is not closed.
    """
    cubes = {cube.id: cube for cube in result.shape.rooms}
    meshes = []
    for room in result.rooms:
        if room.cube not in cubes:
            _fail(name, f"{room.cube!r} of {room.id!r} is no cube without a parent")
        solid = subtract_cubes(result.shape, cubes[room.cube])
        if not solid.is_closed:
            _fail(name, f"the cubes of {room.id!r} make no closed body")
        faces = [face for face in result.faces if face.room == room.id]
        meshes.append(_mesh(result.frame, room, solid, faces, name))
    return replace(result, meshes=tuple(meshes))


def _mesh(frame: Frame, room: Room, solid: RoomSolid, faces: Sequence[Face], name: str) -> RoomMesh:
    ids = [""] * len(solid.triangles)
    left = list(faces)
    for polygon in face_polygons(solid):
        found = next((face for face in left if _is_same(frame, face, polygon)), None)
        if found is None:
            _fail(name, f"a face of {room.id!r} that its cubes have is missing or has other corners")
        left.remove(found)
        for triangle in polygon.triangles.tolist():
            ids[triangle] = found.id
    if left:
        _fail(name, f"the face {left[0].id!r} does not follow from the cubes")
    return RoomMesh(room.id, frame.to_scan(solid.vertices_m), solid.triangles[:, ::-1].copy(), tuple(ids))


def _is_same(frame: Frame, face: Face, polygon: Polygon) -> bool:
    if face.plane != polygon.plane or len(face.rings_m) != len(polygon.rings_m):
        return False
    gaps = np.linalg.norm(frame.to_manhattan(face.rings_m[0])[:, None] - polygon.rings_m[0][None], axis=-1)
    return float(max(gaps.min(axis=0).max(), gaps.min(axis=1).max())) < _TOLERANCE_M


def _fail(name: str, found: str) -> NoReturn:
    raise InputError(
        f"{name}: {found}; the faces of a model are those of its cubes. Fix: fit the scan again, or repair "
        "the file."
    )
