"""Colours for pixels that nobody saw."""

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

_SWEEPS = 24
"""Relaxations per level: the level above has solved everything that is longer than two pixels."""


def diffuse(
    colours: Float[np.ndarray, "rows columns channels"],
    known: Bool[np.ndarray, "rows columns"],
    mask: Bool[np.ndarray, "rows columns"],
) -> Float[np.ndarray, "rows columns channels"]:
    """Fill the unknown pixels of a face with the steady state of diffusion (Laplace's equation).

    No colour flows over the edge of the face. Solved from coarse to fine by halving the raster.

    Args:
        colours: any values where not `known`.
        known: pixels that keep their colour; at least one.
        mask: pixels of the face.
    """
    unknown = mask & ~known
    if not unknown.any():
        return colours
    filled = np.where(known[..., None], colours, 0.0)
    rows, columns = mask.shape
    if min(rows, columns) > 2:
        weight, total = _halved(known[..., None].astype(float)), _halved(filled)
        coarse_known = weight[..., 0] > 0.0
        coarse_mask = _halved(mask[..., None].astype(float))[..., 0] > 0.0
        coarse = diffuse(total / np.maximum(weight, 1e-9), coarse_known, coarse_mask)
        start = coarse.repeat(2, axis=0).repeat(2, axis=1)[:rows, :columns]
    else:
        start = np.broadcast_to(filled[known].mean(axis=0), filled.shape)
    filled = np.where(unknown[..., None], start, filled)
    return _relaxed(filled, unknown, mask)


def _halved(values: Float[np.ndarray, "rows columns channels"]) -> Float[np.ndarray, "r c channels"]:
    """Sums over squares of 2 x 2 pixels."""
    rows, columns, channels = values.shape
    padded = np.pad(values, ((0, rows % 2), (0, columns % 2), (0, 0)))
    return padded.reshape((rows + 1) // 2, 2, (columns + 1) // 2, 2, channels).sum(axis=(1, 3))


def _relaxed(
    values: Float[np.ndarray, "rows columns channels"],
    unknown: Bool[np.ndarray, "rows columns"],
    mask: Bool[np.ndarray, "rows columns"],
) -> Float[np.ndarray, "rows columns channels"]:
    """Every unknown pixel becomes the mean of its neighbours on the face, again and again."""
    rows, columns = mask.shape
    padded_mask = np.pad(mask, 1).ravel()
    at = np.flatnonzero(np.pad(unknown, 1).ravel())
    # The face's pixels around each unknown one; those off the face get no weight.
    around = at[:, None] + np.array([-1, 1, -columns - 2, columns + 2])
    weight = padded_mask[around].astype(float)
    weight /= np.maximum(weight.sum(axis=1, keepdims=True), 1.0)
    flat = np.pad(values, ((1, 1), (1, 1), (0, 0))).reshape(-1, values.shape[2])
    for _ in range(_SWEEPS):
        flat[at] = np.einsum("pk,pkc->pc", weight, flat[around])
    return flat.reshape(rows + 2, columns + 2, -1)[1:-1, 1:-1]


def bleed(
    colours: Float[np.ndarray, "rows columns channels"], mask: Bool[np.ndarray, "rows columns"]
) -> Float[np.ndarray, "rows columns channels"]:
    """Continue the colours over the edge of the face, so that smoothing viewers mix in nothing else."""
    if mask.all() or not mask.any():
        return colours
    row, column = ndimage.distance_transform_edt(~mask, return_distances=False, return_indices=True)  # type: ignore[misc]
    return colours[row, column]
