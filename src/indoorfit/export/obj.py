"""Wavefront OBJ with named groups."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import TEXTURE_FOLDER, Face, FitResult, RoomMesh

from .images import image_of, placement_of, textured_name
from .palette import face_colour
from .text import node_names, numbers


def write_obj(path: Path, result: FitResult) -> None:
    """Write the rooms as OBJ in the scan frame, metres, and the colours as an MTL file beside it.

    An object per room, a group per face, vertices shared within a room so that it stays watertight,
    one normal per face, into the room. Numbers have all digits of a float64. Textures go to the folder
    ``textures`` beside the file.

    Raises:
        OutputError: a file cannot be written.
    """
    # OBJ separates names by white space, so the file that is named has none.
    materials = path.with_name("_".join(path.stem.split()) + ".mtl")
    names = node_names(result)
    lines = [
        "# indoorfit: metres, scan frame, faces look into the room",
        f"mtllib {materials.name}",
    ]
    n_vertices = n_normals = n_uv = 0
    for mesh in result.meshes:
        faces = [face for face in result.faces if face.id in set(mesh.face_ids)]
        lines.append(f"o {names['room', mesh.room]}")
        lines += [f"v {numbers(vertex)}" for vertex in mesh.vertices_m]
        lines += [f"vn {numbers(face.normal)}" for face in faces]
        for k, face in enumerate(faces):
            name = names["face", face.id]
            group = _group(result, mesh, face, name, (n_vertices + 1, n_uv + 1, n_normals + k + 1))
            n_uv += len(group.uv_lines)
            lines += [*group.uv_lines, *group.lines]
        n_vertices += len(mesh.vertices_m)
        n_normals += len(faces)
    replace_file(materials, _materials(result).encode())
    replace_file(path, ("\n".join(lines) + "\n").encode())


@dataclass(frozen=True)
class _Group:
    uv_lines: list[str]
    lines: list[str]


def _group(result: FitResult, mesh: RoomMesh, face: Face, name: str, first: tuple[int, int, int]) -> _Group:
    """One face; `first` numbers its room's first vertex, its own first texture vertex and its normal."""
    chosen = mesh.triangles[np.array(mesh.face_ids) == face.id]
    used, corners = np.unique(chosen, return_inverse=True)
    placement = placement_of(result, face)
    uv_lines = []
    if placement is not None:
        uv_lines = [f"vt {numbers(uv)}" for uv in placement.uv(mesh.vertices_m[used])]
    lines = [f"g {name}", f"usemtl {textured_name(result, face)}"]
    for triangle, places in zip(chosen.tolist(), corners.reshape(-1, 3).tolist(), strict=True):
        texts = [
            f"{first[0] + vertex}/{first[1] + place if uv_lines else ''}/{first[2]}"
            for vertex, place in zip(triangle, places, strict=True)
        ]
        lines.append("f " + " ".join(texts))
    return _Group(uv_lines, lines)


def _materials(result: FitResult) -> str:
    lines = ["# indoorfit"]
    for name, face in sorted({textured_name(result, face): face for face in result.faces}.items()):
        image = image_of(result, face)
        # A texture is multiplied with the diffuse colour: white leaves it as it is.
        rgb = face_colour(face) if image is None else (255, 255, 255)
        colour = " ".join(f"{channel / 255.0:.6f}" for channel in rgb)
        # Some readers darken a material whose diffuse colour is not given, so everything is said.
        lines += [f"newmtl {name}", f"Kd {colour}", "Ka 0 0 0", "Ks 0 0 0", "d 1", "illum 1"]
        if image is not None:
            lines.append(f"map_Kd {TEXTURE_FOLDER}/{image.name}")
    return "\n".join(lines) + "\n"
