"""What lines of sight passed through: places of the plan, and candidate walls."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.model import Rays

from .candidates import Lines
from .openings import heads_over, under_lintels
from .raster import Raster, raster_over
from .surfaces import Surfaces

_BAND_M = 0.5
"""Below the ceiling, as for walls: above doors, most windows and furniture."""
_DOOR_M = 2.1
"""Lower lines of sight pass through doors (DIN 18101: 2.11 m)."""
_LEAST_BAND_M = 0.25
"""In a room hardly higher than its doors: their lintels fill this stretch."""
_LEAST_RAYS = 2
"""Fewer lines of sight through one place may all end at outliers."""
_CHUNK = 5_000
"""Rays that are sampled at once: some hundred thousand samples, which fit into a processor's cache."""


@dataclass(frozen=True)
class FreeSpace:
    """Where lines of sight passed before any opening, Manhattan frame."""

    overhead_m: Float[np.ndarray, "o 3"]
    """Places, four to a pixel, that they passed right below the main ceiling; at its height."""
    air_m: Float[np.ndarray, "a 3"]
    """The same for any height above the floor; at the floor's."""
    passages: tuple[tuple["Passages", ...], tuple["Passages", ...]]
    """Of every candidate along x, along y."""


@dataclass(frozen=True)
class Passages:
    """Lines of sight that pass a candidate for good."""

    from_m: Float[np.ndarray, " passes"]
    """Place along the other axis, a margin before the candidate."""
    to_m: Float[np.ndarray, " passes"]
    """The same, a margin beyond it."""
    height_m: Float[np.ndarray, " passes"]
    """In between."""


def trace(rays: Rays, surfaces: Surfaces, lines: tuple[Lines, Lines]) -> FreeSpace:
    """Follow the rays through the plan, each as far as the first opening that it passes.

    Beyond a door or a window lies another room, or none: what is free there says nothing of this one. And
    each stops a margin before its end, as registration and noise put surfaces that far before one another.

    Args:
        rays: Manhattan frame.
        surfaces: sorted evidence.
        lines: candidates along x, along y.
    """
    margin_m = _margin_m(surfaces)
    length_m = np.linalg.norm(rays.ends_m - rays.origins_m, axis=1)
    opening = np.minimum(1.0, under_lintels(rays, surfaces, lines))
    ended = np.minimum(opening, 1.0 - np.minimum(1.0, margin_m / np.maximum(length_m, margin_m)))
    counts, headed = _counted(rays, ended, surfaces)
    opening = np.where(headed < ended, headed, opening)
    raster = raster_over(surfaces)
    air, overhead = (raster.centres_m(count >= _LEAST_RAYS) for count in counts)
    of_x, of_y = (
        tuple(passages(rays, opening, axis, float(c), margin_m) for c in lines[axis].offsets_m)
        for axis in (0, 1)
    )
    return FreeSpace(
        np.column_stack([overhead, np.full(len(overhead), surfaces.ceiling_height_m)]),
        np.column_stack([air, np.full(len(air), surfaces.floor_height_m)]),
        (of_x, of_y),
    )


def _margin_m(surfaces: Surfaces) -> float:
    """How far before its end a ray may have met what another frame saw: three standard deviations of noise
    and registration, and what a pixel cannot tell."""
    return surfaces.pixel_m + 3.0 * float(np.hypot(surfaces.noise_m, surfaces.scatter_m))


def passages(
    rays: Rays, reach: Float[np.ndarray, " rays"], axis: int, offset_m: float, margin_m: float
) -> Passages:
    """The rays that pass a plane and go on.

    A candidate is no surer of its place than the margin: a ray passes it if it comes from before and ends
    beyond the slab of twice this thickness. One that glances along a wall does not.

    Args:
        rays: Manhattan frame.
        reach: the share of each ray's length at which it leaves the room.
        axis: that the plane is perpendicular to.
        offset_m: of the plane.
        margin_m: half the thickness of the slab.
    """
    start_m, run_m = rays.origins_m[:, axis] - offset_m, (rays.ends_m - rays.origins_m)[:, axis]
    side = np.sign(start_m)
    through = (side * start_m > margin_m) & (side * (start_m + run_m) < -margin_m)
    through &= side * (start_m + reach * run_m) < 0.0
    origins_m, ends_m = rays.origins_m[through], rays.ends_m[through]
    start_m, run_m, side = start_m[through], run_m[through], side[through]
    before, beyond = (
        origins_m + ((s * side * margin_m - start_m) / run_m)[:, None] * (ends_m - origins_m) for s in (1, -1)
    )
    return Passages(before[:, 1 - axis], beyond[:, 1 - axis], 0.5 * (before[:, 2] + beyond[:, 2]))


def _counted(
    rays: Rays, reach: Float[np.ndarray, " rays"], surfaces: Surfaces
) -> tuple[Int[np.ndarray, "2 squares"], Float[np.ndarray, " rays"]]:
    """How many rays pass each square above the floor, and right below the ceiling; their new reach.

    Where a ray comes under the head of an opening it ends: the lintel itself may not have been seen.
    """
    raster, heads_m = raster_over(surfaces), heads_over(surfaces)
    foot_m, top_m = surfaces.floor_height_m, surfaces.ceiling_height_m
    band_m = min(max(top_m - _BAND_M, foot_m + _DOOR_M), top_m - _LEAST_BAND_M)
    counts = np.zeros((2, raster.size), np.int64)
    limits = []
    for k in range(0, len(reach), _CHUNK):
        some = slice(k, k + _CHUNK)
        ray, at, places_m = _samples(Rays(rays.origins_m[some], rays.ends_m[some]), reach[some], raster)
        square, height_m = raster.of(places_m[:, :2]), places_m[:, 2]
        under = height_m < heads_m[square]
        # Who stands under a lowered ceiling looks through no opening yet.
        under &= ~under[np.searchsorted(ray, ray)]
        under = np.flatnonzero(under)
        limit = reach[some].copy()
        np.minimum.at(limit, ray[under], at[under])
        within = (square < raster.size) & (at < limit[ray])
        # What noise and registration put above the floor is no air.
        air: Bool[np.ndarray, " samples"] = (
            within & (height_m > foot_m + _margin_m(surfaces)) & (height_m < top_m)
        )
        for row, chosen in enumerate((air, air & (height_m > band_m))):
            # Each ray once a square: a square is convex, so its samples of one ray follow each other.
            ray_here, square_here = ray[chosen], square[chosen]
            first = (np.diff(ray_here, prepend=-1) != 0) | (np.diff(square_here, prepend=-1) != 0)
            counts[row] += np.bincount(square_here[first], minlength=raster.size)
        limits.append(limit)
    return counts, np.concatenate(limits)


def _samples(
    rays: Rays, reach: Float[np.ndarray, " rays"], raster: Raster
) -> tuple[Int[np.ndarray, " samples"], Float[np.ndarray, " samples"], Float[np.ndarray, "samples 3"]]:
    """Places along rays, about one for each square that they pass: of which ray, at which share of it."""
    direction_m = rays.ends_m - rays.origins_m
    length_m = reach * np.linalg.norm(direction_m[:, :2], axis=1)
    # A ray that leaves the plan for the house opposite is sampled more coarsely.
    n = np.minimum((length_m / raster.side_m).astype(int) + 1, sum(raster.shape))
    ray = np.repeat(np.arange(len(n)), n)
    at = (np.arange(len(ray)) - np.repeat(np.cumsum(n) - n, n) + 0.5) / n[ray] * reach[ray]
    return ray, at, rays.origins_m[ray] + at[:, None] * direction_m[ray]
