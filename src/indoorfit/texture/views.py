"""What one camera sees of the model, and what stands before it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from indoorfit.model import Camera, CameraImage

from .canvas import Canvas, inside

_BUFFER_COLUMNS = 160
"""Width of the visibility buffers: at 60 degrees of view a pixel covers 1.5 cm at 2 m, the size of a
pixel's share of a thinned scan."""
_NEAR_M = 0.05
"""What is nearer to the camera than this is not looked at."""


@dataclass(frozen=True)
class View:
    """Buffers of one camera, a few pixels of the image each."""

    image: CameraImage
    position_m: Float[np.ndarray, " 3"]
    """Scan axes, relative to the base."""
    step: int
    """Pixels of the image along a side of a pixel of the buffers."""
    faces: Int[np.ndarray, "rows columns"]
    """The face that each pixel meets first, -1 for none."""
    furniture_m: Float[np.ndarray, "rows columns"]
    """Depth of the nearest foreign point, infinite where there is none."""


@dataclass(frozen=True)
class Planes:
    """The model's faces as arrays, scan axes relative to a base."""

    canvases: tuple[Canvas, ...]
    normals: Float[np.ndarray, "faces 3"]
    offsets_m: Float[np.ndarray, " faces"]
    """``normal . p`` of every point of the plane."""


def planes_of(canvases: Sequence[Canvas], base_m: Float[np.ndarray, " 3"]) -> Planes:
    """The planes of the canvases."""
    normals = np.array([canvas.face.normal for canvas in canvases])
    offsets_m = np.array([(canvas.origin_m - base_m) @ canvas.face.normal for canvas in canvases])
    return Planes(tuple(canvases), normals, offsets_m)


def view_of(
    image: CameraImage,
    planes: Planes,
    base_m: Float[np.ndarray, " 3"],
    foreign_m: Float[np.ndarray, "points 3"],
    foreign_size_m: float,
) -> View:
    """Find the face behind each pixel of the buffers and the furniture before it.

    Args:
        image: its camera and pose count.
        planes: of the faces.
        base_m: scan frame; all positions are relative to it.
        foreign_m: points on no face.
        foreign_size_m: distance between them.
    """
    camera = image.camera
    step = max(1, round(camera.width / _BUFFER_COLUMNS))
    position_m = image.position_m - base_m
    rows, columns = -(-camera.height // step), -(-camera.width // step)
    v, u = np.mgrid[0:rows, 0:columns] * step + 0.5 * (step - 1)
    rays = _rays(camera, u, v) @ image.R_scan_camera.T
    depth_m = np.full((rows, columns), np.inf)
    faces = np.full((rows, columns), -1, np.int32)
    for k, canvas in enumerate(planes.canvases):
        height_m = planes.offsets_m[k] - planes.normals[k] @ position_m
        with np.errstate(divide="ignore", invalid="ignore"):
            t = height_m / (rays @ planes.normals[k])
        # From either side: a wall that is seen from behind hides what is in its room.
        nearer = np.isfinite(t) & (t > _NEAR_M) & (t < depth_m)
        hit_m = position_m + rays[nearer] * t[nearer, None]
        x_m, y_m = canvas.coordinates_m(hit_m, base_m)
        nearer[nearer] = inside(canvas.rings_m, x_m, y_m)
        depth_m[nearer], faces[nearer] = t[nearer], k
    furniture_m = _splat(image, foreign_m - position_m, foreign_size_m, step, (rows, columns))
    return View(image, position_m, step, faces, furniture_m)


def _rays(
    camera: Camera, u: Float[np.ndarray, "..."], v: Float[np.ndarray, "..."]
) -> Float[np.ndarray, "... 3"]:
    """Camera axes, length 1 along the depth."""
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    return np.stack([x, y, np.ones_like(x)], axis=-1)


def _splat(
    image: CameraImage,
    offsets_m: Float[np.ndarray, "points 3"],
    size_m: float,
    step: int,
    shape: tuple[int, int],
) -> Float[np.ndarray, "rows columns"]:
    """Depth buffer of points, each as large as the gap to the next one."""
    camera = image.camera
    buffer_m = np.full(shape, np.inf)
    x, y, z = (offsets_m @ image.R_scan_camera).T
    ahead = z > _NEAR_M
    x, y, z = x[ahead], y[ahead], z[ahead]
    column = np.round((camera.fx * x / z + camera.cx - 0.5 * (step - 1)) / step)
    row = np.round((camera.fy * y / z + camera.cy - 0.5 * (step - 1)) / step)
    radius = 0.5 * camera.fx * size_m / (z * step)
    # One pixel more on every side: better a gap in the texture than a cupboard on the wall. Classes of
    # sizes, so that each is one filter: points from 7 pixels on are nearer than anyone films furniture.
    for reach, low, high in ((1, 0.0, 0.5), (2, 0.5, 1.5), (3, 1.5, 2.5), (4, 2.5, np.inf)):
        chosen = (radius >= low) & (radius < high)
        chosen &= (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
        if not chosen.any():
            continue
        layer_m = np.full(shape, np.inf)
        at = (row[chosen].astype(int), column[chosen].astype(int))
        np.minimum.at(layer_m, at, z[chosen])
        spread_m = ndimage.minimum_filter(layer_m, 2 * reach + 1, mode="constant", cval=np.inf)
        buffer_m = np.minimum(buffer_m, spread_m)
    return buffer_m


@dataclass(frozen=True)
class Window:
    """The part of a canvas that a view may see."""

    face: int
    rows: slice
    columns: slice


def windows(view: View, planes: Planes, base_m: Float[np.ndarray, " 3"]) -> list[Window]:
    """For every face in the buffer the pixels of its canvas around what is seen of it."""
    found = []
    camera, step = view.image.camera, view.step
    for k in np.unique(view.faces[view.faces >= 0]).tolist():
        canvas = planes.canvases[k]
        height_m = planes.offsets_m[k] - planes.normals[k] @ view.position_m
        if height_m >= 0.0:
            continue  # seen from behind
        # One pixel of the buffer further on each side: its rim belongs to it as well.
        v, u = np.nonzero(ndimage.binary_dilation(view.faces == k, np.ones((3, 3), bool)))
        middle = 0.5 * (step - 1)
        rays = _rays(camera, u * step + middle, v * step + middle) @ view.image.R_scan_camera.T
        slope = rays @ planes.normals[k]
        ahead = slope < -1e-6
        hit_m = view.position_m + rays[ahead] * (height_m / slope[ahead])[:, None]
        x_m, y_m = canvas.coordinates_m(hit_m, base_m)
        rows, columns = _span(y_m, canvas.pixel_m, canvas.rows), _span(x_m, canvas.pixel_m, canvas.columns)
        if rows.stop > rows.start and columns.stop > columns.start:
            found.append(Window(k, rows, columns))
    return found


def _span(place_m: Float[np.ndarray, " n"], pixel_m: float, n: int) -> slice:
    if not len(place_m):
        return slice(0, 0)
    low, high = np.floor(place_m.min() / pixel_m), np.ceil(place_m.max() / pixel_m)
    return slice(int(np.clip(low, 0, n)), int(np.clip(high, 0, n)))


@dataclass(frozen=True)
class Move:
    """What an image shows of a face lies beside its place, because the pose errs."""

    centre_m: Float[np.ndarray, " 2"]
    """On the canvas: to the right and down from its corner."""
    matrix: Float[np.ndarray, "2 3"]
    """The pixel at c + centre_m is shown where the model has c + centre_m + matrix (c, 1)."""

    def at(
        self, x_m: Float[np.ndarray, " n"], y_m: Float[np.ndarray, " n"]
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """Where places are shown."""
        c = np.stack([x_m - self.centre_m[0], y_m - self.centre_m[1], np.ones_like(x_m)])
        dx_m, dy_m = self.matrix @ c
        return x_m + dx_m, y_m + dy_m


@dataclass(frozen=True)
class Sighting:
    """Pixels of a canvas as a camera sees them."""

    visible: Bool[np.ndarray, "rows columns"]
    """Of the window's pixels."""
    u: Float[np.ndarray, " n"]
    v: Float[np.ndarray, " n"]
    """Place in the image of each visible pixel."""
    depth_m: Float[np.ndarray, " n"]
    cosine: Float[np.ndarray, " n"]
    """Of the angle between the line of sight and the face's normal."""


def sight(
    view: View,
    planes: Planes,
    window: Window,
    mask: Bool[np.ndarray, "rows columns"],
    base_m: Float[np.ndarray, " 3"],
    clearance_m: float,
    move: Move | None = None,
) -> Sighting:
    """Project the window's pixels into the image and keep those that nothing hides.

    Args:
        view: of the camera.
        planes: of all faces.
        window: where to look.
        mask: of the window: pixels wanted.
        base_m: scan frame.
        clearance_m: points nearer to the face than this do not hide it.
        move: where the image shows the pixels, if not where the pose says.
    """
    canvas, camera = planes.canvases[window.face], view.image.camera
    row, column = np.nonzero(mask)
    x_m = (column + window.columns.start + 0.5) * canvas.pixel_m
    y_m = (row + window.rows.start + 0.5) * canvas.pixel_m
    if move is not None:
        x_m, y_m = move.at(x_m, y_m)
    start_m = canvas.origin_m - base_m - view.position_m
    frame = view.image.R_scan_camera
    start, right, down = start_m @ frame, canvas.right @ frame, canvas.down @ frame
    x, y, z = (start[k] + x_m * right[k] + y_m * down[k] for k in range(3))
    z_safe = np.maximum(z, _NEAR_M)
    u, v = camera.fx * x / z_safe + camera.cx, camera.fy * y / z_safe + camera.cy
    keep = (z > _NEAR_M) & (u >= 0) & (u <= camera.width - 1) & (v >= 0) & (v <= camera.height - 1)
    keep = np.flatnonzero(keep)
    x, y, z, u, v = x[keep], y[keep], z[keep], u[keep], v[keep]
    height_m = planes.normals[window.face] @ view.position_m - planes.offsets_m[window.face]
    cosine = height_m / np.sqrt(x**2 + y**2 + z**2)
    free = _free_of_faces(view, planes, window.face, u, v, z)
    # A face that is seen at a slant lies at several depths within one pixel of the buffer.
    slant_m = 2.0 * view.step / camera.fx * z * np.sqrt(1.0 / np.maximum(cosine, 0.05) ** 2 - 1.0)
    at = _buffer_pixel(view, u, v)
    free &= view.furniture_m[at] >= z - slant_m - clearance_m / np.maximum(cosine, 0.05)
    visible = np.zeros_like(mask)
    kept = keep[free]
    visible[row[kept], column[kept]] = True
    return Sighting(visible, u[free], v[free], z[free], cosine[free])


def _buffer_pixel(
    view: View, u: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"], du: float = 0.0, dv: float = 0.0
) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]]:
    rows, columns = view.faces.shape
    middle = 0.5 * (view.step - 1)
    row = np.round((v - middle) / view.step + dv).astype(np.int64)
    column = np.round((u - middle) / view.step + du).astype(np.int64)
    return np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)


def _free_of_faces(
    view: View,
    planes: Planes,
    face: int,
    u: Float[np.ndarray, " n"],
    v: Float[np.ndarray, " n"],
    depth_m: Float[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Whether no other face lies before these places.

    The buffer says which faces are seen around a place; the depth of those planes is computed for the very
    ray. In a corner of the room the other wall's plane lies behind, at a silhouette before: both are told
    right although the buffer is coarse.
    """
    free = np.ones(len(u), bool)
    rays = _rays(view.image.camera, u, v) @ view.image.R_scan_camera.T
    # The distance of the plane from the camera along the normal, and the rays' part of it, by face.
    heights_m = planes.offsets_m - planes.normals @ view.position_m
    for du in (-0.5, 0.5):
        for dv in (-0.5, 0.5):
            other = view.faces[_buffer_pixel(view, u, v, du, dv)]
            ask = np.flatnonzero((other != face) & (other >= 0) & free)
            slope = np.einsum("ni,ni->n", rays[ask], planes.normals[other[ask]])
            with np.errstate(divide="ignore", invalid="ignore"):
                t = heights_m[other[ask]] / slope
            # Rounding in the corner itself; a millimetre of wall is no occluder.
            free[ask[(t > 0.0) & (t < depth_m[ask] - 1e-3)]] = False
    return free
