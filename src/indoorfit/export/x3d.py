"""X3D 3.3 in its XML encoding (ISO/IEC 19776-1)."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import TEXTURE_FOLDER, FitResult

from .facts import dimension_facts, face_facts, model_facts, one_line, room_facts
from .images import image_of, placement_of
from .palette import face_colour, material_name
from .parts import FacePart, face_parts
from .text import OWN, element, node_names, numbers, xml_bytes
from .view import view_from_above

_SCHEMA = "http://www.w3.org/2001/XMLSchema-instance"


def write_x3d(path: Path, result: FitResult) -> None:
    """Write the rooms as X3D: a Group per room, a Shape per face, metres, scan frame.

    What is known of the model, its rooms, faces and dimensions stands in Metadata nodes. Viewers compute
    in float32, so the coordinates are relative to the frame's origin and one Transform carries the offset
    with all its digits. Faces look into the room and are drawn from there only. Textures are in the folder
    ``textures`` beside it.

    Raises:
        OutputError: the file cannot be written.
    """
    root = ET.Element(
        "X3D",
        {
            "profile": "Immersive",
            "version": "3.3",
            "xmlns:xsd": _SCHEMA,
            "xsd:noNamespaceSchemaLocation": "http://www.web3d.org/specifications/x3d-3.3.xsd",
        },
    )
    head = element(root, "head")
    element(head, "unit", {"category": "length", "name": "metre", "conversionFactor": "1.0"})
    element(head, "meta", {"name": "generator", "content": "indoorfit"})
    element(head, "meta", {"name": "description", "content": "Rooms in metres, scan frame"})
    scene = element(root, "Scene")
    info = element(scene, "WorldInfo", {"title": "indoorfit model, metres, scan frame"})
    _metadata(info, "model", {key: _plain(value) for key, value in model_facts(result).items()})
    element(scene, "NavigationInfo", {"type": '"EXAMINE" "ANY"'})
    moved = element(
        scene, "Transform", {"DEF": "scan_frame", "translation": numbers(result.frame.origin_scan_m)}
    )
    dimensions = element(moved, "MetadataSet", {"name": "dimensions", "containerField": "metadata"})
    for dimension in result.dimensions:
        _metadata(dimensions, dimension.id, dimension_facts(dimension), "value")
    view = view_from_above(result)
    orientation = " ".join(f"{value:.6f}" for value in (*view.axis, view.angle_rad))
    position = " ".join(f"{value:.6f}" for value in view.position_m)
    element(
        moved,
        "Viewpoint",
        {"description": "From above", "position": position, "orientation": orientation},
    )
    _rooms(moved, result)
    replace_file(path, xml_bytes(root))


def _rooms(parent: ET.Element, result: FitResult) -> None:
    names = node_names(result)
    rooms = {room.id: room for room in result.rooms}
    defined: set[str] = set()
    for mesh in result.meshes:
        group = element(parent, "Group", {"DEF": names["room", mesh.room]})
        _metadata(group, "room", room_facts(rooms[mesh.room]))
        for part in face_parts(result, mesh):
            shape = element(group, "Shape", {"DEF": names["face", part.face.id]})
            _metadata(shape, "face", face_facts(part.face))
            _look(shape, result, part, defined)
            _geometry(shape, result, part)


def _look(shape: ET.Element, result: FitResult, part: FacePart, defined: set[str]) -> None:
    appearance = element(shape, "Appearance")
    name = f"{OWN}colour.{material_name(part.face)}"
    if name in defined:
        element(appearance, "Material", {"USE": name})
    else:
        defined.add(name)
        colour = " ".join(f"{channel / 255.0:.6f}" for channel in face_colour(part.face))
        element(appearance, "Material", {"DEF": name, "diffuseColor": colour, "ambientIntensity": "0.5"})
    image = image_of(result, part.face)
    if image is not None:
        url = f'"{TEXTURE_FOLDER}/{image.name}"'
        element(appearance, "ImageTexture", {"url": url, "repeatS": "false", "repeatT": "false"})


def _geometry(shape: ET.Element, result: FitResult, part: FacePart) -> None:
    triangles = " ".join(f"{a} {b} {c} -1" for a, b, c in part.triangles.tolist())
    faces = element(shape, "IndexedFaceSet", {"ccw": "true", "solid": "true", "coordIndex": triangles})
    element(faces, "Coordinate", {"point": numbers(part.vertices_m - result.frame.origin_scan_m)})
    placement = placement_of(result, part.face)
    if placement is not None:
        element(faces, "TextureCoordinate", {"point": numbers(placement.uv(part.vertices_m))})


def _metadata(
    parent: ET.Element, name: str, facts: Mapping[str, str | int | float], field: str = "metadata"
) -> None:
    """A MetadataSet with one typed entry per fact."""
    holder = element(parent, "MetadataSet", {"name": name, "containerField": field})
    for key, value in facts.items():
        if isinstance(value, str):
            # MFString: quotes and backslashes within a string are escaped by a backslash.
            tag, text = "MetadataString", '"{}"'.format(value.replace("\\", "\\\\").replace('"', '\\"'))
        else:
            tag = "MetadataInteger" if isinstance(value, int) else "MetadataDouble"
            text = numbers(np.array([value])) if isinstance(value, float) else str(value)
        element(holder, tag, {"name": key, "value": text, "containerField": "value"})


def _plain(value: object) -> str | int | float:
    return value if isinstance(value, str | int | float) else one_line({"value": value})
