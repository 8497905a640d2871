"""3MF (core specification 1.3): the air of the rooms as printable bodies."""

import io
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

from indoorfit.files import replace_file
from indoorfit.model import FitResult, RoomMesh

from .facts import dimension_facts, face_facts, model_facts, one_line, room_facts
from .palette import face_colour
from .text import element, xml_bytes

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_MODEL_PART = "3D/3dmodel.model"
_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
  <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_RELATIONS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
  <Relationship Target="/{_MODEL_PART}" Id="rel0"
    Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""


def write_3mf(path: Path, result: FitResult) -> None:
    """Write one body per room, closed and outward as 3MF demands, in metres and in the Manhattan frame.

    Every face is a base material of its own, named by its id, so each triangle says which face it is of;
    what is known of faces, rooms and dimensions is metadata, as is the pose of the frame in the scan.
    trimesh would write every face as an open body, which 3MF forbids, with random ids and no materials.

    Raises:
        OutputError: the file cannot be written.
    """
    model = xml_bytes(_model(result))
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as package:
        for name, part in (
            ("[Content_Types].xml", _TYPES.encode()),
            ("_rels/.rels", _RELATIONS.encode()),
            (_MODEL_PART, model),
        ):
            # A date of its own, or the same model would give other bytes every time.
            package.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), part, zipfile.ZIP_DEFLATED)
    replace_file(path, content.getvalue())


def _model(result: FitResult) -> ET.Element:
    root = ET.Element(
        "model", {"unit": "meter", "xml:lang": "en-US", "xmlns": _CORE, "xmlns:indoorfit": "urn:indoorfit"}
    )
    element(root, "metadata", {"name": "Title"}, "indoorfit model: the air of the rooms")
    element(root, "metadata", {"name": "Application"}, "indoorfit")
    element(root, "metadata", {"name": "indoorfit:model"}, one_line(model_facts(result)))
    for name, facts in (
        ("rooms", [room_facts(room) for room in result.rooms]),
        ("faces", [face_facts(face) for face in result.faces]),
        ("dimensions", [dimension_facts(dimension) for dimension in result.dimensions]),
    ):
        text = "[" + ", ".join(one_line(item) for item in facts) + "]"
        element(root, "metadata", {"name": f"indoorfit:{name}"}, text)
    resources = element(root, "resources")
    materials = element(resources, "basematerials", {"id": "1"})
    for face in result.faces:
        colour = "#{:02X}{:02X}{:02X}".format(*face_colour(face))
        element(materials, "base", {"name": face.id, "displaycolor": colour})
    build = element(root, "build")
    number = {face.id: k for k, face in enumerate(result.faces)}
    for k, mesh in enumerate(result.meshes, start=2):
        _object(resources, result, mesh, str(k), number)
        element(build, "item", {"objectid": k})
    return root


def _object(
    resources: ET.Element, result: FitResult, mesh: RoomMesh, key: str, number: dict[str, int]
) -> None:
    first = number[mesh.face_ids[0]] if mesh.face_ids else 0
    body = element(
        resources, "object", {"id": key, "type": "model", "name": mesh.room, "pid": "1", "pindex": first}
    )
    body = element(body, "mesh")
    vertices = element(body, "vertices")
    for x, y, z in (result.frame.to_manhattan(mesh.vertices_m) + 0.0).tolist():
        element(vertices, "vertex", {"x": repr(x), "y": repr(y), "z": repr(z)})
    triangles = element(body, "triangles")
    for (a, b, c), face in zip(mesh.triangles.tolist(), mesh.face_ids, strict=True):
        # Inward triangles the other way round.
        element(triangles, "triangle", {"v1": a, "v2": c, "v3": b, "pid": "1", "p1": number[face]})
