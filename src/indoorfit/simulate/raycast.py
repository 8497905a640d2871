"""Nearest hits of rays that share an origin: a vectorised kernel with culling by bundles of rays.

A bundle is a run of neighbouring rays. Rectangles that lie outside the pyramid around a bundle are left
out of it, which in a furnished room leaves about a tenth; the rest is a few small matrix products. This
reaches millions of rays a second without a compiled dependency; a bounding volume hierarchy in Python
would be slower for some hundred rectangles.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from .quads import Quads

BUNDLE = 1024
"""Rays per bundle: 32 x 32 pixels; the temporaries of a bundle then fit the second-level cache."""

_WIDEST_SLOPE = 40.0
"""Pyramids as wide as a half space: their faces cut nothing off, and rounding grows with the slope."""


@dataclass(frozen=True)
class Hits:
    """Where rays end."""

    distance: Float[np.ndarray, " rays"]
    """In units of the direction's length; infinite where nothing was hit."""
    quad: Int[np.ndarray, " rays"]
    """Index of the rectangle, -1 where nothing was hit."""


def cast(
    quads: Quads,
    origin_m: Float[np.ndarray, " 3"],
    directions: Float[np.ndarray, "rays 3"],
    nearest: Float[np.ndarray, " rays"] | None = None,
) -> Hits:
    """The first rectangle that each ray meets from its front.

    Args:
        quads: what can be hit; glass is treated like anything else.
        origin_m: common origin, Manhattan frame.
        directions: any length; neighbours in this list should be neighbours in space, or the culling
            saves nothing (the result does not depend on it).
        nearest: hits before this distance do not count (rays that begin on a mirror).
    """
    n = len(directions)
    distance, quad = np.full(n, np.inf), np.full(n, -1)
    offset_m = quads.corner_m - origin_m
    height = np.einsum("qi,qi->q", quads.normal, offset_m)
    facing = np.flatnonzero(height < 0.0)
    seen = quads.select(facing)
    height, offset_m = height[facing], offset_m[facing]
    u0 = -np.einsum("qi,qi->q", seen.along, offset_m)
    v0 = -np.einsum("qi,qi->q", seen.across, offset_m)
    corners_m = seen.corners_m() - origin_m
    axes = np.stack([seen.normal, seen.along, seen.across])
    near = _in_pyramids(corners_m, directions)
    for k, start in enumerate(range(0, n, BUNDLE)):
        rays = directions[start : start + BUNDLE]
        inside = np.flatnonzero(near[k])
        if not len(inside):
            continue
        slope, du, dv = axes[:, inside] @ rays.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = height[inside, None] / slope
            du *= t
            du += u0[inside, None]
            dv *= t
            dv += v0[inside, None]
            size_m = seen.size_m[inside]
            hit = (slope < 0.0) & (du >= 0.0) & (du <= size_m[:, :1]) & (dv >= 0.0) & (dv <= size_m[:, 1:])
        if nearest is not None:
            hit &= t > nearest[start : start + BUNDLE]
        t[~hit] = np.inf
        best = t.argmin(axis=0)
        t_best = t[best, np.arange(len(rays))]
        distance[start : start + BUNDLE] = t_best
        quad[start : start + BUNDLE] = np.where(np.isfinite(t_best), facing[inside[best]], -1)
    return Hits(distance, quad)


def _in_pyramids(
    corners_m: Float[np.ndarray, "quads 4 3"], directions: Float[np.ndarray, "rays 3"]
) -> Bool[np.ndarray, "bundles quads"]:
    """Rectangles that may meet the smallest upright pyramid around each bundle of rays.

    Conservative: a rectangle is left out only if all its corners are on the outer side of one face.
    """
    missing = -len(directions) % BUNDLE
    # The last ray fills up the last bundle: repeating it widens no pyramid.
    padded = np.concatenate([directions, np.repeat(directions[-1:], missing, axis=0)])
    bundles = padded.reshape(-1, BUNDLE, 3)
    # 256 bundles at a time keep the temporaries at some megabytes.
    parts = [_near_bundles(corners_m, bundles[k : k + 256]) for k in range(0, len(bundles), 256)]
    return np.concatenate(parts) if parts else np.zeros((0, len(corners_m)), bool)


def _near_bundles(
    corners_m: Float[np.ndarray, "quads 4 3"], bundles: Float[np.ndarray, "bundles rays 3"]
) -> Bool[np.ndarray, "bundles quads"]:
    middle = bundles.mean(axis=1)
    side = np.cross(middle, np.eye(3)[np.argmin(np.abs(middle), axis=1)])
    basis = np.stack([middle, side, np.cross(middle, side)], axis=1)
    basis /= np.maximum(np.linalg.norm(basis, axis=2, keepdims=True), 1e-300)
    forward, x, y = np.moveaxis(basis @ bundles.transpose(0, 2, 1), 1, 0)
    flat = corners_m.reshape(-1, 3).T
    w, cx, cy = np.moveaxis((basis @ flat).reshape(len(bundles), 3, -1, 4), 1, 0)
    # Zero where no pyramid exists; such bundles are not culled, see below.
    safe = np.maximum(forward, 1e-12)
    outside = (w <= 0.0).all(axis=2)
    too_wide = (forward <= 0.0).any(axis=1)
    for slope, c in ((x / safe, cx), (y / safe, cy)):
        low, high = slope.min(axis=1)[:, None, None], slope.max(axis=1)[:, None, None]
        outside |= (c < low * w).all(axis=2) | (c > high * w).all(axis=2)
        too_wide |= (high - low)[:, 0, 0] > _WIDEST_SLOPE
    return ~outside | too_wide[:, None]
