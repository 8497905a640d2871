"""Where a wall that nobody saw may stand, and how well that is known.

The plan of least energy puts such a wall on a candidate, but it may stand anywhere in the shadow that hides
it: from where floor, ceiling or another wall were seen last to where the room would get another shape. What
was not seen there says nothing of the place, as all places in a shadow are equally dark; what was seen counts
as in the plan. With the same prior for all places their probabilities are those of the energy, exp(-E). The
wall is put at their mean, the place of least expected square error, with their standard deviation.

Where floor or ceiling end at the candidate along most of the wall, that is no shadow but the wall, and its
place was measured.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float

from .candidates import Lines
from .evidence import Evidence, FreeShares, cell_coverage, gather_evidence
from .free_space import FreeSpace
from .labelling import Borders, LabelConfig, cell_costs
from .level_task import Grid, refined
from .minimise import PlanEnergy
from .outline import Outline, Place, Wall, n_corners, walls_of, with_moved
from .surfaces import Surfaces

_ENDS = 0.5
"""Along more than this share of a wall floor or ceiling must end for its place to count as measured."""

_SAME = 0.1
"""Of the distance between the places that are tried: a nearer place than that is the same."""

_TRIED = 50
"""Places between two candidates at most: mean and spread of more are the same to a hundredth of the gap."""


def guess_places(
    rooms: Sequence[Bool[np.ndarray, "nx ny"]],
    lines: tuple[Lines, Lines],
    evidence: Evidence,
    settled: Borders,
    surfaces: Surfaces,
    free: FreeSpace | None,
    step_m: float,
    config: LabelConfig,
) -> Outline:
    """Put the walls that nobody saw in the middle of the places where they may stand.

    Args:
        rooms: cells of each room.
        lines: candidates across x and across y.
        evidence: of these cells and candidates.
        settled: borders whose place is known otherwise; walls with one of them stay.
        surfaces: sorted evidence.
        free: where lines of sight passed, if they are known: as good as floor or ceiling that was seen.
        step_m: distance of the places that are tried; nearer ones are one place.
        config: chances of seeing what is there. A wall of which less was seen than of walls where none are
            was not seen.
    """
    grid: Grid = (lines[0].offsets_m, lines[1].offsets_m)
    walls = [
        wall
        for room, mask in enumerate(rooms)
        for wall in walls_of(room, mask)
        if wall.mean(wall.beside(evidence.walls[wall.axis])[wall.line], grid) < config.wall_elsewhere
        and not np.any(wall.beside(settled[wall.axis])[wall.line])
    ]
    if not walls:
        return Outline(grid, list(rooms))
    moves = []
    for axis in (0, 1):
        across = [wall for wall in walls if wall.axis == axis]
        if not across:
            continue
        finer = _finer(lines, axis, step_m)
        fine: Grid = (finer[0].offsets_m, finer[1].offsets_m)
        seen = _seen(surfaces, finer, free)
        energy = _energy(seen, fine, config)
        masks = [refined(mask, grid, fine) for mask in rooms]
        for wall in across:
            own = wall.on(fine, grid)
            place = None if _ends_at(own, seen, fine) else _mean_place(own, masks, fine, energy)
            if place is not None:
                moves.append((wall, place))
    return with_moved(rooms, grid, moves)


def _finer(lines: tuple[Lines, Lines], axis: int, step_m: float) -> tuple[Lines, Lines]:
    """The candidates, and the places between them that walls across one axis are tried at."""
    between = [
        np.linspace(low, high, int(np.clip((high - low) / step_m, 1, _TRIED)), endpoint=False)[1:]
        for low, high in pairwise(lines[axis].offsets_m)
    ]
    finer = list(lines)
    finer[axis] = lines[axis].with_unseen(np.concatenate(between))
    return finer[0], finer[1]


def _seen(surfaces: Surfaces, lines: tuple[Lines, Lines], free: FreeSpace | None) -> Evidence:
    """What was seen; where lines of sight passed there is room as sure as where its floor was seen."""
    evidence = gather_evidence(surfaces, lines)
    if free is None:
        return evidence
    grid = (lines[0].offsets_m, lines[1].offsets_m)
    overhead, air = (cell_coverage(passed_m, grid, surfaces) for passed_m in (free.overhead_m, free.air_m))
    return replace(
        evidence, ceiling=np.maximum(evidence.ceiling, overhead), floor=np.maximum(evidence.floor, air)
    )


def _energy(seen: Evidence, grid: Grid, config: LabelConfig) -> PlanEnergy:
    """The plan's energy of what was seen; what was not costs and earns nothing, nor do corners."""
    widths = [np.diff(line) for line in grid]
    everywhere = np.ones_like(seen.floor)
    # As though lines of sight had passed everywhere: then nothing is missing.
    looked = FreeShares(everywhere, everywhere, seen.walls, seen.lintels)
    cells = cell_costs(replace(seen, free=looked), np.outer(*widths), config)
    odds = float(np.log(config.wall_between / config.wall_elsewhere))
    x, y = (-odds * share / config.patch_m for share in seen.walls)
    return PlanEnergy(cells, (x * widths[1][None, :], y * widths[0][:, None]), 0.0)


def _ends_at(wall: Wall, seen: Evidence, grid: Grid) -> bool:
    """Whether floor or ceiling end at a wall along most of it."""
    for level in (seen.floor, seen.ceiling):
        padded = wall.beside(np.pad(level, [(1, 1) if axis == wall.axis else (0, 0) for axis in (0, 1)]))
        if wall.outward * wall.mean(padded[wall.line] - padded[wall.line + 1], grid) > _ENDS:
            return True
    return False


def _mean_place(
    wall: Wall, rooms: Sequence[Bool[np.ndarray, "nx ny"]], grid: Grid, energy: PlanEnergy
) -> Place | None:
    """Mean and standard deviation of the wall's places; None where there is but one."""
    places = _places(wall, rooms, energy)
    if len(places) == 1:
        return None
    order = sorted(places)
    where_m: Float[np.ndarray, " places"] = grid[wall.axis][order]
    nats = np.array([places[line] for line in order])
    weight = np.gradient(where_m) * np.exp(nats.min() - nats)
    weight /= weight.sum()
    mean_m = float(weight @ where_m)
    std_m = float(np.sqrt(weight @ (where_m - mean_m) ** 2))
    # Another place than the candidate's makes sense from where places are told apart.
    near_m = _SAME * float(np.gradient(where_m)[order.index(wall.line)])
    return Place(mean_m, std_m) if max(std_m, abs(mean_m - grid[wall.axis][wall.line])) > near_m else None


def _places(wall: Wall, rooms: Sequence[Bool[np.ndarray, "nx ny"]], energy: PlanEnergy) -> dict[int, float]:
    """Lines that a wall can be moved to, and the energy with it there, but for what is the same for all.

    Args:
        wall: on the grid of the labels.
        rooms: labels of each.
        energy: of the labels.
    """
    # Smaller cubes are taken away from one large one: their walls lie in it.
    across = np.flatnonzero(np.moveaxis(rooms[wall.room], wall.axis, 0).any(axis=1))
    low, high = int(across[0]), int(across[-1]) + 1
    # What a move changes lies in the wall's own strip or beside it.
    first, along = max(low - 1, 0), slice(max(wall.cells.start - 1, 0), wall.cells.stop + 1)
    inside = np.logical_or.reduce(
        [np.moveaxis(room, wall.axis, 0)[first : high + 1, along] for room in rooms]
    )
    costs = _cropped(energy, wall.axis, slice(first, high + 1), along)
    strip = slice(wall.cells.start - along.start, wall.cells.stop - along.start)
    places = {wall.line: costs.of(inside)}
    beyond = wall.line if wall.outward > 0 else wall.line - 1
    if low <= beyond < high and np.any(inside[beyond - first, strip]):
        # Another room begins there.
        return places
    corners = n_corners(inside)
    for way in (1, -1):
        labels, line, joins = inside.copy(), wall.line, way == wall.outward
        while low <= line + way <= high:
            cell = (line if way > 0 else line - 1) - first
            if np.any(labels[cell, strip] == joins):
                break
            labels[cell, strip] = joins
            line += way
            places[line] = costs.of(labels)
            # Another number of corners is another room: where it changes is the last place of this one.
            if n_corners(labels) != corners:
                break
    return places


def _cropped(energy: PlanEnergy, axis: int, across: slice, along: slice) -> PlanEnergy:
    """The terms of a window of the plan, with an axis of choice first."""
    cells, own, other = (
        np.moveaxis(terms, axis, 0)
        for terms in (energy.cells, energy.borders[axis], energy.borders[1 - axis])
    )
    return PlanEnergy(
        cells[across, along],
        (own[across.start : across.stop + 1, along], other[across, along.start : along.stop + 1]),
        0.0,
    )
