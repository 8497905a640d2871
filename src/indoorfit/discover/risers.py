"""The upright faces between two levels: how much of them was seen, and whether the heights jump there."""

import numpy as np
from jaxtyping import Bool, Float, Int

from .surfaces import Surfaces

_STRIP_M = 0.5
"""How far on both sides of a border the heights are compared: what slopes is
followed over it, so that a vault or a ramp has no step."""
_MIN_POINTS = 6
"""Surfels that a line is fitted to."""


def facing_shares(
    surfaces: Surfaces,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    band_m: tuple[float, float],
) -> tuple[Float[np.ndarray, "nx0 ny"], Float[np.ndarray, "nx ny0"]] | None:
    """Share of the strip between two heights, over each inner border, in which an upright face was seen.

    Args:
        surfaces: sorted evidence, Manhattan frame.
        grid: lines, Manhattan frame, metres.
        band_m: the two heights.

    Returns:
        for inner borders of constant x and of constant y; None if the strip is too low to show a row of
        surfels of its own.
    """
    # Points of the two levels themselves scatter into the band.
    low_m, high_m = band_m[0] + 2.0 * surfaces.noise_m, band_m[1] - 2.0 * surfaces.noise_m
    if high_m - low_m < 0.5 * surfaces.pixel_m:
        return None
    shares = []
    for axis in (0, 1):
        points_m = np.concatenate([surfaces.walls_m[axis], surfaces.stray_m])
        points_m = points_m[(points_m[:, 2] > low_m) & (points_m[:, 2] < high_m)]
        shares.append(_axis_shares(points_m, grid, axis, (low_m, high_m), surfaces))
    return shares[0], shares[1]


def _axis_shares(
    points_m: Float[np.ndarray, "n 3"],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    axis: int,
    band_m: tuple[float, float],
    surfaces: Surfaces,
) -> np.ndarray:
    across, along = grid[axis], grid[1 - axis]
    share = np.zeros((len(across), len(along) - 1))
    reach_m = 3.0 * surfaces.noise_m + 0.5 * surfaces.pixel_m
    nearest = np.argmin(np.abs(points_m[:, axis, None] - across[None, :]), axis=1)
    place = np.searchsorted(along, points_m[:, 1 - axis]) - 1
    good = np.abs(points_m[:, axis] - across[nearest]) < reach_m
    good &= (place >= 0) & (place < len(along) - 1)
    nearest, place, points_m = nearest[good], place[good], points_m[good]
    lengths = np.diff(along)
    n_columns = np.maximum(1, (lengths / surfaces.pixel_m).astype(int))
    # Rows of half a pixel: what only hangs below a ceiling leaves a gap under it.
    n_rows = max(1, int((band_m[1] - band_m[0]) / (0.5 * surfaces.pixel_m)))
    column = ((points_m[:, 1 - axis] - along[place]) / lengths[place] * n_columns[place]).astype(int)
    row = ((points_m[:, 2] - band_m[0]) / (band_m[1] - band_m[0]) * n_rows).astype(int)
    seen: Int[np.ndarray, "n 4"] = np.unique(np.stack([nearest, place, column, row], axis=1), axis=0)
    np.add.at(share, (seen[:, 0], seen[:, 1]), 1.0 / n_rows)
    # The outermost lines are walls; what is nearest to them is not to be taken for a side of a level.
    return np.moveaxis(share[1:-1] / n_columns[None, :], 0, axis)


def jumps_m(
    piece: Bool[np.ndarray, "nx ny"],
    mask: Bool[np.ndarray, "nx ny"],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    here_m: Float[np.ndarray, "n 3"],
    others_m: Float[np.ndarray, "m 3"],
) -> Float[np.ndarray, " borders"]:
    """How far the heights lie apart on the two sides of each border of a piece; empty if nothing shows it.

    Args:
        piece: cells at the level.
        mask: the room's cells.
        grid: their lines, Manhattan frame, metres.
        here_m: surfels of the level.
        others_m: surfels of all other levels of the floor or ceiling.
    """
    rest = mask & ~piece
    found = []
    for axis in (0, 1):
        a, b = np.moveaxis(piece, axis, 0), np.moveaxis(rest, axis, 0)
        for k, j in np.argwhere((a[1:] & b[:-1]) | (b[1:] & a[:-1])):
            line_m, ends_m = grid[axis][k + 1], grid[1 - axis][j : j + 2]
            sign = 1.0 if a[k + 1, j] else -1.0
            heights_m = [
                _height_at(points_m, axis, float(line_m), ends_m, side)
                for points_m, side in ((here_m, sign), (others_m, -sign))
            ]
            if None not in heights_m:
                found.append(abs(float(np.diff(np.array(heights_m, float))[0])))
    return np.array(found)


def _height_at(
    points_m: Float[np.ndarray, "n 3"],
    axis: int,
    line_m: float,
    ends_m: Float[np.ndarray, " 2"],
    side: float,
) -> float | None:
    """Height at a border of the surface on one side of it, along its slope; None where nothing is seen."""
    off_m = side * (points_m[:, axis] - line_m)
    along_m = points_m[:, 1 - axis]
    inside = (off_m > 0.0) & (off_m < _STRIP_M) & (along_m > ends_m[0]) & (along_m < ends_m[1])
    off_m, height_m = off_m[inside], points_m[inside, 2]
    if len(off_m) < _MIN_POINTS:
        return None
    if np.ptp(off_m) < 0.5 * _STRIP_M:
        # A narrow beam: its points say little of a slope.
        return float(np.median(height_m))
    return float(np.polyfit(off_m, height_m, 1)[1])
