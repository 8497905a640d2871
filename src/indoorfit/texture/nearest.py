"""Pixel colours from the three nearest points (thesis 3.3.1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from scipy import ndimage
from scipy.spatial import KDTree

from .canvas import Canvas

NEIGHBOURS = 3
"""The thesis' number."""

_SPACINGS = 2.0
"""A pixel without a point within two spacings is a gap: at an even density one in 300 000 is."""

_BLOCK = 0.25
"""Side of the blocks that share their neighbours, in spacings of the points: their rims are an eighth of a
spacing from the middle."""

_THREADS = 2
"""For the neighbour search; the result does not depend on it."""


@dataclass(frozen=True)
class Colouring:
    """Colours of a face's pixels, where there are any."""

    colours: Float[np.ndarray, "rows columns 3"]
    """0 to 255; 0 where not `known`."""
    known: Bool[np.ndarray, "rows columns"]


def colour_from_points(
    canvas: Canvas,
    mask: Bool[np.ndarray, "rows columns"],
    x_m: Float[np.ndarray, " points"],
    y_m: Float[np.ndarray, " points"],
    colours: UInt8[np.ndarray, "points 3"],
    wanted: Bool[np.ndarray, "rows columns"] | None = None,
) -> Colouring:
    """The mean colour of the three nearest points for every pixel that has points around it.

    Where even the densest part of a face has its points more than eight pixels apart, blocks of pixels share
    the neighbours of their middle: a tenth of the work for what no eye can tell.

    Args:
        canvas: of the face.
        mask: its pixels.
        x_m: the face's points, along `canvas.right`.
        y_m: the same along `canvas.down`.
        colours: of these points.
        wanted: the pixels to colour; None for all of the face.
    """
    out = np.zeros((*mask.shape, 3), np.float32)
    known = np.zeros_like(mask)
    if len(x_m) < NEIGHBOURS:
        return Colouring(out.astype(float), known)
    row, column = _pixel(y_m, canvas.pixel_m, canvas.rows), _pixel(x_m, canvas.pixel_m, canvas.columns)
    spacing_m = _spacing_m(row, column, mask, canvas.pixel_m)
    # Points in the order of the pixels: neighbours in space are then neighbours in memory.
    order = np.argsort(row * canvas.columns + column, kind="stable")
    places = np.stack([x_m[order], y_m[order]], axis=1)
    tree = KDTree(places, compact_nodes=False, balanced_tree=False)
    wanted = mask if wanted is None else mask & wanted
    block = max(1, int(_BLOCK * np.quantile(spacing_m[row, column], 0.1) / canvas.pixel_m))
    r, c = np.nonzero(_blocks(wanted, block))
    widest_m = _SPACINGS * float(spacing_m.max(initial=0.0)) + canvas.pixel_m
    query = (np.stack([c, r], axis=1) + 0.5) * (block * canvas.pixel_m)
    found = tree.query(query, NEIGHBOURS, distance_upper_bound=4.0 * widest_m, workers=_THREADS)
    distance_m, index = np.asarray(found[0]), np.asarray(found[1])
    nearest = np.minimum(index[:, 0], len(places) - 1)
    local_m = spacing_m[row[order][nearest], column[order][nearest]]
    seen = distance_m[:, 0] <= np.maximum(_SPACINGS * local_m, canvas.pixel_m)
    seen &= np.isfinite(distance_m[:, -1])
    mean = colours[order][index[seen]].mean(axis=1, dtype=np.float32)
    for i in range(block):
        for j in range(block):
            at_r, at_c = r[seen] * block + i, c[seen] * block + j
            on = np.flatnonzero((at_r < canvas.rows) & (at_c < canvas.columns))
            out[at_r[on], at_c[on]] = mean[on]
            known[at_r[on], at_c[on]] = True
    known &= wanted
    out[~known] = 0.0
    return Colouring(out.astype(float), known)


def _blocks(mask: Bool[np.ndarray, "rows columns"], side: int) -> Bool[np.ndarray, "r c"]:
    """Which squares of pixels hold one of the mask."""
    rows, columns = mask.shape
    padded = np.pad(mask, ((0, -rows % side), (0, -columns % side)))
    squares = padded.reshape(-(-rows // side), side, -(-columns // side), side)
    return np.asarray(squares.any(axis=(1, 3)))


def _pixel(place_m: Float[np.ndarray, " points"], pixel_m: float, n: int) -> Int[np.ndarray, " points"]:
    return np.clip((place_m / pixel_m).astype(np.int64), 0, n - 1)


def _spacing_m(
    row: Int[np.ndarray, " points"],
    column: Int[np.ndarray, " points"],
    mask: Bool[np.ndarray, "rows columns"],
    pixel_m: float,
) -> Float[np.ndarray, "rows columns"]:
    """Local distance between points, as the side of the square that each has to itself.

    Counted in windows of about four by four points, so that it follows the distance to the scanner; at most
    twice the mean of the face, so that single strays do not speak for a large surrounding.
    """
    counts = np.bincount(row * mask.shape[1] + column, minlength=mask.size).reshape(mask.shape).astype(float)
    mean_m = pixel_m * float(np.sqrt(mask.sum() / len(row)))
    for _ in range(2):
        # Once more with the part of the face that has points at all.
        window = 2 * round(2.0 * mean_m / pixel_m) + 1
        density = ndimage.uniform_filter(counts, window, mode="constant")
        area = ndimage.uniform_filter(mask.astype(float), window, mode="constant")
        covered = mask & (density > 0.5 / window**2)
        mean_m = pixel_m * float(np.sqrt(max(covered.sum(), 1) / len(row)))
    spacing_m = pixel_m * np.sqrt(np.maximum(area, 1e-9) / np.maximum(density, 1e-9))
    return np.minimum(spacing_m, 2.0 * mean_m)
