"""glTF 2.0 in one binary file."""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from jaxtyping import Float
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from indoorfit.model import Face, FitResult

from .files import replace_file
from .palette import face_colour, linear_rgb, material_name
from .parts import FacePart, face_parts

_R_GLTF_MANHATTAN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""glTF is y up: Manhattan x, z, -y become x, y, z."""


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
    single-sided and look inward: a viewer that culls back faces shows a doll's house.

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

    def annotate(tree: dict[str, Any]) -> None:
        _annotate(tree, result)

    content = scene.export(
        file_type="glb", include_normals=True, unitize_normals=True, tree_postprocessor=annotate
    )
    assert isinstance(content, bytes)
    replace_file(path, content)


def _face_mesh(result: FitResult, part: FacePart) -> trimesh.Trimesh:
    face = part.face
    vertices = result.frame.to_manhattan(part.vertices_m) @ _R_GLTF_MANHATTAN.T
    normal = _R_GLTF_MANHATTAN @ result.frame.R_manhattan_scan @ face.normal
    return trimesh.Trimesh(
        vertices=vertices,
        faces=part.triangles,
        vertex_normals=np.tile(normal, (len(vertices), 1)),
        visual=TextureVisuals(material=PBRMaterial(name=material_name(face))),
        process=False,
    )


def _annotate(tree: dict[str, Any], result: FitResult) -> None:
    """Say what the file's coordinates are, and give the materials their colours in full precision."""
    tree["asset"]["extras"] = {
        "generator": "indoorfit",
        "unit": "m",
        "note": "p_scan = T_scan_gltf @ (p_gltf, 1); matrix rows, float64; faces look into the room",
        "T_scan_gltf": T_scan_gltf(result).tolist(),
    }
    faces: dict[str, Face] = {material_name(face): face for face in result.faces}
    for material in tree.get("materials", []):
        colour = linear_rgb(face_colour(faces[material["name"]]))
        material["pbrMetallicRoughness"] = {
            "baseColorFactor": [*colour, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.9,
        }
        material["doubleSided"] = False
