"""A doll's-house picture of the model: seen from above, without ceiling and without near walls."""

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from PIL import Image

from indoorfit.export import face_colour
from indoorfit.files import replace_file
from indoorfit.model import FitResult

_OVERSAMPLING = 2
"""Samples per pixel and direction: smooth edges without a line drawer."""

_BACKGROUND = (255, 255, 255)
_EDGE = (58, 62, 66)
_MARGIN = 0.06


@dataclass(frozen=True)
class View:
    """Where the observer stands, and how large the picture is."""

    azimuth_rad: float = -2.1
    """Direction from the model to the observer, from Manhattan x towards y; left and in front of the
    room, so that two walls are seen from inside and none is seen edge-on."""
    elevation_rad: float = 0.95
    """Height of the observer above the horizon: high enough to see the floor behind the notches."""
    width_px: int = 1400
    height_px: int = 1000


def render_png(path: Path, result: FitResult, view: View | None = None) -> None:
    """Write an orthographic picture of the rooms as PNG.

    Faces that look away from the observer and all ceilings are left out, so one looks over the near
    walls into the rooms.

    Raises:
        OutputError: the file cannot be written.
    """
    content = io.BytesIO()
    render(result, view or View()).save(content, "PNG", optimize=False)
    replace_file(path, content.getvalue())


def render(result: FitResult, view: View) -> Image.Image:
    """The picture that `render_png` writes."""
    triangles_m, owners = _visible_triangles(result)
    axes = _camera_axes(view)
    seen = triangles_m @ axes.T
    pixels = np.array([view.width_px, view.height_px]) * _OVERSAMPLING
    flat = seen.reshape(-1, 3)[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = float(np.min(pixels * (1.0 - 2.0 * _MARGIN) / (high - low)))
    seen[..., :2] = (seen[..., :2] - 0.5 * (low + high)) * scale * [1.0, -1.0] + 0.5 * pixels
    depth = np.full(pixels[::-1], -np.inf, np.float32)
    face_of = np.full(pixels[::-1], -1, np.int16)
    for triangle, owner in zip(seen, owners.tolist(), strict=True):
        _fill(depth, face_of, triangle, owner)
    colours = np.array([*_shades(result, view), _BACKGROUND], np.uint8)
    image = colours[face_of]
    image[_edges(face_of)] = _EDGE
    size = (view.width_px, view.height_px)
    return Image.fromarray(image).resize(size, Image.Resampling.BOX)


def _visible_triangles(result: FitResult) -> tuple[Float[np.ndarray, "triangles 3 3"], Int[np.ndarray, " n"]]:
    """Corners in the Manhattan frame and the index of the face, without ceilings and what hangs from them."""
    index = {face.id: k for k, face in enumerate(result.faces)}
    corners, owners = [], []
    for mesh in result.meshes:
        corners.append(result.frame.to_manhattan(mesh.vertices_m)[mesh.triangles])
        owners += [index[name] for name in mesh.face_ids]
    everything = np.concatenate(corners)
    middle = 0.5 * (everything[:, :, 2].min() + everything[:, :, 2].max())
    overhead = everything[:, :, 2].mean(axis=1) > middle
    kinds = np.array([result.faces[owner].kind for owner in owners])
    kept = (kinds != "ceiling") & ~((kinds == "step") & overhead)
    return everything[kept], np.array(owners)[kept]


def _camera_axes(view: View) -> Float[np.ndarray, "3 3"]:
    """Rows: right, up, and towards the observer, in the Manhattan frame."""
    cos_e, sin_e = np.cos(view.elevation_rad), np.sin(view.elevation_rad)
    cos_a, sin_a = np.cos(view.azimuth_rad), np.sin(view.azimuth_rad)
    towards = np.array([cos_e * cos_a, cos_e * sin_a, sin_e])
    right = np.array([-sin_a, cos_a, 0.0])
    return np.array([right, np.cross(towards, right), towards])


def _fill(
    depth: Float[np.ndarray, "rows columns"],
    face_of: Int[np.ndarray, "rows columns"],
    corners: Float[np.ndarray, "3 3"],
    owner: int,
) -> None:
    """Put one triangle into the depth buffer; the larger third coordinate is nearer.

    A buffer instead of sorted faces: large faces of a notched room have no right order.
    """
    (ax, ay, _), (bx, by, _), (cx, cy, _) = corners
    # y is down on the image, so a triangle that looks at the observer has a negative area here.
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if area >= -1e-9:
        return
    rows, columns = depth.shape
    x0, y0 = np.maximum(np.floor(corners[:, :2].min(axis=0)).astype(int), 0)
    x1, y1 = np.minimum(np.ceil(corners[:, :2].max(axis=0)).astype(int) + 1, [columns, rows])
    x, y = np.arange(x0, x1)[None] + 0.5, np.arange(y0, y1)[:, None] + 0.5
    u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
    v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
    w = 1.0 - u - v
    near = u * corners[0, 2] + v * corners[1, 2] + w * corners[2, 2]
    window = np.s_[y0:y1, x0:x1]
    drawn = (u >= 0.0) & (v >= 0.0) & (w >= 0.0) & (near > depth[window])
    depth[window][drawn] = near[drawn]
    face_of[window][drawn] = owner


def _shades(result: FitResult, view: View) -> list[tuple[int, int, int]]:
    """Lambert's law with a lamp to the left of the observer, and most of the light from everywhere."""
    azimuth = view.azimuth_rad - 0.8
    lamp = np.array([0.6 * np.cos(azimuth), 0.6 * np.sin(azimuth), 0.8])
    shades = []
    for face in result.faces:
        facing = max(float(result.frame.R_manhattan_scan @ face.normal @ lamp), 0.0)
        light = 0.78 + 0.25 * facing
        r, g, b = (min(round(channel * light), 255) for channel in face_colour(face))
        shades.append((r, g, b))
    return shades


def _edges(face_of: Int[np.ndarray, "rows columns"]) -> np.ndarray:
    """Samples beside another face: a line of about 1.5 pixels along every edge of the model."""
    edges = np.zeros(face_of.shape, bool)
    for axis in (0, 1):
        for step in (1, 2, 3):
            a = np.moveaxis(face_of, axis, 0)
            different = a[step:] != a[:-step]
            np.moveaxis(edges, axis, 0)[step:] |= different
    return edges
