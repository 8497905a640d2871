"""The yaws of oblique walls in the joint fit: eliminated first, then read off (variable projection).

The least squares problem is over one rotation and the offsets. The yaw of an oblique wall appears in the
residuals of that wall alone, so the minimum over it has a closed form: first the wall's say about its own
direction in the plan is taken out of its moments, then its yaw is that of the line through its patches.

Source: Golub and Pereyra 1973, SIAM J. Numer. Anal. 10.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from indoorfit.model import Shape

from .moments import PlaneMoments
from .patches import Patches

_LEAST_BASE_M = 0.2
"""Patches of a wall that are nearer to each other do not tell its yaw: a third of a patch's side."""


def tells_yaw(along_m: Float[np.ndarray, " cells"]) -> bool:
    """Whether patches lie far enough apart along a wall: one, or one above the other, are none to turn by."""
    return float(np.ptp(along_m)) > _LEAST_BASE_M if len(along_m) else False


def turning_freely(moments: PlaneMoments, shape: Shape) -> PlaneMoments:
    """The moments of oblique planes without what their patches say about the yaw.

    With scatter S and the direction t in which the normal turns, the least of |S^(1/2) (n + a t)|^2 over a is
    n^T (S - S t t^T S / t^T S t) n.
    """
    if not shape.oblique:
        return moments
    roots = moments.roots.copy()
    for k in shape.oblique:
        turn = shape.planes[k].turn_normal
        scatter = roots[k] @ roots[k]
        pull = scatter @ turn
        if turn @ pull > 0.0:
            values, vectors = np.linalg.eigh(scatter - np.outer(pull, pull) / (turn @ pull))
            roots[k] = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    return replace(moments, roots=roots)


def turned_to(shape: Shape, patches: Patches, weights: Float[np.ndarray, " cells"]) -> tuple[Shape, float]:
    """Oblique planes through their patches, and the farthest that any of them moved there, metres.

    Args:
        shape: with offsets that fit the rotation.
        patches: Manhattan frame.
        weights: of the patches, 1/m^2.
    """
    planes, moved_m = list(shape.planes), 0.0
    for k in shape.oblique:
        own = patches.plane == k
        if not tells_yaw(patches.means_m[own] @ planes[k].turn_normal):
            continue
        xy_m = patches.means_m[own, :2]
        mean_m = np.average(xy_m, axis=0, weights=weights[own])
        centred = xy_m - mean_m
        _, axes = np.linalg.eigh((centred.T * weights[own]) @ centred)
        normal = axes[:, 0] * np.sign(axes[:, 0] @ planes[k].normal[:2])
        before_m = xy_m @ planes[k].normal[:2] - planes[k].offset_m
        yaw_rad, offset_m = float(np.arctan2(normal[1], normal[0])), float(normal @ mean_m)
        planes[k] = replace(planes[k], yaw_rad=yaw_rad, offset_m=offset_m)
        moved_m = max(moved_m, float(np.max(np.abs(xy_m @ normal - offset_m - before_m))))
    return replace(shape, planes=tuple(planes)), moved_m
