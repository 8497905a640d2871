"""Where lines of sight leave the room: under the lintel or the head of a door or a window."""

import numpy as np
from jaxtyping import Float

from indoorfit.model import Rays

from .candidates import Lines
from .raster import raster_over
from .surfaces import Surfaces

_FOOT_M = 1.8
"""Wall, or a level surface, above this height is no furniture that one looks over, or under."""
_HIGH_M = 0.25
"""Of a door of 2.1 m in a room of 2.4 m, the lintel fills this stretch below the ceiling."""
_LOWER_M = 0.15
"""What hangs lower than this is at another level than the ceiling: drift is less."""


def under_lintels(rays: Rays, surfaces: Surfaces, lines: tuple[Lines, Lines]) -> Float[np.ndarray, " rays"]:
    """The share of each ray's length at which it first crosses a wall line with wall above; else infinity.

    Args:
        rays: Manhattan frame.
        surfaces: sorted evidence.
        lines: candidates along x, along y.
    """
    first = np.full(len(rays.ends_m), np.inf)
    for axis in (0, 1):
        for k in np.flatnonzero(lines[axis].seen):
            begin_m, heights_m = _lintels(surfaces, lines[axis], axis, int(k))
            start_m, stop_m = (
                ends[:, axis] - lines[axis].offsets_m[k] for ends in (rays.origins_m, rays.ends_m)
            )
            ray = np.flatnonzero(start_m * stop_m < 0)
            at = start_m[ray] / (start_m[ray] - stop_m[ray])
            places_m = rays.origins_m[ray] + at[:, None] * (rays.ends_m - rays.origins_m)[ray]
            column = np.floor((places_m[:, 1 - axis] - begin_m) / surfaces.pixel_m).astype(int)
            beside = (column < 0) | (column >= len(heights_m))
            above_m = np.where(beside, -np.inf, heights_m[np.where(beside, 0, column)])
            under = places_m[:, 2] < above_m
            first[ray[under]] = np.minimum(first[ray[under]], at[under])
    return first


def _lintels(
    surfaces: Surfaces, line: Lines, axis: int, k: int
) -> tuple[float, Float[np.ndarray, " columns"]]:
    """Columns of a pixel's width along a line: where they begin, and how high each shows wall above.

    Lower crossings have a lintel's worth of wall above; -inf where no such wall was seen.
    """
    wall_m = surfaces.walls_m[axis][line.surfel_line == k]
    wall_m = wall_m[wall_m[:, 2] > surfaces.floor_height_m + _FOOT_M]
    if len(wall_m) == 0:
        return 0.0, np.array([-np.inf])
    begin_m = float(wall_m[:, 1 - axis].min())
    column = ((wall_m[:, 1 - axis] - begin_m) / surfaces.pixel_m).astype(int)
    order = np.lexsort((-wall_m[:, 2], column))
    column, height_m = column[order], wall_m[order, 2]
    starts = np.searchsorted(column, np.arange(column[-1] + 2))
    # Half of the surfels that a fully scanned lintel shows on one column, four to a pixel.
    needed = max(1, int(0.5 * 4.0 * _HIGH_M / surfaces.pixel_m))
    last = starts[:-1] + needed - 1
    return begin_m, np.where(last < starts[1:], height_m[np.minimum(last, len(height_m) - 1)], -np.inf)


def heads_over(surfaces: Surfaces) -> Float[np.ndarray, " squares1"]:
    """Height of the lowest head of a door or a window over each square of the plan; -inf where there is none.

    Beams and lowered ceilings count as heads: what was seen from beyond them is then not used, which does no
    harm. The last entry is for what lies outside of the raster.
    """
    raster = raster_over(surfaces)
    heights_m = surfaces.ceiling_m[:, 2]
    low = heights_m < surfaces.ceiling_height_m - _LOWER_M
    head = low & (heights_m > surfaces.floor_height_m + _FOOT_M)
    lowest_m = np.full(raster.size + 1, np.inf)
    np.minimum.at(lowest_m, raster.of(surfaces.ceiling_m[head, :2]), heights_m[head])
    return np.where(np.isfinite(lowest_m), lowest_m, -np.inf)
