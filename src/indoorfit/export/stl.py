"""The air of the rooms as STL."""

import re
from pathlib import Path

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import FitResult

from .parts import FacePart, face_parts
from .text import numbers, safe_names

_WORDS = re.compile(r"(?<=[sfnolv])(?=olid|acet|ormal|uter|oop|ertex)", re.IGNORECASE)
"""Within the format's own words, which readers look for anywhere in a line."""


def write_stl(path: Path, result: FitResult) -> None:
    """Write the rooms as ASCII STL, one ``solid`` per face, named by its id.

    STL knows no unit and no colour; readers hold 32 bits. So the coordinates are metres in the Manhattan
    frame (level, axes along the walls), and the name line of every solid gives its origin in the scan.
    Triangles look outward, as of a body made of the room's air. ASCII, because the binary form has no names.

    Raises:
        OutputError: the file cannot be written.
    """
    names = safe_names(name for face in result.faces for name in (face.id, face.room))
    origin = ",".join(repr(value + 0.0) for value in result.frame.origin_scan_m.tolist())
    lines: list[str] = []
    for mesh in result.meshes:
        for part in face_parts(result, mesh):
            name, room = (_WORDS.sub("_", names[text]) for text in (part.face.id, part.face.room))
            title = f"{name} room={room} status={part.face.status} unit=m origin_scan={origin}"
            lines += [f"solid {title}", *_triangles(result, part), f"endsolid {name}"]
    replace_file(path, ("\n".join(lines) + "\n").encode("ascii"))


def _triangles(result: FitResult, part: FacePart) -> list[str]:
    vertices = [numbers(vertex) for vertex in result.frame.to_manhattan(part.vertices_m)]
    normal = numbers(np.round(-(result.frame.R_manhattan_scan @ part.face.normal), 12))
    lines = []
    for a, b, c in part.triangles.tolist():
        lines += [f"facet normal {normal}", " outer loop"]
        # Inward triangles the other way round.
        lines += [f"  vertex {vertices[corner]}" for corner in (a, c, b)]
        lines += [" endloop", "endfacet"]
    return lines
