"""Reading colours out of images."""

import numpy as np
from jaxtyping import Float, UInt8
from scipy import ndimage


def halved(image: Float[np.ndarray, "rows columns 3"]) -> Float[np.ndarray, "r c 3"]:
    """Means of 2 x 2 pixels; an odd last row or column is dropped."""
    rows, columns = (n // 2 * 2 for n in image.shape[:2])
    return image[:rows, :columns].reshape(rows // 2, 2, columns // 2, 2, 3).mean(axis=(1, 3))


def bilinear(
    image: Float[np.ndarray, "rows columns 3"], u: Float[np.ndarray, " n"], v: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n 3"]:
    """Colours at places between the pixels; pixel centres are at whole numbers, the rim is repeated."""
    rows, columns = image.shape[:2]
    u, v = np.clip(u, 0.0, columns - 1.0), np.clip(v, 0.0, rows - 1.0)
    c = np.minimum(u.astype(np.int64), max(columns - 2, 0))
    r = np.minimum(v.astype(np.int64), max(rows - 2, 0))
    a, b = (u - c)[:, None].astype(np.float32), (v - r)[:, None].astype(np.float32)
    flat, at = image.reshape(-1, 3), r * columns + c
    right, below = min(columns - 1, 1), columns if rows > 1 else 0
    upper = flat[at] * (1.0 - a) + flat[at + right] * a
    lower = flat[at + below] * (1.0 - a) + flat[at + below + right] * a
    return upper * (1.0 - b) + lower * b


def sampled(
    image: UInt8[np.ndarray, "rows columns 3"],
    u: Float[np.ndarray, " n"],
    v: Float[np.ndarray, " n"],
    footprint: float,
) -> Float[np.ndarray, "n 3"]:
    """Colours at places, averaged first where a texture pixel covers several of the image.

    Args:
        image: sRGB.
        u: columns.
        v: rows.
        footprint: pixels of the image along the side of a texture pixel.
    """
    level, scaled = 0, image.astype(np.float32)
    while footprint >= 2.0 ** (level + 1) and min(scaled.shape[:2]) >= 4:
        scaled, level = halved(scaled), level + 1
    # The middle of the first 2^level pixels is the first pixel of that level.
    return bilinear(scaled, *((x - 0.5 * (2**level - 1)) / 2**level for x in (u, v)))


def sharpness(image: UInt8[np.ndarray, "rows columns 3"]) -> float:
    """0 for an image without any detail that smoothing could take, to 1 for a crisp one.

    How much of the differences between neighbouring pixels another smoothing takes away: a blurred image
    loses little. It hardly depends on what is on the image.

    Source: Crete et al. 2007, "The blur effect", SPIE 6492.
    """
    grey = image.astype(np.float32) @ np.array([0.299, 0.587, 0.114], np.float32)
    crispest = 0.0
    for axis in (0, 1):
        blurred = ndimage.uniform_filter1d(grey, 9, axis=axis)
        before, after = np.abs(np.diff(grey, axis=axis)), np.abs(np.diff(blurred, axis=axis))
        total = float(before.sum(dtype=np.float64))
        if total > 0.0:
            lost = float(np.maximum(before - after, 0.0).sum(dtype=np.float64)) / total
            crispest = max(crispest, lost)
    return crispest
