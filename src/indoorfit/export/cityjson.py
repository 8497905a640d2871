"""CityJSON 2.0 (OGC 20-072r5)."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import Face, FitResult, RoomMesh

from .facts import dimension_facts, face_facts, model_facts, room_facts
from .levelled import LevelledFrame, levelled
from .rings import closed_rings

_LEVEL_SURFACES = {"floor": "FloorSurface", "ceiling": "CeilingSurface"}
"""Everything upright is an InteriorWallSurface."""

_LOD = "3"
"""Of the rooms: interiors with recesses and pillars as they were measured."""

_SCALE_M = 1e-7
"""Vertices are whole multiples of this. A volume moves by half of it times the surface: 2e-7 of a room at
the most; and 200 m still fit the 32 bits that some readers have."""


def write_cityjson(path: Path, result: FitResult) -> None:
    """Write a Building without an outside, and in it a BuildingRoom per room as a closed Solid.

    Every face is one semantic surface with its id, status and standard uncertainty as attributes; area,
    volume, perimeter and dimensions with their intervals are attributes of the room. Metres, in the scan's
    coordinates turned level (z is up in CityJSON): map coordinates stay, carried by ``transform``. The
    reference system is not known and not stated.

    Raises:
        OutputError: the file cannot be written.
    """
    frame = levelled(result.frame)
    vertices: dict[tuple[int, ...], int] = {}
    building, *keys = _keys("building", [mesh.room for mesh in result.meshes])
    objects: dict[str, Any] = {
        building: {
            "type": "Building",
            "attributes": {
                **model_facts(result),
                "R_scan_levelled": frame.R_scan_levelled.tolist(),
                "frame_note": "p_scan = R_scan_levelled @ (p_cityjson - origin_scan_m) + origin_scan_m",
                "warnings": [{"code": note.code, "message": note.message} for note in result.notes],
            },
            "children": keys,
        }
    }
    for key, mesh in zip(keys, result.meshes, strict=True):
        objects[key] = {
            "type": "BuildingRoom",
            "attributes": _room_attributes(result, mesh.room),
            "parents": [building],
            "geometry": [_solid(result, mesh, frame, vertices)],
        }
    translate = (result.frame.origin_scan_m + 0.0).tolist()
    document = {
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [_SCALE_M] * 3, "translate": translate},
        "metadata": {"title": "indoorfit model", "geographicalExtent": _extent(vertices, translate)},
        "CityObjects": objects,
        "vertices": [list(vertex) for vertex in vertices],
    }
    replace_file(path, (json.dumps(document, ensure_ascii=False, allow_nan=False) + "\n").encode())


def _keys(building: str, rooms: list[str]) -> list[str]:
    """A key for the building that no room has, and the rooms' own."""
    while building in rooms:
        building += "_"
    return [building, *rooms]


def _room_attributes(result: FitResult, room: str) -> dict[str, Any]:
    facts = next(room_facts(r) for r in result.rooms if r.id == room)
    dimensions = [dimension_facts(d) for d in result.dimensions if d.room == room]
    return {**facts, "dimensions": dimensions}


def _solid(
    result: FitResult, mesh: RoomMesh, frame: LevelledFrame, vertices: dict[tuple[int, ...], int]
) -> dict[str, Any]:
    local = result.frame.to_manhattan(mesh.vertices_m) @ frame.R_levelled_manhattan.T
    rows = np.round(local / _SCALE_M).astype(np.int64).tolist()
    names = set(mesh.face_ids)
    faces = [face for face in result.faces if face.id in names and face.room == mesh.room]
    shell = []
    for face in faces:
        # Ours look into the room; a solid's look out of it.
        rings = [ring[::-1].tolist() for ring in closed_rings(result, mesh, face)]
        shell.append([[_number(vertices, rows[k]) for k in ring] for ring in rings])
    return {
        "type": "Solid",
        "lod": _LOD,
        "boundaries": [shell],
        "semantics": {
            "surfaces": [{"type": _surface(face), **face_facts(face)} for face in faces],
            "values": [list(range(len(faces)))],
        },
    }


def _surface(face: Face) -> str:
    return _LEVEL_SURFACES.get(face.kind, "InteriorWallSurface")


def _number(vertices: dict[tuple[int, ...], int], row: list[int]) -> int:
    return vertices.setdefault(tuple(row), len(vertices))


def _extent(vertices: dict[tuple[int, ...], int], translate: list[float]) -> list[float]:
    corners = np.array(list(vertices), dtype=np.float64).reshape(-1, 3) * _SCALE_M + translate
    return [*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist()]
