"""Levels of floor and ceiling within a room: platforms, steps, beams and lowered ceilings.

A level is the most probable labelling of the room's cells as "at this height" or "at another", found like
the plan itself (`labelling`): what was seen at the height and what at others, the upright faces between the
two, and a price for each corner. What it would stand or hang there as furniture is then ruled out.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from .level_search import level_pieces
from .level_task import FoundLevel, Grid, LevelConfig, LevelTask, refined, within


@dataclass(frozen=True)
class RoomLevels:
    """What one room's floor or ceiling consists of."""

    main_m: float
    """The level with most area."""
    area_m2: float
    """That area."""
    others: tuple[FoundLevel, ...]
    unexplained: tuple[tuple[float, float], ...]
    """Height and area of further levels that are in the scan and not in `others`."""


def find_levels(task: LevelTask, fallback_m: float, config: LevelConfig) -> RoomLevels:
    """Split one room's floor or ceiling into levels.

    Args:
        task: where to look.
        fallback_m: the level of a room that shows none.
        config: see `LevelConfig`.
    """
    # Where one surface is seen in several places, two levels must be as far apart as two walls.
    config = replace(config, step_m=max(config.step_m, task.candidates.merge_m))
    points_m, area_m2 = task.points_m, (task.surfaces.pixel_m / 2.0) ** 2
    levels = level_areas(points_m[:, 2], config.step_m, area_m2)
    if not levels:
        return RoomLevels(fallback_m, 0.0, (), ())
    if sum(area_m2 >= config.min_area_m2 for _, area_m2 in levels) > config.max_levels:
        return RoomLevels(*levels[0], (), tuple(levels[1:]))
    heights_m = np.array([height_m for height_m, _ in levels])
    own = np.argmin(np.abs(points_m[:, 2:] - heights_m), axis=1)
    found: list[FoundLevel] = []
    left = np.ones(len(points_m), bool)
    for k in range(1, len(levels)):
        if levels[k][1] < config.min_area_m2:
            break
        for piece in level_pieces(task, points_m, own, heights_m, k, config):
            if not any(_overlap(piece, other) for other in found):
                found.append(piece)
                left &= ~within(points_m, piece.grid, piece.cells)
    rest = level_areas(points_m[left, 2], config.step_m, area_m2)
    main_m = float(heights_m[0])
    odd = tuple(level for level in rest if abs(level[0] - main_m) > config.step_m)
    return RoomLevels(main_m, levels[0][1], tuple(found), odd)


def level_cells(
    levels: RoomLevels, mask: Bool[np.ndarray, "nx ny"], grid: Grid
) -> dict[float, Bool[np.ndarray, "nx ny"]]:
    """The room's cells by the height of their level, each cell once.

    Args:
        levels: of this room.
        mask: its cells.
        grid: their lines, those of all `levels` among them.
    """
    cells: dict[float, Bool[np.ndarray, "nx ny"]] = {}
    for piece in levels.others:
        own = mask & refined(piece.cells, piece.grid, grid)
        cells[piece.offset_m] = cells[piece.offset_m] | own if piece.offset_m in cells else own
    rest = mask & ~np.logical_or.reduce([np.zeros_like(mask), *cells.values()])
    return {**cells, levels.main_m: rest} if rest.any() else cells


def level_areas(
    heights_m: Float[np.ndarray, " n"], step_m: float, area_m2: float
) -> list[tuple[float, float]]:
    """Levels as (height, area), largest first; each level takes what lies within one step of its peak."""
    levels: list[tuple[float, float]] = []
    left = np.sort(heights_m)
    while len(left):
        counts = np.searchsorted(left, left + step_m, side="right") - np.arange(len(left))
        k = int(np.argmax(counts))
        member = np.zeros(len(left), bool)
        member[k : k + counts[k]] = True
        level_m = float(np.median(left[member]))
        levels.append((level_m, area_m2 * float(counts[k])))
        left = left[np.abs(left - level_m) > step_m]
    return sorted(levels, key=lambda level: -level[1])


def _overlap(a: FoundLevel, b: FoundLevel) -> bool:
    """Whether two pieces share any place of the plan."""
    finer: Grid = (np.union1d(a.grid[0], b.grid[0]), np.union1d(a.grid[1], b.grid[1]))
    return bool((refined(a.cells, a.grid, finer) & refined(b.cells, b.grid, finer)).any())
