"""Which points belong to which plane, summarised in cells (robust locations of patches)."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from indoorfit.geometry import Exposure, exposures
from indoorfit.model import Shape

MAD_TO_STD = 1.4826
"""Median absolute deviation of a Gaussian to its standard deviation."""


@dataclass(frozen=True)
class AssociationConfig:
    """Which points a plane may claim."""

    reach_m: float = 0.10
    """Points within this distance may be a plane's own; the thesis' 10 cm (3.2.4)."""
    reach_sigmas: float = 5.0
    """Noisier planes reach as far as this many standard deviations, at most `max_reach_m`."""
    max_reach_m: float = 0.25
    """Beyond it are doors, shelves and the next wall."""
    edge_m: float = 0.05
    """Distance kept from a face's edges, where the neighbouring wall, skirting and cornice are."""
    patch_m: float = 0.7
    """Side of the patches that share one residual (statistics of the wall field)."""
    min_points: int = 5
    """Fewer points have no robust location."""


@dataclass(frozen=True)
class PatchData:
    """Robust summaries of the points on every patch of every plane, Manhattan frame."""

    plane: Int[np.ndarray, " cells"]
    means_m: Float[np.ndarray, "cells 3"]
    """Position: along the plane's axis the robust location, along the other axes the mean."""
    variances_m2: Float[np.ndarray, " cells"]
    """Variance of the robust location from the spread of the points alone."""
    counts: Int[np.ndarray, " cells"]
    plane_points: Int[np.ndarray, " planes"]
    """Points claimed by each plane."""
    plane_rms_m: Float[np.ndarray, " planes"]
    """Robust spread of those points about the plane; 0 without points."""
    coverage: Float[np.ndarray, " planes"]
    """Share of each plane's exposed area that points were seen on."""


def associate(
    points_m: Float[np.ndarray, "points 3"], shape: Shape, config: AssociationConfig, pixel_m: float
) -> PatchData:
    """Claim points for every plane and summarise them patch by patch.

    Args:
        points_m: Manhattan frame, metres.
        shape: planes near their final places (within half the reach).
        config: see `AssociationConfig`.
        pixel_m: side of the squares in which coverage is counted.
    """
    parts: list[_Patches] = []
    n_planes = len(shape.planes)
    n_points, rms_m, coverage = np.zeros(n_planes, int), np.zeros(n_planes), np.zeros(n_planes)
    for exposure in exposures(shape):
        plane = shape.planes[exposure.plane]
        if plane.status == "inferred":
            # Whatever stands near an unseen wall is not that wall.
            continue
        claimed, residuals_m = _claim(points_m, exposure, plane.offset_m, config)
        coverage[exposure.plane] = _coverage(claimed, exposure, pixel_m)
        patches = _patches(claimed, residuals_m, exposure, plane.offset_m, config)
        n_points[exposure.plane] = len(residuals_m)
        if len(residuals_m) >= config.min_points:
            rms_m[exposure.plane] = MAD_TO_STD * np.median(np.abs(residuals_m - np.median(residuals_m)))
        parts.append(patches)
    return PatchData(
        plane=np.concatenate([part.plane for part in parts]),
        means_m=np.concatenate([part.means_m for part in parts]),
        variances_m2=np.concatenate([part.variances_m2 for part in parts]),
        counts=np.concatenate([part.counts for part in parts]),
        plane_points=n_points,
        plane_rms_m=rms_m,
        coverage=coverage,
    )


def _claim(
    points_m: Float[np.ndarray, "points 3"], exposure: Exposure, offset_m: float, config: AssociationConfig
) -> tuple[Float[np.ndarray, "claimed 3"], Float[np.ndarray, " claimed"]]:
    """The points on the exposed part of one plane, and their residuals."""
    residuals_m = points_m[:, exposure.axis] - offset_m
    near = np.flatnonzero(np.abs(residuals_m) < config.max_reach_m)
    inner = np.abs(residuals_m[near]) < config.reach_m
    margin_m = _margin(exposure, config.edge_m)
    inside = exposure.contains(points_m[near], margin_m)
    bulk = residuals_m[near[inside & inner]]
    if len(bulk) == 0:
        return points_m[:0], residuals_m[:0]
    sigma_m = MAD_TO_STD * float(np.median(np.abs(bulk - np.median(bulk))))
    reach_m = float(np.clip(config.reach_sigmas * sigma_m, config.reach_m, config.max_reach_m))
    chosen = near[inside & (np.abs(residuals_m[near]) < reach_m)]
    return points_m[chosen], residuals_m[chosen]


def _margin(exposure: Exposure, edge_m: float) -> float:
    """The distance to keep from the edges: a fifth of the narrowest run at most, so that thin faces stay."""
    runs = [edge_m / 0.2]
    for mask, lines_m in ((exposure.mask, exposure.v_m), (exposure.mask.T, exposure.u_m)):
        padded = np.pad(mask, ((0, 0), (1, 1))).astype(np.int8)
        steps = np.diff(padded, axis=1)
        _, starts = np.nonzero(steps == 1)
        _, ends = np.nonzero(steps == -1)
        runs += list(lines_m[ends] - lines_m[starts])
    return 0.2 * float(min(runs))


def _coverage(claimed_m: Float[np.ndarray, "claimed 3"], exposure: Exposure, pixel_m: float) -> float:
    """Share of the exposed pixels with a point; the edges count as the rest, so full walls reach about 1."""
    area_m2 = exposure.area_m2
    if len(claimed_m) == 0 or area_m2 == 0.0:
        return 0.0
    first, second = (axis for axis in range(3) if axis != exposure.axis)
    i = np.floor(claimed_m[:, first] / pixel_m).astype(np.int64)
    j = np.floor(claimed_m[:, second] / pixel_m).astype(np.int64)
    i, j = i - i.min(), j - j.min()
    seen = np.zeros((int(i.max()) + 1) * (int(j.max()) + 1), bool)
    seen[i * (int(j.max()) + 1) + j] = True
    return min(1.0, float(seen.sum()) * pixel_m**2 / area_m2)


@dataclass(frozen=True)
class _Patches:
    plane: Int[np.ndarray, " cells"]
    means_m: Float[np.ndarray, "cells 3"]
    variances_m2: Float[np.ndarray, " cells"]
    counts: Int[np.ndarray, " cells"]


def _patches(
    claimed_m: Float[np.ndarray, "claimed 3"],
    residuals_m: Float[np.ndarray, " claimed"],
    exposure: Exposure,
    offset_m: float,
    config: AssociationConfig,
) -> _Patches:
    """Robust location and its variance for every patch with enough points."""
    first, second = (axis for axis in range(3) if axis != exposure.axis)
    index = np.zeros(len(claimed_m), np.int16)
    for axis, lines_m in ((first, exposure.u_m), (second, exposure.v_m)):
        span_m = lines_m[-1] - lines_m[0]
        n = max(1, round(span_m / config.patch_m))
        step = ((claimed_m[:, axis] - lines_m[0]) / span_m * n).astype(np.int16)
        index = index * np.int16(n) + np.clip(step, 0, n - 1).astype(np.int16)
    order = np.argsort(index, kind="stable")
    bounds = np.flatnonzero(np.diff(index[order], prepend=-1, append=-1))
    means_m, variances_m2, counts = [], [], []
    for start, end in pairwise(bounds):
        if end - start < config.min_points:
            continue
        members = order[start:end]
        location_m, variance_m2 = robust_location(residuals_m[members])
        mean_m = claimed_m[members].mean(axis=0)
        mean_m[exposure.axis] = offset_m + location_m
        means_m.append(mean_m)
        variances_m2.append(variance_m2)
        counts.append(end - start)
    return _Patches(
        plane=np.full(len(counts), exposure.plane),
        means_m=np.array(means_m).reshape(-1, 3),
        variances_m2=np.array(variances_m2, float),
        counts=np.array(counts, int),
    )


_TUKEY = 4.685
"""Cut-off of the biweight in standard deviations: 95 % efficient on a Gaussian."""
_MIN_SIGMA_M = 1e-5
"""Exact synthetic walls have no spread; a hundredth of a millimetre keeps the weights finite."""


def robust_location(values_m: Float[np.ndarray, " points"]) -> tuple[float, float]:
    """Tukey biweight location of one patch, and the variance of that location.

    The scale is the patch's own MAD: within a patch the robustness may not choose between two layers of a
    misregistered wall, so a patch with two layers gets a wide scale and lands between them.

    Source: two reweighting steps from the median; variance of an M-estimator, Huber 1981, section 6.3.
    """
    location_m = float(np.median(values_m))
    sigma_m = max(MAD_TO_STD * float(np.median(np.abs(values_m - location_m))), _MIN_SIGMA_M)
    scaled = values_m
    weights = np.ones_like(values_m)
    for _ in range(2):
        scaled = np.square((values_m - location_m) / (_TUKEY * sigma_m))
        weights = np.square(np.maximum(1.0 - scaled, 0.0))
        location_m = float(weights @ values_m / weights.sum())
    scaled = np.square((values_m - location_m) / (_TUKEY * sigma_m))
    inner = scaled < 1.0
    slope = float(np.sum(((1.0 - scaled) * (1.0 - 5.0 * scaled))[inner]))
    score = float(np.sum((np.square(values_m - location_m) * np.power(1.0 - scaled, 4))[inner]))
    # With few points the slope of psi can vanish; the plain variance of a mean is then the honest one.
    if slope <= 0.3 * len(values_m):
        return location_m, sigma_m**2 / len(values_m)
    return location_m, max(score / slope**2, (0.1 * sigma_m) ** 2 / len(values_m))
