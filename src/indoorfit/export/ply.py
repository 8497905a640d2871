"""The surface as PLY."""

from pathlib import Path

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import FitResult

from .facts import dimension_facts, face_facts, model_facts, one_line, room_facts
from .palette import face_colour


def write_mesh_ply(path: Path, result: FitResult) -> None:
    """Write all rooms as one triangle mesh: binary little endian, double coordinates, metres, scan frame.

    Every triangle has a colour and the property ``face``, a number that a comment line of the header
    explains (``comment face 0 {...}``, JSON in ASCII); rooms and dimensions are comments too. Triangles
    look into the room and share vertices within it. trimesh would write float32, which has no room for map
    coordinates, and neither comments nor properties.

    Raises:
        OutputError: the file cannot be written.
    """
    number = {face.id: k for k, face in enumerate(result.faces)}
    colours = np.array([face_colour(face) for face in result.faces], dtype=np.uint8).reshape(-1, 3)
    vertices = np.concatenate([np.empty((0, 3)), *(mesh.vertices_m for mesh in result.meshes)])
    rows = np.zeros(
        sum(len(mesh.triangles) for mesh in result.meshes),
        dtype=[("n", "u1"), ("corners", "<i4", 3), ("face", "<i4"), ("rgb", "u1", 3)],
    )
    n_rows = n_vertices = 0
    for mesh in result.meshes:
        block = rows[n_rows : n_rows + len(mesh.triangles)]
        block["corners"] = mesh.triangles + n_vertices
        block["face"] = [number[face] for face in mesh.face_ids]
        n_rows += len(mesh.triangles)
        n_vertices += len(mesh.vertices_m)
    rows["n"] = 3
    rows["rgb"] = colours[rows["face"]]
    header = "\n".join(_header(result, len(vertices), len(rows))) + "\n"
    replace_file(path, header.encode("ascii") + vertices.astype("<f8").tobytes() + rows.tobytes())


def _header(result: FitResult, n_vertices: int, n_triangles: int) -> list[str]:
    lines = ["ply", "format binary_little_endian 1.0", f"comment model {one_line(model_facts(result))}"]
    lines += [f"comment room {one_line(room_facts(room))}" for room in result.rooms]
    lines += [f"comment face {k} {one_line(face_facts(face))}" for k, face in enumerate(result.faces)]
    lines += [f"comment dimension {one_line(dimension_facts(d))}" for d in result.dimensions]
    lines += [f"element vertex {n_vertices}", *(f"property double {axis}" for axis in "xyz")]
    lines += [f"element face {n_triangles}", "property list uchar int vertex_indices", "property int face"]
    return [*lines, *(f"property uchar {name}" for name in ("red", "green", "blue")), "end_header"]
