"""The cells at one level: the most probable labelling of a room's plan."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from .candidates import candidate_lines, coverage_ends, distinct, end_reach
from .evidence import cell_coverage
from .labelling import log_odds
from .level_checks import Look, is_building
from .level_task import FoundLevel, Grid, LevelConfig, LevelTask, refined, within
from .minimise import PlanEnergy, minimise
from .risers import facing_shares

_HIDDEN_BEHIND = 0.5
"""Chance that a patch beside a beam or a platform is not seen: it lies in its shadow for about half of all
views."""


def level_pieces(
    task: LevelTask,
    points_m: Float[np.ndarray, "n 3"],
    own: Int[np.ndarray, " n"],
    heights_m: Float[np.ndarray, " levels"],
    k: int,
    config: LevelConfig,
) -> list[FoundLevel]:
    """The connected pieces of one level that are part of the building.

    Args:
        task: the room.
        points_m: surfels of its floor (ceiling).
        own: the level of each of them.
        heights_m: of the levels, the main one first.
        k: the level.
        config: see `LevelConfig`.
    """
    look = _look(task, points_m, own, heights_m, k)
    numbers, n = ndimage.label(_labelled(look, task))  # pyright: ignore[reportGeneralTypeIssues]
    pieces = [numbers == number for number in range(1, n + 1)]
    height_m = float(heights_m[k])
    return [FoundLevel(task.on, height_m, look.grid, p) for p in pieces if is_building(p, look, config)]


def _look(
    task: LevelTask,
    points_m: Float[np.ndarray, "n 3"],
    own: Int[np.ndarray, " n"],
    heights_m: Float[np.ndarray, " levels"],
    k: int,
) -> Look:
    labels, surfaces = task.labels, task.surfaces
    here_m, others_m = points_m[own == k], points_m[own != k]
    low_m, high_m = sorted((float(heights_m[0]), float(heights_m[k])))
    grid = _grid(task, here_m, points_m[own == 0], (low_m, high_m))
    chances = {
        "ceiling": (labels.ceiling_inside, labels.ceiling_outside),
        "floor": (labels.floor_inside, labels.floor_outside),
    }[task.on]
    here, others = cell_coverage(here_m, grid, surfaces), cell_coverage(others_m, grid, surfaces)
    gain = (log_odds(here, *chances) - log_odds(others, *chances)) / labels.patch_m**2
    # What reaches into the room hides what lies behind it, and not the other way round. A shadow counts once,
    # as in the plan.
    shadow = np.log((1.0 - chances[0]) / _HIDDEN_BEHIND) / labels.unseen_m**2
    gain = gain + (1.0 - np.maximum(here, others)) * shadow
    widths = [np.diff(line) for line in grid]
    shares = facing_shares(surfaces, grid, (low_m, high_m))
    side_gain = None
    if shares is not None:
        gain_x, gain_y = (log_odds(share, labels.wall_between, labels.wall_elsewhere) for share in shares)
        side_gain = gain_x * widths[1][None, :] / labels.patch_m, gain_y * widths[0][:, None] / labels.patch_m
    return Look(
        on=task.on,
        mask=refined(task.mask, task.grid, grid),
        grid=grid,
        here_m=here_m,
        others_m=others_m,
        rise_m=high_m - low_m,
        gain=gain * np.outer(*widths),
        side_gain=side_gain,
        pixel_m=surfaces.pixel_m,
        price=task.price,
    )


def _grid(
    task: LevelTask,
    here_m: Float[np.ndarray, "n 3"],
    main_m: Float[np.ndarray, "m 3"],
    band_m: tuple[float, float],
) -> Grid:
    """The plan's lines, and those where upright faces between the levels stand or the levels end."""
    surfaces = task.surfaces
    walls_m, segments = [], []
    for wall_m, segment in zip(surfaces.walls_m, surfaces.wall_segments, strict=True):
        between = (wall_m[:, 2] > band_m[0]) & (wall_m[:, 2] < band_m[1])
        between &= within(wall_m, task.grid, task.mask)
        walls_m.append(wall_m[between])
        segments.append(segment[between])
    walls = (walls_m[0], walls_m[1]), (segments[0], segments[1])
    none = here_m[:0]
    sides = replace(surfaces, walls_m=walls[0], wall_segments=walls[1], ceiling_m=none, floor_m=none)
    ends = replace(surfaces, ceiling_m=here_m, floor_m=main_m)
    config = task.candidates
    candidates = candidate_lines(sides, config)
    lines = []
    for axis in (0, 1):
        known_m = task.grid[axis]
        upright_m = candidates[axis].offsets_m[candidates[axis].seen]
        lines_m = np.concatenate([known_m, upright_m[_distance_m(upright_m, known_m) > config.merge_m]])
        end_m = np.array(distinct(coverage_ends(ends, axis, config), end_reach(surfaces)))
        # Beside a wall that hides its edge, floor or ceiling ends a little early; its own edge shows better.
        fresh = _distance_m(end_m, _outline_m(task, axis)) > end_reach(surfaces)
        fresh &= _distance_m(end_m, lines_m) > surfaces.pixel_m
        lines_m = np.sort(np.concatenate([lines_m, end_m[fresh]]))
        lines.append(lines_m[(lines_m >= known_m[0]) & (lines_m <= known_m[-1])])
    return lines[0], lines[1]


def _distance_m(from_m: Float[np.ndarray, " n"], to_m: Float[np.ndarray, " m"]) -> Float[np.ndarray, " n"]:
    """Distance of each position from the nearest of others."""
    return np.abs(from_m[:, None] - to_m[None, :]).min(axis=1, initial=np.inf)


def _outline_m(task: LevelTask, axis: int) -> Float[np.ndarray, " lines"]:
    """The lines on which the room has walls."""
    mask = np.pad(np.moveaxis(task.mask, axis, 0), ((1, 1), (0, 0)))
    return task.grid[axis][(mask[1:] != mask[:-1]).any(axis=1)]


def _labelled(look: Look, task: LevelTask) -> Bool[np.ndarray, "nx ny"]:
    """The most probable cells at the level: what is seen of them and of their sides, less their corners."""
    mask = look.mask
    both = np.pad(mask, 1)
    both_x, both_y = both[1:, 1:-1] & both[:-1, 1:-1], both[1:-1, 1:] & both[1:-1, :-1]
    side_x, side_y = np.zeros(both_x.shape), np.zeros(both_y.shape)
    if look.side_gain is not None:
        side_x[1:-1], side_y[:, 1:-1] = -look.side_gain[0], -look.side_gain[1]
    # Cells outside the room do not matter: a level may end at walls for nothing, and corners count where all
    # around is room.
    around = both[1:, 1:] & both[:-1, 1:] & both[1:, :-1] & both[:-1, :-1]
    energy = PlanEnergy(
        np.where(mask, -look.gain, 0.0),
        (np.where(both_x, side_x, 0.0), np.where(both_y, side_y, 0.0)),
        np.where(around, task.price, 0.0),
    )
    return minimise(energy, task.labels.max_open_cells)[0] & mask
