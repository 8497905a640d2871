"""The points of a plane summarised patch by patch: robust locations and what they are worth."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Int

from indoorfit.geometry import MAD_TO_STD, Exposure, SeenPiece


@dataclass(frozen=True)
class Patches:
    """Robust summaries, one per patch, or per frame and patch; Manhattan frame."""

    plane: Int[np.ndarray, " cells"]
    means_m: Float[np.ndarray, "cells 3"]
    """Position: along the plane's axis the robust location, along the other axes the mean."""
    variances_m2: Float[np.ndarray, " cells"]
    """Variance of the robust location from the spread of the points alone."""
    counts: Int[np.ndarray, " cells"]
    frames: Int[np.ndarray, " cells"] | None
    """Index of the frame whose points these are; None where patches mix frames."""


@dataclass(frozen=True)
class PatchData:
    """All patches, and what the points say of each plane as a whole."""

    patches: Patches
    plane_points: Int[np.ndarray, " planes"]
    """Points claimed by each plane."""
    plane_rms_m: Float[np.ndarray, " planes"]
    """Robust spread of those points about the plane; 0 without points."""
    pieces: tuple[SeenPiece, ...]
    """What was seen of every connected part of the planes."""

    @property
    def coverage(self) -> Float[np.ndarray, " planes"]:
        """Share of each plane's exposed area that points were seen on."""
        area_m2, seen_m2 = np.zeros(len(self.plane_points)), np.zeros(len(self.plane_points))
        for piece in self.pieces:
            own_m2 = piece.part.area_m2
            area_m2[piece.part.plane] += own_m2
            seen_m2[piece.part.plane] += piece.coverage * own_m2
        return np.divide(seen_m2, area_m2, out=np.zeros_like(area_m2), where=area_m2 > 0.0)


def summarise(
    claimed_m: Float[np.ndarray, "claimed 3"],
    frames: Int[np.ndarray, " claimed"] | None,
    exposure: Exposure,
    offset_m: float,
    patch_m: float,
    min_points: int,
    coarse_m: float = 0.0,
) -> Patches:
    """Robust location and its variance for every patch (and frame) with enough points.

    Args:
        claimed_m: the plane's points, in its own axes, as what is returned.
        frames: index of each point's frame; None to mix them.
        exposure: of the plane; the patches divide its grid evenly.
        offset_m: of the plane.
        patch_m: side of a patch.
        min_points: a patch with fewer has no robust location and is left out.
        coarse_m: see `robust_location`.
    """
    group = _patch_numbers(claimed_m, exposure, patch_m)
    n_frames = 1
    if frames is not None and len(frames):
        n_frames = int(frames.max()) + 1
        group = group.astype(np.int64) * n_frames + frames
    order = np.argsort(group, kind="stable")
    bounds = np.flatnonzero(np.diff(group[order], prepend=-1, append=-1))
    means_m, variances_m2, counts, found = [], [], [], []
    for start, end in pairwise(bounds):
        if end - start < min_points:
            continue
        members = claimed_m[order[start:end]]
        location_m, variance_m2 = robust_location(members[:, exposure.axis] - offset_m, coarse_m)
        mean_m = members.mean(axis=0)
        mean_m[exposure.axis] = offset_m + location_m
        means_m.append(mean_m)
        variances_m2.append(variance_m2)
        counts.append(end - start)
        found.append(group[order[start]] % n_frames)
    n_points = np.array(counts, int)
    return Patches(
        plane=np.full(len(counts), exposure.plane),
        means_m=np.array(means_m).reshape(-1, 3),
        variances_m2=_steadied(np.array(variances_m2, float), n_points),
        counts=n_points,
        frames=None if frames is None else np.array(found, int),
    )


_USUAL_DOF = 2.0
"""Degrees of freedom that the usual spread counts for beside the patch's own: few, since patches seen
from near and far differ by factors."""
_MAD_EFFICIENCY = 0.37
"""Of the MAD as a measure of spread, against the standard deviation of a Gaussian."""


def _steadied(
    variances_m2: Float[np.ndarray, " cells"], counts: Int[np.ndarray, " cells"]
) -> Float[np.ndarray, " cells"]:
    """Variances of the locations with the spread of few points drawn towards the plane's usual one.

    Three of five points may agree to a hundredth of a millimetre by chance; taken at its word such a patch
    would outweigh the wall, and another one would after the slightest move: the fit would not come to rest.

    Source: one over the posterior mean of the precision under a scaled inverse chi-square prior, as for
    variances of small samples in Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3.
    """
    if len(counts) == 0:
        return variances_m2
    spread_m2 = variances_m2 * counts
    dof = _MAD_EFFICIENCY * (counts - 1)
    usual_m2 = float(np.median(spread_m2))
    return (dof * spread_m2 + _USUAL_DOF * usual_m2) / ((dof + _USUAL_DOF) * counts)


def joined(parts: Sequence[Patches]) -> Patches:
    """The patches of all planes as one table."""
    frames = [part.frames for part in parts if part.frames is not None]
    return Patches(
        plane=np.concatenate([part.plane for part in parts]),
        means_m=np.concatenate([part.means_m for part in parts]),
        variances_m2=np.concatenate([part.variances_m2 for part in parts]),
        counts=np.concatenate([part.counts for part in parts]),
        frames=np.concatenate(frames) if frames else None,
    )


def _patch_numbers(
    claimed_m: Float[np.ndarray, "claimed 3"], exposure: Exposure, patch_m: float
) -> Int[np.ndarray, " claimed"]:
    """The patch of every point, in small integers, which sort fastest."""
    first, second = (axis for axis in range(3) if axis != exposure.axis)
    index = np.zeros(len(claimed_m), np.int64)
    for axis, lines_m in ((first, exposure.u_m), (second, exposure.v_m)):
        span_m = lines_m[-1] - lines_m[0]
        n = max(1, round(span_m / patch_m))
        step = ((claimed_m[:, axis] - lines_m[0]) / span_m * n).astype(np.int64)
        index = index * n + np.clip(step, 0, n - 1)
    # Small integers sort fastest, by counting.
    return index.astype(np.int16) if index.max(initial=0) < 2**15 else index


_TUKEY = 4.685
"""Cut-off of the biweight in standard deviations: 95 % efficient on a Gaussian."""
_COARSE_TUKEY = 7.0
"""The same for coarse values: 99 %, and nearly linear over the two or three steps that hold the bulk."""
_MIN_SIGMA_M = 1e-5
"""Exact synthetic walls have no spread; a hundredth of a millimetre keeps the weights finite."""


def robust_location(values_m: Float[np.ndarray, " points"], coarse_m: float = 0.0) -> tuple[float, float]:
    """Tukey biweight location of one patch, and the variance of that location.

    The scale is the patch's own MAD: within a patch the robustness may not choose between two layers of a
    misregistered wall, so a patch with two layers gets a wide scale and lands between them.

    Depths that come in steps (7 cm at 5 m for the first Kinect) have a MAD of zero as soon as three quarters
    of a patch share one step, and would then lose the rest: the location would jump from step to step instead
    of lying between them. The mean deviation does not vanish so; it counts up to `coarse_m`, since it is
    not robust.

    Args:
        values_m: at least one.
        coarse_m: the spread that is usual on this plane; 0 to trust the patch's own MAD.

    Source: reweighting steps from the median; variance of an M-estimator, Huber 1981, section 6.3.
    """
    location_m = float(np.median(values_m))
    deviations_m = np.abs(values_m - location_m)
    sigma_m = max(MAD_TO_STD * float(np.median(deviations_m)), _MIN_SIGMA_M)
    sigma_m = max(sigma_m, min(_MEAN_DEVIATION_TO_STD * float(np.mean(deviations_m)), coarse_m))
    cut_m = sigma_m * (_COARSE_TUKEY if coarse_m > 0.0 else _TUKEY)
    scaled = values_m
    weights = np.ones_like(values_m)
    for _ in range(4 if coarse_m > 0.0 else 2):
        scaled = np.square((values_m - location_m) / cut_m)
        weights = np.square(np.maximum(1.0 - scaled, 0.0))
        location_m = float(weights @ values_m / weights.sum())
    scaled = np.square((values_m - location_m) / cut_m)
    inner = scaled < 1.0
    slope = float(np.sum(((1.0 - scaled) * (1.0 - 5.0 * scaled))[inner]))
    score = float(np.sum((np.square(values_m - location_m) * np.power(1.0 - scaled, 4))[inner]))
    # With few points the slope of psi can vanish; the plain variance of a mean is then the honest one.
    if slope <= 0.3 * len(values_m):
        return location_m, sigma_m**2 / len(values_m)
    return location_m, max(score / slope**2, (0.1 * sigma_m) ** 2 / len(values_m))


_MEAN_DEVIATION_TO_STD = float(np.sqrt(np.pi / 2.0))
"""Mean absolute deviation of a Gaussian to its standard deviation."""
