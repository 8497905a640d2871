"""Wavefront OBJ with named groups."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from indoorfit.model import Face, FitResult, RoomMesh

from .files import replace_file
from .palette import face_colour, material_name


def write_obj(path: Path, result: FitResult) -> None:
    """Write the rooms as OBJ in the scan frame, metres, and the colours as an MTL file beside it.

    An object per room, a group per face, vertices shared within a room so that it stays watertight,
    one normal per face, into the room. Numbers have all digits of a float64.

    Raises:
        OutputError: a file cannot be written.
    """
    materials = path.with_suffix(".mtl")
    lines = [
        "# indoorfit: metres, scan frame, faces look into the room",
        f"mtllib {_name(materials.name)}",
    ]
    n_vertices = n_normals = 0
    for mesh in result.meshes:
        faces = [face for face in result.faces if face.id in set(mesh.face_ids)]
        lines.append(f"o {_name(mesh.room)}")
        lines += [f"v {_numbers(vertex)}" for vertex in mesh.vertices_m]
        lines += [f"vn {_numbers(face.normal)}" for face in faces]
        for k, face in enumerate(faces):
            lines += _group(mesh, face, n_vertices + 1, n_normals + k + 1)
        n_vertices += len(mesh.vertices_m)
        n_normals += len(faces)
    replace_file(materials, _materials(result).encode())
    replace_file(path, ("\n".join(lines) + "\n").encode())


def _group(mesh: RoomMesh, face: Face, first_vertex: int, normal: int) -> Iterator[str]:
    yield f"g {_name(face.id)}"
    yield f"usemtl {material_name(face)}"
    for triangle, name in zip(mesh.triangles.tolist(), mesh.face_ids, strict=True):
        if name == face.id:
            yield "f " + " ".join(f"{first_vertex + vertex}//{normal}" for vertex in triangle)


def _materials(result: FitResult) -> str:
    lines = ["# indoorfit"]
    for name, face in sorted({material_name(face): face for face in result.faces}.items()):
        colour = " ".join(f"{channel / 255.0:.6f}" for channel in face_colour(face))
        # Some readers darken a material whose diffuse colour is not given, so everything is said.
        lines += [f"newmtl {name}", f"Kd {colour}", "Ka 0 0 0", "Ks 0 0 0", "d 1", "illum 1"]
    return "\n".join(lines) + "\n"


def _numbers(vector: np.ndarray) -> str:
    return " ".join(repr(value + 0.0) for value in vector.tolist())


def _name(text: str) -> str:
    """OBJ separates names by white space."""
    return "_".join(text.split()) or "_"
