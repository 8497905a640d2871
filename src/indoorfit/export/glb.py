"""glTF 2.0 in one binary file."""

from collections.abc import MutableMapping
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from jaxtyping import Float
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from indoorfit.files import replace_file
from indoorfit.model import Face, FitResult, TextureSet

from .facts import dimension_facts, face_facts, model_facts, room_facts
from .images import image_of, placement_of, textured_name
from .palette import face_colour, linear_rgb
from .parts import FacePart, face_parts

_R_GLTF_MANHATTAN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""glTF is y up: Manhattan x, z, -y become x, y, z."""

_WEBP = "EXT_texture_webp"

_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
"""What a buffer view holds, attributes of vertices or indices (glTF 2.0, 5.11.5); trimesh leaves it open."""


def T_scan_gltf(result: FitResult) -> Float[np.ndarray, "4 4"]:
    """The pose of the file's coordinates: ``p_scan = T_scan_gltf @ (p_gltf, 1)``, metres, float64."""
    transform = np.eye(4)
    transform[:3, :3] = result.frame.R_manhattan_scan.T @ _R_GLTF_MANHATTAN.T
    transform[:3, 3] = result.frame.origin_scan_m
    return transform


def write_glb(path: Path, result: FitResult) -> None:
    """Write the rooms as a GLB: a node per room, below it a mesh node per face, named by their ids.

    glTF holds float32, which has no room for map coordinates. So the vertices are in the Manhattan
    frame, turned y up, and ``asset.extras.T_scan_gltf`` leads back to the scan frame. Faces are
    single-sided and look inward: a viewer that culls back faces shows a doll's house. Textures are in
    the file; their alpha marks what was not seen and is not used for drawing (alphaMode OPAQUE).

    Raises:
        OutputError: the file cannot be written.
    """
    scene = trimesh.Scene(base_frame="model")
    for mesh in result.meshes:
        # trimesh's helper for an empty node: a frame that hangs below the root.
        scene.graph.update(frame_from="model", frame_to=mesh.room)
        for part in face_parts(result, mesh):
            scene.add_geometry(
                _face_mesh(result, part),
                node_name=part.face.id,
                geom_name=part.face.id,
                parent_node_name=mesh.room,
            )

    def embed(buffers: MutableMapping[Any, bytes], tree: dict[str, Any]) -> None:
        if result.textures is not None:
            _embed_images(buffers, tree, result.textures)

    def annotate(tree: dict[str, Any]) -> None:
        _annotate(tree, result)
        _target(tree)
        _describe(tree, result)

    content = scene.export(
        file_type="glb",
        include_normals=True,
        unitize_normals=True,
        buffer_postprocessor=embed,
        tree_postprocessor=annotate,
    )
    assert isinstance(content, bytes)
    replace_file(path, content)


def _face_mesh(result: FitResult, part: FacePart) -> trimesh.Trimesh:
    face = part.face
    vertices = result.frame.to_manhattan(part.vertices_m) @ _R_GLTF_MANHATTAN.T
    normal = _R_GLTF_MANHATTAN @ result.frame.R_manhattan_scan @ face.normal
    placement = placement_of(result, face)
    uv = None if placement is None else placement.uv(part.vertices_m)
    return trimesh.Trimesh(
        vertices=vertices,
        faces=part.triangles,
        vertex_normals=np.tile(normal, (len(vertices), 1)),
        visual=TextureVisuals(uv=uv, material=PBRMaterial(name=textured_name(result, face))),
        process=False,
    )


def _embed_images(buffers: MutableMapping[Any, bytes], tree: dict[str, Any], textures: TextureSet) -> None:
    """Put the files' own bytes into the buffer; handing pictures to trimesh would encode them again."""
    # Edges repeat nothing and minified images are averaged: what every viewer can do.
    tree["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}]
    for k, image in enumerate(textures.images):
        key = f"image {image.name}"
        # Views start at whole words; `_annotate` gives the view its exact length back.
        buffers[key] = image.content + b"\0" * (-len(image.content) % 4)
        view = list(buffers).index(key)
        tree["images"].append({"name": image.name, "mimeType": image.media_type, "bufferView": view})
        source: dict[str, Any] = {"source": k}
        if image.format == "webp":
            source = {"extensions": {_WEBP: source}}
            tree["extensionsUsed"] = tree["extensionsRequired"] = [_WEBP]
        tree["textures"].append({"sampler": 0, **source})


def _target(tree: dict[str, Any]) -> None:
    """Say of every buffer view what it is for, so that viewers can hand it on as it is."""
    for mesh in tree["meshes"]:
        for part in mesh["primitives"]:
            uses = [(number, _ARRAY_BUFFER) for number in part["attributes"].values()]
            for number, target in [*uses, (part["indices"], _ELEMENT_ARRAY_BUFFER)]:
                tree["bufferViews"][tree["accessors"][number]["bufferView"]]["target"] = target


def _describe(tree: dict[str, Any], result: FitResult) -> None:
    """What is known of model, rooms, faces and dimensions, as extras of the scene and the nodes."""
    rooms = {room.id: room_facts(room) for room in result.rooms}
    faces = {face.id: face_facts(face) for face in result.faces}
    for node in tree["nodes"]:
        facts = faces if "mesh" in node else rooms
        if node.get("name") in facts:
            node["extras"] = facts[node["name"]]
    dimensions = [dimension_facts(dimension) for dimension in result.dimensions]
    tree["scenes"][0]["extras"] = {"model": model_facts(result), "dimensions": dimensions}


def _annotate(tree: dict[str, Any], result: FitResult) -> None:
    """Say what the file's coordinates are, and give the materials their colours in full precision."""
    tree["asset"]["extras"] = {
        "generator": "indoorfit",
        "unit": "m",
        "note": "p_scan = T_scan_gltf @ (p_gltf, 1); matrix rows, float64; faces look into the room",
        "T_scan_gltf": T_scan_gltf(result).tolist(),
    }
    images = () if result.textures is None else result.textures.images
    number = {image.name: k for k, image in enumerate(images)}
    for image, entry in zip(images, tree.get("images", []), strict=True):
        tree["bufferViews"][entry["bufferView"]]["byteLength"] = len(image.content)
    faces: dict[str, Face] = {textured_name(result, face): face for face in result.faces}
    for material in tree.get("materials", []):
        face = faces[material["name"]]
        image = image_of(result, face)
        if image is None:
            look: dict[str, Any] = {"baseColorFactor": [*linear_rgb(face_colour(face)), 1.0]}
        else:
            look = {"baseColorTexture": {"index": number[image.name]}}
        material["pbrMetallicRoughness"] = {**look, "metallicFactor": 0.0, "roughnessFactor": 0.9}
        material["doubleSided"] = False
