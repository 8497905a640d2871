"""The model as the 3D view of the page needs it: y up, metres, small numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.export import FacePart, face_colour, face_parts, image_of, placement_of, quantity_text
from indoorfit.model import Dimension, Face, FitResult

from .small_images import data_urls
from .table import what_is_measured

_R_VIEW_MANHATTAN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""y up, as WebGL viewers have it."""

_SHADE = {0: 0.9, 1: 0.8, 2: 1.0}
"""Plain faces by axis: edges between walls stay visible without a lamp."""


def scene_data(result: FitResult) -> dict[str, Any]:
    """Faces with their triangles, outlines and images, and dimensions with their ends, as plain values.

    Lengths are metres, rounded to a tenth of a millimetre, which no screen resolves.
    """
    several = len(result.rooms) > 1
    return {
        "faces": [_face(result, part) for mesh in result.meshes for part in face_parts(result, mesh)],
        "dimensions": [_dimension(result, d, several) for d in result.dimensions],
        "images": {} if result.textures is None else data_urls(result.textures),
        "start": _start(result),
    }


def _face(result: FitResult, part: FacePart) -> dict[str, Any]:
    face, placement = part.face, placement_of(result, part.face)
    corners = [_view(result, ring) for ring in face.rings_m]
    data: dict[str, Any] = {
        "id": face.id,
        "kind": face.kind,
        "about": _about(face),
        "colour": _colour(result, face),
        "position": _view(result, part.vertices_m).ravel().tolist(),
        "index": part.triangles.ravel().tolist(),
        "edges": [ring.tolist() for ring in corners],
        "normal": _rounded(_R_VIEW_MANHATTAN @ result.frame.R_manhattan_scan @ face.normal).tolist(),
        "centre": _rounded(0.5 * (corners[0].min(axis=0) + corners[0].max(axis=0))).tolist(),
    }
    image = image_of(result, face)
    if placement is not None and image is not None:
        data["image"] = image.name
        data["uv"] = np.round(placement.uv(part.vertices_m), 5).ravel().tolist()
    return data


def _about(face: Face) -> str:
    if face.status == "inferred":
        return f"{face.id} of {face.room}: inferred, no points of its own."
    return (
        f"{face.id} of {face.room}: {face.n_points} points on {100.0 * face.coverage:.0f} % of its area, "
        f"spread {1e3 * face.rms_m:.1f} mm, position known to {1e3 * face.offset_std_m:.2g} mm "
        "(standard uncertainty)."
    )


def _colour(result: FitResult, face: Face) -> str:
    shade = _SHADE[result.shape.planes[face.plane].axis]
    return "#" + "".join(f"{round(shade * channel):02x}" for channel in face_colour(face))


def _dimension(result: FitResult, dimension: Dimension, several: bool) -> dict[str, Any]:
    text = quantity_text(dimension.quantity)
    ends = _view(result, np.stack([dimension.from_m, dimension.to_m]))
    return {
        "id": dimension.id,
        "what": what_is_measured(dimension, several),
        "text": text.together,
        "faces": list(dimension.faces),
        "from": ends[0].tolist(),
        "to": ends[1].tolist(),
        "inferred": dimension.status == "inferred",
    }


def _start(result: FitResult) -> Sequence[float]:
    """Where a walk begins: on the largest triangle of all floors, which is inside a room in any plan."""
    best, largest_m2 = [0.0, 0.0, 0.0], 0.0
    for mesh in result.meshes:
        for part in face_parts(result, mesh):
            if part.face.kind == "floor":
                triangles = part.vertices_m[part.triangles]
                doubled = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
                areas_m2 = 0.5 * np.linalg.norm(doubled, axis=1)
                k = int(np.argmax(areas_m2))
                if areas_m2[k] > largest_m2:
                    largest_m2 = float(areas_m2[k])
                    best = _view(result, triangles[k]).mean(axis=0).round(4).tolist()
    return best


def _view(result: FitResult, points_m: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    return _rounded(result.frame.to_manhattan(points_m) @ _R_VIEW_MANHATTAN.T)


def _rounded(values: np.ndarray) -> np.ndarray:
    # Adding zero turns -0.0 into 0.0, which would otherwise depend on the order of a sum.
    return np.round(values, 4) + 0.0
