"""What a virtual scan shows of the true planes, and what of them is not there at all."""

from functools import partial

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from indoorfit.geometry import MAD_TO_STD, Exposure, SeenPiece, exposures, seen_pieces

from .virtual import VirtualScan

_MIN_REACH_M = 0.05
"""A point speaks for at least this much around it; smaller gaps are not worth telling."""
_SIGMAS = 5.0
"""Points further off are stray: half a billionth of a Gaussian, and no part of what is seen of the plane."""


def seen_of_planes(virtual: VirtualScan) -> tuple[tuple[SeenPiece, ...], Float[np.ndarray, " planes"]]:
    """What the points say of each plane of the shape.

    Returns:
        the connected parts of the planes with the number of their points, and the share of their area that
        lies within two point spacings (of the whole scan) of one; root mean square distance of each plane's
        points from it in metres, drift and scale included, 0 without points.
    """
    found = exposures(virtual.shape)
    seen: list[SeenPiece] = []
    rms_m = np.zeros(len(found))
    points_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    area_m2 = sum(exposure.area_m2 for exposure in found)
    # Two spacings: at an even density one place in 300 000 has no point that near.
    spacing_m = np.sqrt(area_m2 / max(int((virtual.point_plane >= 0).sum()), 1))
    reach_m = max(_MIN_REACH_M, 2.0 * float(spacing_m))
    for exposure in found:
        k, axis = exposure.plane, exposure.axis
        here_m = virtual.shape.planes[k].to_own(points_m[virtual.point_plane == k])
        off_m = here_m[:, axis] - virtual.shape.planes[k].offset_m
        near = _inliers(off_m)
        if near.any():
            rms_m[k] = float(np.sqrt(np.mean(off_m[near] ** 2)))
        # Drift carries points a little over the edge; they still speak for it.
        seen += seen_pieces(exposure, here_m[near], partial(_coverage, reach_m=reach_m), -reach_m)
    return tuple(seen), rms_m


def _inliers(off_m: Float[np.ndarray, " points"]) -> Bool[np.ndarray, " points"]:
    if not len(off_m):
        return np.zeros(0, bool)
    from_middle_m = np.abs(off_m - np.median(off_m))
    # 1 um keeps exact points.
    return from_middle_m <= _SIGMAS * MAD_TO_STD * np.median(from_middle_m) + 1e-6


def _coverage(exposure: Exposure, points_m: Float[np.ndarray, "points 3"], reach_m: float) -> float:
    i, j = np.nonzero(exposure.mask)
    if not len(i):
        return 0.0
    axes = [axis for axis in range(3) if axis != exposure.axis]
    low_m = np.array([exposure.u_m[i.min()], exposure.v_m[j.min()]])
    high_m = np.array([exposure.u_m[i.max() + 1], exposure.v_m[j.max() + 1]])
    cells = np.maximum(np.ceil((high_m - low_m) / (0.5 * reach_m)).astype(int), 1)
    size_m = (high_m - low_m) / cells
    seen = np.zeros(cells, bool)
    index = np.floor((points_m[:, axes] - low_m) / size_m).astype(int)
    # Drift carries points a little over the edge; they still speak for it.
    seen[tuple(np.clip(index, 0, cells - 1).T)] = True
    distance_m = ndimage.distance_transform_edt(~seen, sampling=size_m)
    centres_m = np.zeros((cells.prod(), 3))
    centres_m[:, axes] = low_m + (np.argwhere(np.ones(cells, bool)) + 0.5) * size_m
    inside = exposure.contains(centres_m).reshape(cells)
    return float((distance_m <= reach_m)[inside].mean()) if inside.any() else 0.0  # type: ignore[operator]
