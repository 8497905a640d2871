"""Textures from ordinary photos, put on by the four corners of the face (thesis 3.3.2)."""

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from indoorfit.errors import InputError
from indoorfit.model import FaceTexture, FitResult, Photo

from .canvas import canvas_of
from .config import TextureConfig
from .finish import finished
from .nearest import Colouring
from .sampling import bilinear


def texture_from_photo(result: FitResult, photo: Photo, config: TextureConfig) -> FaceTexture:
    """Put a photo on a face: the homography that takes the face's corners to those on the photo.

    The corners are those of the upright rectangle around the face, which for most walls is the face itself.
    The texture has the photo's own resolution on the face, but no finer than `photo_pixel_m`; its sides
    follow from the size of the face in metres, so that nothing is stretched. What lies off the photo is a
    gap.

    Args:
        result: the fitted model.
        photo: and the corners.
        config: see `TextureConfig`.

    Raises:
        InputError: there is no such face, or the corners make no convex quadrangle in the right order.
    """
    face = next((face for face in result.faces if face.id == photo.face), None)
    if face is None:
        names = ", ".join(face.id for face in result.faces)
        raise InputError(
            f"{photo.name}: no face {photo.face!r}; there are {names}. Fix: choose one of these."
        )
    _check_corners(photo)
    coarse = canvas_of(face, result.frame, config.photo_pixel_m, config.max_side)
    size_m = np.ptp(coarse.rings_m[0], axis=0)
    edges = np.linalg.norm(photo.corners - np.roll(photo.corners, -1, axis=0), axis=1)
    # The longer of the opposite edges is the nearer one: its detail is kept.
    own_m = float(min(size_m[0] / max(edges[0], edges[2]), size_m[1] / max(edges[1], edges[3])))
    canvas = canvas_of(face, result.frame, max(own_m, config.photo_pixel_m), config.max_side)
    homography = homography_of(size_m, photo.corners)
    rgb, shrink = _shrunk(photo.rgb, canvas.pixel_m / own_m)
    mask = canvas.mask()
    row, column = np.nonzero(mask)
    x_m, y_m = canvas.centres_m()
    w = np.stack([x_m[column], y_m[row], np.ones(len(row))], axis=1) @ homography.T
    # From the corner of the photo to the middle of its first pixel.
    u, v = w[:, 0] / w[:, 2] / shrink - 0.5, w[:, 1] / w[:, 2] / shrink - 0.5
    on = (u >= -0.5) & (u <= rgb.shape[1] - 0.5) & (v >= -0.5) & (v <= rgb.shape[0] - 0.5)
    if not on.any():
        raise InputError(f"{photo.name}: nothing of {photo.face} lies on it. Fix: correct the corners.")
    colours = np.zeros((*mask.shape, 3))
    colours[row[on], column[on]] = bilinear(rgb, u[on], v[on])
    known = np.zeros_like(mask)
    known[row[on], column[on]] = True
    return finished(canvas, Colouring(colours, known), "photo", config)


def homography_of(
    size_m: Float[np.ndarray, " 2"], corners: Float[np.ndarray, "4 2"]
) -> Float[np.ndarray, "3 3"]:
    """The projective map from a rectangle to a quadrangle.

    Args:
        size_m: width and height of the rectangle; its upper left corner is the origin, y downward.
        corners: where its upper left, upper right, lower right and lower left corner go.

    Returns:
        H with ``(u, v, 1) ~ H @ (x, y, 1)``; the third component is positive on the rectangle where the
        quadrangle is convex.

    Source: Heckbert 1989, "Fundamentals of texture mapping and image warping", section 2.2.3.
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = corners
    dx1, dx2, sx = x1 - x2, x3 - x2, x0 - x1 + x2 - x3
    dy1, dy2, sy = y1 - y2, y3 - y2, y0 - y1 + y2 - y3
    across = dx1 * dy2 - dx2 * dy1
    g, h = (sx * dy2 - dx2 * sy) / across, (dx1 * sy - sx * dy1) / across
    unit = np.array(
        [[x1 - x0 + g * x1, x3 - x0 + h * x3, x0], [y1 - y0 + g * y1, y3 - y0 + h * y3, y0], [g, h, 1]]
    )
    return unit @ np.diag([1.0 / size_m[0], 1.0 / size_m[1], 1.0])


def _check_corners(photo: Photo) -> None:
    """Convex, and turning as upper left, upper right, lower right, lower left do."""
    edges = np.roll(photo.corners, -1, axis=0) - photo.corners
    after = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
    # A pixel of area: less is a line.
    if not (turns > 1.0).all():
        raise InputError(
            f"{photo.name}: the corners of {photo.face} do not go once around it. Fix: give upper left, "
            "upper right, lower right, lower left as seen from inside, in pixels from the photo's upper left."
        )


def _shrunk(
    rgb: UInt8[np.ndarray, "height width 3"], factor: float
) -> tuple[Float[np.ndarray, "rows columns 3"], int]:
    """The photo with means over squares of pixels, where it is finer than the texture; and their side."""
    shrink = max(1, min(int(factor), *rgb.shape[:2]))
    if shrink > 1:
        rgb = np.asarray(Image.fromarray(rgb).reduce(shrink))
    return rgb.astype(np.float32).astype(float), shrink
