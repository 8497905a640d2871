"""Which points belong to which plane."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float, Int

from indoorfit.geometry import MAD_TO_STD, SAME_WALL_M, Exposure, SeenPiece, exposures, seen_pieces
from indoorfit.model import Plane, Shape

from .patches import PatchData, Patches, joined, summarise
from .sight import Sight


@dataclass(frozen=True)
class AssociationConfig:
    """Which points a plane may claim."""

    reach_m: float = 0.10
    """Points within this distance may be a plane's own; the thesis' 10 cm (3.2.4)."""
    reach_sigmas: float = 5.0
    """Noisier planes reach as far as this many standard deviations, at most `max_reach_m`."""
    max_reach_m: float = 0.25
    """Beyond it are doors, shelves and the next wall."""
    frame_reach_m: float = 0.03
    """The same once the frames' slips are taken out, half of what tells two walls apart: what is left is
    noise, some millimetres of slips and how uneven walls may be (DIN 18202: 10 mm over 4 m)."""
    edge_m: float = 0.05
    """Distance kept from a face's edges, where the neighbouring wall, skirting and cornice are."""
    patch_m: float = 0.7
    """Side of the patches that share one residual (statistics of the wall field)."""
    frame_patch_m: float = 1.0
    """The same for patches of single frames, which hold fewer points."""
    min_points: int = 5
    """Fewer points have no robust location."""


def associate(
    points_m: Float[np.ndarray, "points 3"],
    shape: Shape,
    config: AssociationConfig,
    pixel_m: float,
    sight: Sight | None = None,
) -> PatchData:
    """Claim points for every plane and summarise them patch by patch.

    Args:
        points_m: Manhattan frame, metres.
        shape: planes near their final places (within half the reach).
        config: see `AssociationConfig`.
        pixel_m: side of the squares in which coverage is counted.
        sight: of the points, Manhattan frame, where known.
    """
    return _associate(points_m, None, shape, config, pixel_m, config.patch_m, sight)


def associate_frames(
    points_m: Float[np.ndarray, "points 3"],
    frame_index: Int[np.ndarray, " points"],
    shape: Shape,
    config: AssociationConfig,
    pixel_m: float,
    sight: Sight | None = None,
    measured_m: Float[np.ndarray, "points 3"] | None = None,
) -> PatchData:
    """The same with one cell per frame and patch, for the pose model.

    Args:
        points_m: Manhattan frame, metres.
        frame_index: 0, 1, ... in the order in which the frames were taken.
        shape: fitted planes.
        config: see `AssociationConfig`; patches have the side `frame_patch_m`.
        pixel_m: side of the squares in which coverage is counted.
        sight: of the points, Manhattan frame, where known.
        measured_m: where the points are in the cloud as it is, if `points_m` has the slips taken out: those
            decide which plane a point belongs to, these are summarised.
    """
    patch_m = config.frame_patch_m
    return _associate(points_m, frame_index, shape, config, pixel_m, patch_m, sight, measured_m)


def _associate(
    points_m: Float[np.ndarray, "points 3"],
    frame_index: Int[np.ndarray, " points"] | None,
    shape: Shape,
    config: AssociationConfig,
    pixel_m: float,
    patch_m: float,
    sight: Sight | None,
    measured_m: Float[np.ndarray, "points 3"] | None = None,
) -> PatchData:
    parts: list[Patches] = []
    seen: list[SeenPiece] = []
    n_planes = len(shape.planes)
    n_points, rms_m = np.zeros(n_planes, int), np.zeros(n_planes)
    claimed_of_planes = claims(points_m, shape, config, sight)
    for exposure, (chosen, claimed) in zip(exposures(shape), claimed_of_planes, strict=True):
        plane = shape.planes[exposure.plane]
        if measured_m is not None:
            claimed = plane.to_own(measured_m[chosen])
        residuals_m = claimed[:, exposure.axis] - plane.offset_m
        seen += seen_pieces(exposure, claimed, partial(_coverage, pixel_m=pixel_m))
        n_points[exposure.plane] = len(residuals_m)
        if len(residuals_m) >= config.min_points:
            rms_m[exposure.plane] = MAD_TO_STD * np.median(np.abs(residuals_m - np.median(residuals_m)))
        frames = None if frame_index is None else frame_index[chosen]
        # A single frame's cell has few points, in the few depths that a disparity can take.
        coarse_m = 0.0 if frame_index is None else float(rms_m[exposure.plane])
        side_m = min(patch_m, (exposure.u_m[-1] - exposure.u_m[0]) / _COLUMNS) if plane.oblique else patch_m
        own = summarise(claimed, frames, exposure, plane.offset_m, side_m, config.min_points, coarse_m)
        parts.append(replace(own, means_m=plane.from_own(own.means_m)))
    return PatchData(joined(parts), n_points, rms_m, tuple(seen))


def claims(
    points_m: Float[np.ndarray, "points 3"],
    shape: Shape,
    config: AssociationConfig,
    sight: Sight | None = None,
) -> tuple[tuple[Int[np.ndarray, " _"], Float[np.ndarray, "_ 3"]], ...]:
    """Indices of the points that belong to each plane and their places in its own axes, as `exposures` go.

    Args:
        points_m: Manhattan frame, metres.
        shape: planes near their final places (within half the reach).
        config: see `AssociationConfig`.
        sight: of the points, Manhattan frame, where known.
    """
    found = []
    for exposure in exposures(shape):
        plane = shape.planes[exposure.plane]
        # Whatever stands near an unseen wall is not that wall.
        seen = points_m if plane.status == "observed" else points_m[:0]
        rivals_m = _rivals_m(shape, plane, exposure)
        own_sight = sight if sight is None or not plane.oblique else sight.seen_from(plane)
        found.append(_claim(plane.to_own(seen), exposure, plane, rivals_m, config, own_sight))
    return tuple(found)


_COLUMNS = 3
"""Patches along an oblique wall, at least: its yaw is read off them."""
_PARALLEL = float(np.cos(np.radians(10.0)))
"""Two sides of one oblique wall have a yaw each; within this angle they are sides of one wall."""


def _rivals_m(shape: Shape, plane: Plane, exposure: Exposure) -> list[float]:
    """Where other planes of the same direction lie, along the plane's own axis."""
    if not plane.oblique:
        return [
            other.offset_m
            for other in shape.planes
            if other.axis == plane.axis and not other.oblique and other is not plane
        ]
    middle_m = plane.from_own(np.array([[plane.offset_m, 0.5 * (exposure.u_m[0] + exposure.u_m[-1]), 0.0]]))[
        0
    ]
    others = [shape.planes[k] for k in shape.oblique if shape.planes[k] is not plane]
    return [
        plane.offset_m + float((other.offset_m - other.normal @ middle_m) / (other.normal @ plane.normal))
        for other in others
        if abs(other.normal @ plane.normal) > _PARALLEL
    ]


def _claim(
    points_m: Float[np.ndarray, "points 3"],
    exposure: Exposure,
    plane: Plane,
    rivals_m: list[float],
    config: AssociationConfig,
    sight: Sight | None,
) -> tuple[Int[np.ndarray, " claimed"], Float[np.ndarray, "claimed 3"]]:
    """Indices of the points on the exposed part of one plane, and their places; all in its own axes.

    Where lines of sight are known, a place along the plane is where the line meets it; the coordinate
    across the plane is always the measured one.
    """
    offset_m = plane.offset_m
    residuals_m = points_m[:, exposure.axis] - offset_m
    near = np.flatnonzero(np.abs(residuals_m) < config.max_reach_m)
    residuals_m = residuals_m[near]
    places_m, usable = points_m[near], np.ones(len(near), bool)
    if sight is not None:
        met = sight.meet(points_m, near, plane, config.reach_m)
        places_m = met.places_m
        places_m[:, exposure.axis] = points_m[near, exposure.axis]
        usable = met.faces & (met.depth_m < _usable_depth(met.depth_m, met.measured_m, sight.limit_m))
    inner = np.abs(residuals_m) < config.reach_m
    margin_m = _margin(exposure, config.edge_m)
    inside = exposure.contains(places_m, margin_m) & usable
    bulk = residuals_m[inside & inner]
    if len(bulk) == 0:
        return near[:0], places_m[:0]
    sigma_m = MAD_TO_STD * float(np.median(np.abs(bulk - np.median(bulk))))
    reach_m = float(np.clip(config.reach_sigmas * sigma_m, config.reach_m, config.max_reach_m))
    # The other side of a partition is another wall: what lies nearer to it is not claimed.
    low_m = max((0.5 * (r + offset_m) for r in rivals_m if r < offset_m - SAME_WALL_M), default=-np.inf)
    high_m = min((0.5 * (r + offset_m) for r in rivals_m if r > offset_m + SAME_WALL_M), default=np.inf)
    across_m = places_m[:, exposure.axis]
    keep = inside & (np.abs(residuals_m) < reach_m) & (across_m > low_m) & (across_m < high_m)
    return near[keep], places_m[keep]


def _usable_depth(
    depth_m: Float[np.ndarray, " near"], measured_m: Float[np.ndarray, " near"], limit_m: float
) -> float:
    """Depth up to which noise does not push points over the sensor's limit, where only the near ones return.

    Three standard deviations before the limit, from the points that are a little nearer.
    """
    if not np.isfinite(limit_m):
        return np.inf
    before = (depth_m > 0.8 * limit_m) & (depth_m < 0.93 * limit_m)
    if before.sum() < _MANY:
        return 0.93 * limit_m
    error_m = measured_m[before] - depth_m[before]
    return limit_m - 3.0 * MAD_TO_STD * float(np.median(np.abs(error_m - np.median(error_m))))


_MANY = 50
"""Points that give a spread to 15 %."""


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


def _coverage(exposure: Exposure, claimed_m: Float[np.ndarray, "claimed 3"], pixel_m: float) -> float:
    """Share of the exposed pixels with a point; the edges count as the rest, so full walls reach about 1."""
    area_m2 = exposure.area_m2
    if area_m2 == 0.0:
        return 0.0
    first, second = (axis for axis in range(3) if axis != exposure.axis)
    i = np.floor(claimed_m[:, first] / pixel_m).astype(np.int64)
    j = np.floor(claimed_m[:, second] / pixel_m).astype(np.int64)
    i, j = i - i.min(), j - j.min()
    seen = np.zeros((int(i.max()) + 1) * (int(j.max()) + 1), bool)
    seen[i * (int(j.max()) + 1) + j] = True
    return min(1.0, float(seen.sum()) * pixel_m**2 / area_m2)
