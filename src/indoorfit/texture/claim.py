"""Which points lend their colour to which face."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Face

from .canvas import Canvas, inside
from .config import TextureConfig


def reach_m(face: Face, config: TextureConfig) -> float:
    """How far from the plane a point may be and still belong to the surface, by the fit's own residuals."""
    return max(config.noise_sigmas * face.rms_m, config.min_reach_m)


def claim_points(
    points_m: Float[np.ndarray, "points 3"],
    base_m: Float[np.ndarray, " 3"],
    canvases: Sequence[Canvas],
    config: TextureConfig,
) -> list[Int[np.ndarray, " _"]]:
    """Indices of the points of every face: within its noise, on its polygon, and nearest to it.

    What stands before a wall by more than the wall's own noise keeps off it, and so do the points of the
    neighbouring wall in a corner and those of the other side of a partition: a point goes to the face that
    it fits best, in units of that face's noise. Faces without points of their own (inferred) claim none.

    Args:
        points_m: scan axes, relative to `base_m`.
        base_m: scan frame.
        canvases: of the faces.
        config: see `TextureConfig`.
    """
    best = np.full(len(points_m), np.inf, np.float32)
    owner = np.full(len(points_m), -1, np.int32)
    for k, canvas in enumerate(canvases):
        face = canvas.face
        if face.status == "inferred":
            continue
        limit_m = reach_m(face, config)
        distance_m = np.abs(points_m @ face.normal - (face.rings_m[0][0] - base_m) @ face.normal)
        near = np.flatnonzero(distance_m <= limit_m)
        misfit = (distance_m[near] / limit_m).astype(np.float32)
        better = misfit < best[near]
        near, misfit = near[better], misfit[better]
        x_m, y_m = canvas.coordinates_m(points_m[near], base_m)
        within = inside(canvas.rings_m, x_m, y_m)
        best[near[within]], owner[near[within]] = misfit[within], k
    # 16 bits sort by counting, and stably: a face's points keep the order of the scan.
    order = np.argsort(owner.astype(np.int16) if len(canvases) < 2**15 else owner, kind="stable")
    bounds = np.searchsorted(owner[order], np.arange(len(canvases) + 1))
    return [order[a:b] for a, b in pairwise(bounds)]
