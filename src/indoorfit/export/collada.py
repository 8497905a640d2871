"""COLLADA 1.4.1, for SketchUp and others."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from indoorfit.files import replace_file
from indoorfit.model import TEXTURE_FOLDER, Face, FitResult

from .facts import dimension_facts, face_facts, model_facts, one_line, room_facts
from .images import image_of, placement_of, textured_name
from .palette import face_colour
from .parts import FacePart, face_parts
from .text import OWN, element, node_names, numbers, xml_bytes

_DATE = "1970-01-01T00:00:00Z"
"""The schema demands a date of making; the model's own would give other bytes every time."""


def write_collada(path: Path, result: FitResult) -> None:
    """Write the rooms as COLLADA: a node per room, below it a node and a geometry per face, metres, z up.

    The coordinates are in the Manhattan frame: level, with the axes along the walls, near the origin, which
    is what drawing programs need; the pose in the scan is in ``extra`` of the scene. So are facts of faces,
    rooms and dimensions in ``extra`` of their nodes, ids included: names are NCNames here. Faces look into
    the room. Textures are in the folder ``textures`` beside it. pycollada would write seven digits.

    Raises:
        OutputError: the file cannot be written.
    """
    root = ET.Element(
        "COLLADA", {"xmlns": "http://www.collada.org/2005/11/COLLADASchema", "version": "1.4.1"}
    )
    asset = element(root, "asset")
    element(element(asset, "contributor"), "authoring_tool", text="indoorfit")
    element(asset, "created", text=_DATE)
    element(asset, "modified", text=_DATE)
    element(asset, "unit", {"name": "meter", "meter": "1"})
    element(asset, "up_axis", text="Z_UP")
    _materials(root, result)
    geometries = element(root, "library_geometries")
    scene = element(
        element(root, "library_visual_scenes"), "visual_scene", {"id": f"{OWN}scene", "name": "model"}
    )
    names = node_names(result)
    rooms = {room.id: room for room in result.rooms}
    for mesh in result.meshes:
        node = element(scene, "node", {"id": names["room", mesh.room], "name": names["room", mesh.room]})
        for part in face_parts(result, mesh):
            name = names["face", part.face.id]
            _geometry(geometries, result, part, name)
            _face_node(node, result, part.face, name)
        _extra(node, "room", one_line(room_facts(rooms[mesh.room])))
    lines = [one_line(dimension_facts(dimension)) for dimension in result.dimensions]
    _extra(scene, "model", one_line(model_facts(result)), "[" + ", ".join(lines) + "]")
    element(element(root, "scene"), "instance_visual_scene", {"url": f"#{OWN}scene"})
    replace_file(path, xml_bytes(root))


def _materials(root: ET.Element, result: FitResult) -> None:
    looks = sorted({textured_name(result, face): face for face in result.faces}.items())
    images = [(name, image.name) for name, face in looks if (image := image_of(result, face)) is not None]
    if images:
        library = element(root, "library_images")
        for name, file in images:
            image = element(library, "image", {"id": f"{OWN}image.{name}", "name": name})
            element(image, "init_from", text=f"{TEXTURE_FOLDER}/{file}")
    effects = element(root, "library_effects")
    materials = element(root, "library_materials")
    for name, face in looks:
        effect = element(effects, "effect", {"id": f"{OWN}effect.{name}"})
        profile = element(effect, "profile_COMMON")
        textured = image_of(result, face) is not None
        if textured:
            _sampler(profile, f"{OWN}image.{name}")
        lambert = element(element(profile, "technique", {"sid": "common"}), "lambert")
        diffuse = element(lambert, "diffuse")
        if textured:
            element(diffuse, "texture", {"texture": "sampler", "texcoord": "UV"})
        else:
            colour = " ".join(f"{channel / 255.0:.6f}" for channel in face_colour(face))
            element(diffuse, "color", text=f"{colour} 1")
        material = element(materials, "material", {"id": f"{OWN}material.{name}", "name": name})
        element(material, "instance_effect", {"url": f"#{OWN}effect.{name}"})


def _sampler(profile: ET.Element, image: str) -> None:
    """An image as something that a colour can be taken from."""
    surface = element(element(profile, "newparam", {"sid": "surface"}), "surface", {"type": "2D"})
    element(surface, "init_from", text=image)
    sampler = element(element(profile, "newparam", {"sid": "sampler"}), "sampler2D")
    element(sampler, "source", text="surface")
    # Nothing lies beyond an image's edge.
    element(sampler, "wrap_s", text="CLAMP")
    element(sampler, "wrap_t", text="CLAMP")


def _geometry(parent: ET.Element, result: FitResult, part: FacePart, name: str) -> None:
    key = f"{OWN}mesh.{name}"
    geometry = element(parent, "geometry", {"id": key, "name": name})
    mesh = element(geometry, "mesh")
    normal = np.round(result.frame.R_manhattan_scan @ part.face.normal, 12)
    _source(mesh, f"{key}.positions", result.frame.to_manhattan(part.vertices_m), "XYZ")
    _source(mesh, f"{key}.normals", normal[None], "XYZ")
    placement = placement_of(result, part.face)
    if placement is not None:
        _source(mesh, f"{key}.uv", placement.uv(part.vertices_m), "ST")
    vertices = element(mesh, "vertices", {"id": f"{key}.vertices"})
    element(vertices, "input", {"semantic": "POSITION", "source": f"#{key}.positions"})
    triangles = element(mesh, "triangles", {"count": len(part.triangles), "material": "surface"})
    for offset, (semantic, source) in enumerate((("VERTEX", "vertices"), ("NORMAL", "normals"))):
        attributes = {"semantic": semantic, "source": f"#{key}.{source}", "offset": offset}
        element(triangles, "input", attributes)
    if placement is not None:
        # Numbered as the corners are.
        attributes = {"semantic": "TEXCOORD", "source": f"#{key}.uv", "offset": 0, "set": 0}
        element(triangles, "input", attributes)
    element(triangles, "p", text=" ".join(f"{corner} 0" for corner in part.triangles.ravel().tolist()))


def _source(mesh: ET.Element, key: str, rows: np.ndarray, axes: str) -> None:
    source = element(mesh, "source", {"id": key})
    element(source, "float_array", {"id": f"{key}.array", "count": rows.size}, numbers(rows))
    accessor = element(
        element(source, "technique_common"),
        "accessor",
        {"source": f"#{key}.array", "count": len(rows), "stride": len(axes)},
    )
    for axis in axes:
        element(accessor, "param", {"name": axis, "type": "float"})


def _face_node(parent: ET.Element, result: FitResult, face: Face, key: str) -> None:
    node = element(parent, "node", {"id": key, "name": key})
    instance = element(node, "instance_geometry", {"url": f"#{OWN}mesh.{key}"})
    binding = element(element(instance, "bind_material"), "technique_common")
    target = f"#{OWN}material.{textured_name(result, face)}"
    material = element(binding, "instance_material", {"symbol": "surface", "target": target})
    if placement_of(result, face) is not None:
        attributes = {"semantic": "UV", "input_semantic": "TEXCOORD", "input_set": 0}
        element(material, "bind_vertex_input", attributes)
    _extra(node, "face", one_line(face_facts(face)))


def _extra(parent: ET.Element, kind: str, facts: str, dimensions: str = "") -> None:
    technique = element(element(parent, "extra", {"type": kind}), "technique", {"profile": "indoorfit"})
    element(technique, kind, text=facts)
    if dimensions:
        element(technique, "dimensions", text=dimensions)
