"""What the scan says of each cell of the plan and of each border between two cells."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from .candidates import Lines
from .surfaces import Surfaces

BAND_M = 0.5
"""The band under the ceiling that separates walls from furniture: above doors (2.1 m of 2.6 m)."""
BAND_SHARE = 0.6
"""What the band counts of a wall; the rest counts the rest."""
UNDER_M = 0.25
"""Of a door of 2.1 m in a room of 2.4 m, the lintel fills this stretch below the ceiling."""
_LINTEL_M = 0.15
"""What hangs lower than this is at another level than the ceiling: a lintel is higher, drift is less."""
_DOOR_M = 2.1
"""A surface overhead that is lower is a door's or a window's head and no ceiling: clear heights of doors end
here (DIN 18101: 2.11 m), those of rooms begin higher. A room whose own ceiling is lower is exempt, if that is
the main level, or wide."""
_WIDE_M = 0.8
"""A low surface that is wider is the ceiling of a low room, a bath or a passage: walls, and so the heads of
their openings, are up to half a metre deep, cupboards 0.6 m, and nobody walks through less than 0.8 m."""


@dataclass(frozen=True)
class FreeShares:
    """Shares of area that lines of sight passed, between 0 and 1, on the grid of the candidate lines."""

    overhead: Float[np.ndarray, "nx ny"]
    """Of the cell: right below the ceiling, or ceiling was seen over it."""
    air: Float[np.ndarray, "nx ny"]
    """Of the cell: at any height above the floor."""
    walls: tuple[Float[np.ndarray, "nx1 ny"], Float[np.ndarray, "nx ny1"]]
    """Of the borders: in the band under the ceiling and where no wall was seen; counted as in
    `Evidence.walls`."""
    over: tuple[Float[np.ndarray, "nx1 ny"], Float[np.ndarray, "nx ny1"]]
    """Of the last stretch of the borders below the ceiling: cupboards end below it."""


@dataclass(frozen=True)
class Evidence:
    """Shares of area seen, between 0 and 1, on the grid of the candidate lines."""

    ceiling: Float[np.ndarray, "nx ny"]
    floor: Float[np.ndarray, "nx ny"]
    heads: Float[np.ndarray, "nx ny"]
    """Heads of doors and windows, under which no ceiling can be seen."""
    top_m: Float[np.ndarray, "nx ny"]
    """Height of the ceiling over each cell; the main level where none was seen."""
    walls: tuple[Float[np.ndarray, "nx1 ny"], Float[np.ndarray, "nx ny1"]]
    """Wall seen on the borders of constant x and of constant y; the outermost borders included."""
    lintels: tuple[Float[np.ndarray, "nx1 ny"], Float[np.ndarray, "nx ny1"]]
    """The same for the last stretch below the higher of the two ceilings: there a door has a lintel."""
    free: FreeShares | None = None
    """What lines of sight passed, where they are known."""


def gather_evidence(surfaces: Surfaces, lines: tuple[Lines, Lines]) -> Evidence:
    """Measure coverage of cells and borders.

    Args:
        surfaces: sorted evidence, Manhattan frame.
        lines: candidates along x and along y, at least two each.
    """
    grid = (lines[0].offsets_m, lines[1].offsets_m)
    floor = cell_coverage(surfaces.floor_m, grid, surfaces)
    main, head = _overhead(surfaces)
    heads = cell_coverage(surfaces.ceiling_m[head], grid, surfaces)
    surfaces = replace(surfaces, ceiling_m=surfaces.ceiling_m[~head])
    ceiling = _roofed(surfaces, main[~head], grid, floor)
    top_m = _tops(surfaces, grid)
    across_x, across_y = (_border_coverage(surfaces, lines, axis, ceiling, top_m) for axis in (0, 1))
    return Evidence(ceiling, floor, heads, top_m, (across_x[0], across_y[0]), (across_x[1], across_y[1]))


def _overhead(surfaces: Surfaces) -> tuple[Bool[np.ndarray, " c"], Bool[np.ndarray, " c"]]:
    """Which ceiling surfels are at the main level, and which are heads of doors and windows."""
    heights_m = surfaces.ceiling_m[:, 2]
    main = np.abs(heights_m - surfaces.ceiling_height_m) < _LINTEL_M
    head = ~main & (heights_m - surfaces.floor_height_m < _DOOR_M)
    head[head] = _mean_widths_m(surfaces.ceiling_m[head, :2], surfaces.pixel_m) < _WIDE_M
    return main, head


def _mean_widths_m(xy_m: Float[np.ndarray, "points 2"], pixel_m: float) -> Float[np.ndarray, " points"]:
    """For each point the area of the connected patch that it is in, over the longer extent of that patch."""
    if len(xy_m) == 0:
        return np.zeros(0)
    pixels, own = np.unique(np.floor(xy_m / pixel_m), axis=0, return_inverse=True)
    # Neighbours at a corner, with one pixel between them that shows no point by chance.
    pairs = KDTree(pixels).query_pairs(2.0 * np.sqrt(2.0) + 0.01, output_type="ndarray")
    joined = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=2 * (len(pixels),))
    n_patches, patch_of_pixel = connected_components(joined, directed=False)
    patch = patch_of_pixel[own.ravel()]
    low_m, high_m = np.full((n_patches, 2), np.inf), np.full((n_patches, 2), -np.inf)
    np.minimum.at(low_m, patch, xy_m)
    np.maximum.at(high_m, patch, xy_m)
    areas_m2 = np.bincount(patch) * (0.5 * pixel_m) ** 2
    return (areas_m2 / np.maximum((high_m - low_m).max(axis=1), pixel_m))[patch]


def _roofed(
    surfaces: Surfaces,
    main: Bool[np.ndarray, " c"],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    floor: Float[np.ndarray, "nx ny"],
) -> Float[np.ndarray, "nx ny"]:
    """Share of each cell under a ceiling.

    A vault counts as the main level does. At another level, a surface overhead is a ceiling only as far as
    there is floor below: without, it is the head of a window or the top of a cupboard.
    """
    share = cell_coverage(np.concatenate([surfaces.ceiling_m[main], surfaces.vault_m]), grid, surfaces)
    whole = cell_coverage(surfaces.ceiling_m, grid, surfaces)
    return np.maximum(share, np.minimum(whole, floor))


def cell_coverage(
    points_m: Float[np.ndarray, "points 3"],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    surfaces: Surfaces,
) -> Float[np.ndarray, "nx ny"]:
    """Share of each cell's pixels with a surfel.

    A thin cell is cut into pixels that are longer than wide, of the same area as the others, so that a
    recess of 10 cm is judged as fairly as a hall.
    """
    widths = [np.diff(line) for line in grid]
    # Noise carries wall and ceiling points a little over the border: keep away from it.
    margins = [np.minimum(2.0 * surfaces.noise_m, 0.2 * width) for width in widths]
    free = [width - 2.0 * margin for width, margin in zip(widths, margins, strict=True)]
    area_m2 = surfaces.pixel_m**2
    n_x = np.maximum(1, np.minimum(free[0] / surfaces.pixel_m, 1e6).astype(int))[:, None]
    n_x = np.broadcast_to(n_x, (len(free[0]), len(free[1])))
    n_y = np.maximum(1, (free[0][:, None] * free[1][None] / area_m2 / n_x).astype(int))
    wide = n_y == 1
    n_x = np.where(wide, np.maximum(1, (free[0][:, None] * free[1][None] / area_m2).astype(int)), n_x)
    start = np.concatenate([[0], np.cumsum((n_x * n_y).ravel())])
    index = [np.searchsorted(grid[a], points_m[:, a]) - 1 for a in range(2)]
    inside = np.all([(index[a] >= 0) & (index[a] < len(widths[a])) for a in range(2)], axis=0)
    i, j = index[0][inside], index[1][inside]
    u = (points_m[inside, 0] - grid[0][i] - margins[0][i]) / free[0][i]
    v = (points_m[inside, 1] - grid[1][j] - margins[1][j]) / free[1][j]
    clear = (u >= 0) & (u < 1) & (v >= 0) & (v < 1)
    i, j, u, v = i[clear], j[clear], u[clear], v[clear]
    pixel = (u * n_x[i, j]).astype(int) * n_y[i, j] + (v * n_y[i, j]).astype(int)
    seen = np.zeros(start[-1], bool)
    seen[start[i * n_x.shape[1] + j] + pixel] = True
    return np.add.reduceat(seen, start[:-1]).reshape(n_x.shape) / (n_x * n_y)


def _tops(
    surfaces: Surfaces, grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]]
) -> Float[np.ndarray, "nx ny"]:
    """Height of the highest level surface over each cell (80th percentile: lamps and shelves are lower)."""
    shape = (len(grid[0]) - 1, len(grid[1]) - 1)
    top_m = np.full(shape, surfaces.ceiling_height_m)
    i = np.searchsorted(grid[0], surfaces.ceiling_m[:, 0]) - 1
    j = np.searchsorted(grid[1], surfaces.ceiling_m[:, 1]) - 1
    inside = (i >= 0) & (i < shape[0]) & (j >= 0) & (j < shape[1])
    cell = (i * shape[1] + j)[inside]
    heights_m = surfaces.ceiling_m[inside, 2]
    order = np.lexsort((heights_m, cell))
    cells, first, count = np.unique(cell[order], return_index=True, return_counts=True)
    top_m.ravel()[cells] = heights_m[order][first + (0.8 * (count - 1)).astype(int)]
    return top_m


def _border_coverage(
    surfaces: Surfaces,
    lines: tuple[Lines, Lines],
    axis: int,
    ceiling: Float[np.ndarray, "nx ny"],
    top_m: Float[np.ndarray, "nx ny"],
) -> tuple[np.ndarray, np.ndarray]:
    """Shares of each border that show wall, and lintel; borders of constant `axis`."""
    across, along = lines[axis], lines[1 - axis]
    wall_m = surfaces.walls_m[axis]
    on_line = across.surfel_line
    stray_m, stray_line = _near_lines(surfaces, across, axis)
    wall_m, on_line = np.concatenate([wall_m, stray_m]), np.concatenate([on_line, stray_line])
    cell = np.searchsorted(along.offsets_m, wall_m[:, 1 - axis]) - 1
    n_lines, n_along = len(across.offsets_m), len(along.offsets_m) - 1
    valid = (on_line >= 0) & (cell >= 0) & (cell < n_along)
    on_line, cell, wall_m = on_line[valid], cell[valid], wall_m[valid]
    low_m, high_m = border_tops(np.moveaxis(ceiling, axis, 0), np.moveaxis(top_m, axis, 0))
    walls, lintels = np.zeros((n_lines, n_along)), np.zeros((n_lines, n_along))
    border = on_line * n_along + cell
    order = np.argsort(border, kind="stable")
    starts = np.searchsorted(border[order], np.arange(n_lines * n_along + 1))
    for k in np.flatnonzero(np.diff(starts)):
        members = wall_m[order[starts[k] : starts[k + 1]]][:, [1 - axis, 2]]
        line, c = divmod(int(k), n_along)
        ends_m = (along.offsets_m[c], along.offsets_m[c + 1])
        walls[line, c] = border_share(members, ends_m, low_m[line, c], surfaces)
        under_m = (high_m[line, c] - UNDER_M, high_m[line, c])
        lintels[line, c] = band_share(members, ends_m, under_m, surfaces)
    return np.moveaxis(walls, 0, axis), np.moveaxis(lintels, 0, axis)


def _near_lines(
    surfaces: Surfaces, across: Lines, axis: int
) -> tuple[Float[np.ndarray, "near 3"], Int[np.ndarray, " near"]]:
    """Surfels of no surface that lie on a candidate line, and that line."""
    offsets_m = across.offsets_m
    position_m = surfaces.stray_m[:, axis]
    nearest = np.searchsorted(0.5 * (offsets_m[1:] + offsets_m[:-1]), position_m)
    near = np.abs(position_m - offsets_m[nearest]) < 3.0 * surfaces.noise_m
    return surfaces.stray_m[near], nearest[near]


def border_tops(
    ceiling: Float[np.ndarray, "n m"], top_m: Float[np.ndarray, "n m"]
) -> tuple[Float[np.ndarray, "n1 m"], Float[np.ndarray, "n1 m"]]:
    """Ceiling heights at each border: of two seen ceilings the lower and the higher, else the seen one.

    Above the lower ceiling a face is the riser of a ceiling step, not a wall between the two cells.
    """
    seen = ceiling > 0.3
    found = []
    for nothing, choose in ((np.inf, np.minimum), (-np.inf, np.maximum)):
        padded = np.pad(np.where(seen, top_m, nothing), ((1, 1), (0, 0)), constant_values=nothing)
        chosen = choose(padded[:-1], padded[1:])
        found.append(np.where(np.isfinite(chosen), chosen, np.max(top_m)))
    return found[0], found[1]


def border_share(
    points_m: Float[np.ndarray, "points 2"], ends_m: tuple[float, float], top_m: float, surfaces: Surfaces
) -> float:
    """Share of the border's length with wall, the band under the ceiling counting more than the rest."""
    band_m, rest_m = (top_m - BAND_M, top_m), (surfaces.floor_height_m, top_m - BAND_M)
    band, rest = (band_share(points_m, ends_m, z_m, surfaces) for z_m in (band_m, rest_m))
    return BAND_SHARE * band + (1.0 - BAND_SHARE) * rest


def band_share(
    points_m: Float[np.ndarray, "points 2"],
    ends_m: tuple[float, float],
    z_m: tuple[float, float],
    surfaces: Surfaces,
) -> float:
    """Share of the pixels of an upright rectangle with a surfel."""
    length_m, low_m, high_m = ends_m[1] - ends_m[0], *z_m
    # Thin borders get tall pixels of the same area, as thin cells do.
    n_columns = max(1, int(length_m / surfaces.pixel_m))
    step_m = surfaces.pixel_m**2 / (length_m / n_columns)
    column = np.clip(((points_m[:, 0] - ends_m[0]) / length_m * n_columns).astype(int), 0, n_columns - 1)
    n_rows = max(1, int((high_m - low_m) / step_m))
    inside = (points_m[:, 1] > low_m) & (points_m[:, 1] < high_m)
    row = ((points_m[inside, 1] - low_m) / (high_m - low_m) * n_rows).astype(int)
    seen: Int[np.ndarray, " pixels"] = np.unique(column[inside] * n_rows + row)
    return len(seen) / (n_columns * n_rows)
