"""VRML97 (ISO/IEC 14772-1)."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import TEXTURE_FOLDER, FitResult

from .images import image_of, placement_of
from .numbers import quantity_text
from .palette import face_colour, material_name
from .parts import FacePart, face_parts
from .text import node_names, numbers
from .view import view_from_above


def write_vrml(path: Path, result: FitResult) -> None:
    """Write the rooms as VRML97: one named Shape per face, looking inward, metres, scan frame.

    Viewers compute in float32, so the coordinates are relative to the frame's origin and one
    Transform carries the offset with all its digits. Textures are in the folder ``textures`` beside it.

    Raises:
        OutputError: the file cannot be written.
    """
    lines = ["#VRML V2.0 utf8", *_world_info(result), 'NavigationInfo { type [ "EXAMINE", "ANY" ] }']
    lines += ["DEF scan_frame Transform {", f"  translation {numbers(result.frame.origin_scan_m)}"]
    lines += ["  children [", _viewpoint(result)]
    names = node_names(result, dots=False)
    defined: set[str] = set()
    for mesh in result.meshes:
        lines += [f"    DEF {names['room', mesh.room]} Group {{ children ["]
        for part in face_parts(result, mesh):
            lines += _shape(result, part, names["face", part.face.id], defined)
        lines += ["    ] }"]
    lines += ["  ]", "}"]
    replace_file(path, ("\n".join(lines) + "\n").encode())


def _world_info(result: FitResult) -> Iterator[str]:
    yield "WorldInfo {"
    yield f"  title {_string(f'indoorfit model, {len(result.rooms)} room(s), metres, scan frame')}"
    yield "  info ["
    for d in result.dimensions:
        text = quantity_text(d.quantity)
        ends = f"{d.wall or d.kind}, {d.faces[0]} to {d.faces[1]}"
        span = f"{text.low} to {text.high} at {100 * d.quantity.interval.level:g} %"
        line = f"{d.id}: {ends}: {text.value} m, {span}, {d.status}"
        yield f"    {_string(line)}"
    yield "  ]"
    yield "}"


def _viewpoint(result: FitResult) -> str:
    view = view_from_above(result)
    turn = np.append(view.axis, view.angle_rad)
    pose = f"position {_rounded(view.position_m)} orientation {_rounded(turn)}"
    return f'    Viewpoint {{ description "From above" {pose} }}'


def _shape(result: FitResult, part: FacePart, name: str, defined: set[str]) -> Iterator[str]:
    look = material_name(part.face)
    if look in defined:
        material = f"USE colour_{look}"
    else:
        defined.add(look)
        colour = " ".join(f"{channel / 255.0:.6f}" for channel in face_colour(part.face))
        material = f"DEF colour_{look} Material {{ diffuseColor {colour} ambientIntensity 0.5 }}"
    points = part.vertices_m - result.frame.origin_scan_m
    image, placement = image_of(result, part.face), placement_of(result, part.face)
    texture = ""
    if image is not None:
        url = _string(f"{TEXTURE_FOLDER}/{image.name}")
        texture = f" texture ImageTexture {{ url [ {url} ] repeatS FALSE repeatT FALSE }}"
    yield f"      DEF {name} Shape {{"
    yield f"        appearance Appearance {{ material {material}{texture} }}"
    yield "        geometry IndexedFaceSet {"
    yield "          ccw TRUE solid TRUE convex TRUE"
    yield "          coord Coordinate { point ["
    yield from (f"            {numbers(point)}," for point in points)
    yield "          ] }"
    if placement is not None:
        yield "          texCoord TextureCoordinate { point ["
        yield from (f"            {numbers(uv)}," for uv in placement.uv(part.vertices_m))
        yield "          ] }"
    yield "          coordIndex ["
    yield from (f"            {a}, {b}, {c}, -1," for a, b, c in part.triangles.tolist())
    yield "          ]"
    yield "        }"
    yield "      }"


def _rounded(vector: np.ndarray) -> str:
    return " ".join(f"{value + 0.0:.6f}" for value in vector.tolist())


def _string(text: str) -> str:
    escaped = " ".join(text.split()).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
