"""What lines of sight passed, as shares of each cell of the plan and of each border between two cells."""

import numpy as np
from jaxtyping import Float

from .candidates import Lines
from .evidence import (
    BAND_M,
    BAND_SHARE,
    UNDER_M,
    Evidence,
    FreeShares,
    band_share,
    border_tops,
    cell_coverage,
)
from .free_space import FreeSpace
from .surfaces import Surfaces


def free_shares(
    free: FreeSpace, evidence: Evidence, surfaces: Surfaces, lines: tuple[Lines, Lines]
) -> FreeShares:
    """Measure what lines of sight passed in the plan of the candidates.

    Args:
        free: where they passed.
        evidence: what was seen; what was seen of a border was not passed.
        surfaces: sorted evidence, Manhattan frame.
        lines: candidates along x and along y, at least two each.
    """
    grid = (lines[0].offsets_m, lines[1].offsets_m)
    overhead = cell_coverage(np.concatenate([surfaces.ceiling_m, free.overhead_m]), grid, surfaces)
    air = cell_coverage(free.air_m, grid, surfaces)
    of_x, of_y = (_borders(free, evidence, surfaces, lines, axis) for axis in (0, 1))
    return FreeShares(overhead, air, (of_x[0], of_y[0]), (of_x[1], of_y[1]))


def _borders(
    free: FreeSpace, evidence: Evidence, surfaces: Surfaces, lines: tuple[Lines, Lines], axis: int
) -> tuple[Float[np.ndarray, "_ _"], Float[np.ndarray, "_ _"]]:
    """Shares of each border of constant `axis` that were passed: in the band, in its uppermost stretch."""
    along_m = lines[1 - axis].offsets_m
    top_m, _ = border_tops(np.moveaxis(evidence.ceiling, axis, 0), np.moveaxis(evidence.top_m, axis, 0))
    band, over = np.zeros(top_m.shape), np.zeros(top_m.shape)
    for k, passes in enumerate(free.passages[axis]):
        middle_m = 0.5 * (passes.from_m + passes.to_m)
        cell, *ends = (np.searchsorted(along_m, at) - 1 for at in (middle_m, passes.from_m, passes.to_m))
        whole = (cell == ends[0]) & (cell == ends[1])
        places_m = np.column_stack([middle_m, passes.height_m])
        order = np.argsort(cell, kind="stable")
        starts = np.searchsorted(cell[order], np.arange(len(along_m)))
        for c in np.flatnonzero(np.diff(starts)):
            members = order[starts[c] : starts[c + 1]]
            ends_m, high_m = (along_m[c], along_m[c + 1]), top_m[k, c]
            over[k, c] = band_share(places_m[members], ends_m, (high_m - UNDER_M, high_m), surfaces)
            # A ray that comes from beside the border, or leaves beside it, perhaps passes round its corner.
            members = members[whole[members]]
            band[k, c] = band_share(places_m[members], ends_m, (high_m - BAND_M, high_m), surfaces)
    band, over = np.moveaxis(band, 0, axis), np.moveaxis(over, 0, axis)
    return np.minimum(BAND_SHARE * band, 1.0 - evidence.walls[axis]), over
