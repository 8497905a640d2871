"""Corners that oblique walls cut off: decided by the same energy as the plan.

An oblique wall between a wall across x and one across y cuts a corner off, of the room or of something that
stands in it. With the cut, nothing that was seen in that triangle counts for or against its cells, the wall
itself counts as every other, and the outline has one wall more. The cut stays if the plan of least energy
with it has less energy than the one without.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.geometry import Corner

from .candidates import Lines, end_reach
from .evidence import Evidence, border_share
from .labelling import LabelConfig, cell_costs, log_odds
from .level_task import Grid
from .oblique import ObliqueLine
from .surfaces import Surfaces

_NEAREST = 2
"""Walls that each end of an oblique wall is tried on: where it is hidden near the corner, a step before the
right one may be nearer."""


@dataclass(frozen=True)
class Cut:
    """One corner without its tip."""

    line: ObliqueLine
    at: tuple[int, int]
    """The candidates across x and across y that meet in the corner."""
    outward: Float[np.ndarray, " 2"]
    """Unit vector out of the room through the oblique wall."""
    corner: Corner
    own_nats: float
    """Cost of the wall itself, and of what it opens; without its price."""

    @property
    def opens(self) -> bool:
        """Whether the edge of something in the room is cut off, so that the triangle is room."""
        return self.corner.floor

    @property
    def yaw_rad(self) -> float:
        """Direction out of the room."""
        return float(np.arctan2(self.outward[1], self.outward[0]))

    @property
    def offset_m(self) -> float:
        """Along that direction."""
        return float(self.outward @ (self.line.offset_m * self.line.normal))

    def cells(self, grid: Grid) -> Float[np.ndarray, "nx ny"]:
        """Share of every cell of the plan that lies in the triangle."""
        share = np.zeros((len(grid[0]) - 1, len(grid[1]) - 1))
        low_m, high_m = self.corner.corners_m.min(axis=0), self.corner.corners_m.max(axis=0)
        touched = [
            np.flatnonzero((line[1:] > low_m[a]) & (line[:-1] < high_m[a])) for a, line in enumerate(grid)
        ]
        for i, j in product(touched[0].tolist(), touched[1].tolist()):
            low, high = (grid[0][i], grid[1][j]), (grid[0][i + 1], grid[1][j + 1])
            area_m2 = (high[0] - low[0]) * (high[1] - low[1])
            share[i, j] = self.corner.area_in_m2(low, high) / area_m2
        return share


@dataclass(frozen=True)
class Trial:
    """What became of one oblique line."""

    line: ObliqueLine
    cut: Cut | None
    """The corner that it cuts off, or would at least cost; None where it lies across none."""
    accepted: bool
    difference_nats: float
    """Accepted: by how much the best plan without it is worse; else by how much the best plan with it is.
    Infinite where no plan has that corner."""


def accepted_cuts(trials: Sequence[Trial]) -> tuple[Cut, ...]:
    """The corners that are cut off."""
    return tuple(trial.cut for trial in trials if trial.accepted and trial.cut is not None)


Solve = Callable[[Sequence[Cut]], tuple[Bool[np.ndarray, "nx ny"], float]]
"""The best labels of the plan with some corners cut off, and their energy, nats."""


def try_cuts(
    lines: tuple[Lines, Lines],
    surfaces: Surfaces,
    oblique: Sequence[ObliqueLine],
    solve: Solve,
    price: float,
    config: LabelConfig,
) -> tuple[Trial, ...]:
    """Cut off the corners that the plan of least energy has cut off, taken one by one, and tell of all lines.

    Args:
        lines: candidates across x and across y.
        surfaces: sorted evidence.
        oblique: walls that follow neither.
        solve: labels the plan.
        price: of a wall, nats.
        config: chances of seeing what is there.
    """
    if not oblique:
        return ()
    grid = (lines[0].offsets_m, lines[1].offsets_m)

    def energy(cuts: Sequence[Cut]) -> float:
        return _energy(solve, cuts, grid, price)

    possible = [list(_possible(line, lines, surfaces, config)) for line in oblique]
    # A wall that does not pay for itself is worth no plan of its own.
    paying = [cut for cuts in possible for cut in cuts if cut.own_nats + price < 0.0]
    alone = {id(cut): energy([cut]) for cut in paying}
    least, found = energy([]), []
    for cut in sorted(paying, key=lambda cut: alone[id(cut)]):
        if any(cut.line is other.line or _overlap(cut, other, grid) for other in found):
            continue
        if (reached := energy([*found, cut])) < least:
            least = reached
            found.append(cut)
    trials = []
    for line, cuts in zip(oblique, possible, strict=True):
        own = next((cut for cut in found if cut.line is line), None)
        if own is not None:
            without = energy([cut for cut in found if cut is not own])
            trials.append(Trial(line, own, True, without - least))
            continue
        best = min(cuts, key=lambda cut: alone.get(id(cut), np.inf), default=None)
        # One that overlaps an accepted one cannot stand beside it.
        beside = best is not None and id(best) in alone and not any(_overlap(best, o, grid) for o in found)
        nats = energy([*found, best]) - least if best is not None and beside else np.inf
        trials.append(Trial(line, best, False, nats))
    return tuple(trials)


def _energy(solve: Solve, cuts: Sequence[Cut], grid: Grid, price: float) -> float:
    """Least energy of a plan with these corners cut off; infinite where it has no such corners."""
    inside, energy = solve(cuts)
    if not all(_fits(cut, inside, grid) for cut in cuts):
        return np.inf
    return energy + sum(cut.own_nats + price for cut in cuts)


def _overlap(first: Cut, second: Cut, grid: Grid) -> bool:
    return bool(np.any((first.cells(grid) > 0.0) & (second.cells(grid) > 0.0)))


def _possible(
    line: ObliqueLine, lines: tuple[Lines, Lines], surfaces: Surfaces, config: LabelConfig
) -> Iterator[Cut]:
    """All corners that one oblique wall may cut off: on either side, of the room or of what stands in it."""
    grid = (lines[0].offsets_m, lines[1].offsets_m)
    reach_m = end_reach(surfaces)
    for away in (line.normal, -line.normal):
        sign = np.sign(away)
        # The end that lies farther towards the corner along x meets the wall across x.
        ends = line.ends_m[np.argsort(-sign[0] * line.ends_m[:, 0])]
        walls = [_beyond(grid[a], ends[a, a], sign[a], reach_m) for a in (0, 1)]
        for i, j in product(*walls):
            tip_m = np.array([grid[0][i], grid[1][j]])
            if away @ tip_m <= away @ (line.offset_m * line.normal) + reach_m:
                continue
            corners_m = np.array([line.crossing_m(0, tip_m[0]), line.crossing_m(1, tip_m[1]), tip_m])
            nats = wall_nats(line, corners_m[:2], surfaces, config)
            yield Cut(line, (i, j), away, Corner(corners_m, floor=False), nats)
            # Something of which nothing but a cut edge was seen is the room's own corner, cut off.
            if not (lines[0].seen[i] and lines[1].seen[j]):
                continue
            opened = Cut(line, (i, j), -away, Corner(corners_m, floor=True), nats)
            yield replace(opened, own_nats=nats + _opened_nats(opened, surfaces, config))


def _beyond(offsets_m: Float[np.ndarray, " lines"], end_m: float, sign: float, reach_m: float) -> list[int]:
    """The nearest candidates that the end of a wall may run to."""
    ahead_m = sign * (offsets_m - end_m)
    order = np.argsort(ahead_m, kind="stable")
    return [int(k) for k in order[ahead_m[order] > -reach_m][:_NEAREST]]


def wall_nats(
    line: ObliqueLine, ends_m: Float[np.ndarray, "2 2"], surfaces: Surfaces, config: LabelConfig
) -> float:
    """Cost of an oblique wall between two places of the plan, by what of it was seen; without its price."""
    reach = np.sort(ends_m @ line.along)
    places_m = np.stack([line.points_m[:, :2] @ line.along, line.points_m[:, 2]], axis=1)
    places_m = places_m[(places_m[:, 0] > reach[0]) & (places_m[:, 0] < reach[1])]
    share = border_share(places_m, (float(reach[0]), float(reach[1])), surfaces.ceiling_height_m, surfaces)
    odds = log_odds(np.array([share]), config.wall_between, config.wall_elsewhere)
    return -float(odds[0]) * float(reach[1] - reach[0]) / config.patch_m


def _opened_nats(cut: Cut, surfaces: Surfaces, config: LabelConfig) -> float:
    """Cost of the triangle being room, as the cells that it is cut from would have it."""
    floor, ceiling = (
        _seen_share(cut.corner, level_m, surfaces) for level_m in (surfaces.floor_m, surfaces.ceiling_m)
    )
    nothing = np.zeros((1, 1))
    share = Evidence(
        np.array([[ceiling]]),
        np.array([[floor]]),
        nothing,
        nothing,
        (nothing, nothing),
        (nothing, nothing),
    )
    return float(cell_costs(share, np.array([[cut.corner.area_m2]]), config)[0, 0])


def _seen_share(corner: Corner, level_m: Float[np.ndarray, "points 3"], surfaces: Surfaces) -> float:
    """Share of the triangle on which a level surface was seen, by pixels as in the cells."""
    own_m = level_m[corner.contains(level_m[:, :2])]
    pixels = np.unique(np.floor(own_m[:, :2] / surfaces.pixel_m), axis=0)
    return min(1.0, len(pixels) * surfaces.pixel_m**2 / corner.area_m2)


def _fits(cut: Cut, inside: Bool[np.ndarray, "nx ny"], grid: Grid) -> bool:
    """Whether the plan has that corner: walls along both sides of it, from end to end."""
    if np.any(inside[cut.cells(grid) > 0.5] == cut.opens):
        return False
    padded = np.pad(inside, 1)
    tip_m = cut.corner.corners_m[2]
    for axis in (0, 1):
        line = cut.at[axis] + 1
        before, after = (np.moveaxis(padded, axis, 0)[k] for k in (line - 1, line))
        ends_m = np.sort([cut.corner.corners_m[axis, 1 - axis], tip_m[1 - axis]])
        middles_m = 0.5 * (grid[1 - axis][1:] + grid[1 - axis][:-1])
        along = np.flatnonzero((middles_m > ends_m[0]) & (middles_m < ends_m[1])) + 1
        # The cell at the tip, however far it reaches.
        tip = cut.at[1 - axis] + (0 if cut.corner.corners_m[axis, 1 - axis] < tip_m[1 - axis] else 1)
        along = np.append(along, tip)
        low_side = cut.corner.corners_m[1 - axis, axis] < tip_m[axis]
        own, across = (before, after) if low_side else (after, before)
        if np.any(own[along] == cut.opens) or np.any(across[along] != cut.opens):
            return False
    return True


def cut_evidence(
    surfaces: Surfaces, lines: tuple[Lines, Lines], cuts: Sequence[Cut]
) -> tuple[Surfaces, tuple[Lines, Lines]]:
    """The evidence without what was seen in the corners that are cut off."""
    if not cuts:
        return surfaces, lines
    walls_m, wall_segments, kept_lines = [], [], []
    for axis in (0, 1):
        kept = ~_in_corners(surfaces.walls_m[axis], lines[axis], axis, cuts)
        walls_m.append(surfaces.walls_m[axis][kept])
        wall_segments.append(surfaces.wall_segments[axis][kept])
        kept_lines.append(replace(lines[axis], surfel_line=lines[axis].surfel_line[kept]))
    levels = [
        points_m[~np.any([cut.corner.contains(points_m[:, :2]) for cut in cuts], axis=0)]
        for points_m in (surfaces.floor_m, surfaces.ceiling_m, surfaces.stray_m, surfaces.vault_m)
    ]
    surfaces = replace(
        surfaces,
        walls_m=(walls_m[0], walls_m[1]),
        wall_segments=(wall_segments[0], wall_segments[1]),
        floor_m=levels[0],
        ceiling_m=levels[1],
        stray_m=levels[2],
        vault_m=levels[3],
    )
    return surfaces, (kept_lines[0], kept_lines[1])


def _in_corners(
    wall_m: Float[np.ndarray, "n 3"], lines: Lines, axis: int, cuts: Sequence[Cut]
) -> Bool[np.ndarray, " n"]:
    inside = np.zeros(len(wall_m), bool)
    for cut in cuts:
        chords_m = np.array([cut.corner.chord_m(axis, at_m) for at_m in lines.offsets_m])
        own: Int[np.ndarray, " n"] = lines.surfel_line
        along_m = wall_m[:, 1 - axis]
        inside |= (own >= 0) & (along_m > chords_m[own, 0]) & (along_m < chords_m[own, 1])
    return inside


def neutral(evidence: Evidence, grid: Grid, cuts: Sequence[Cut], config: LabelConfig) -> Evidence:
    """Evidence in which the corners that are cut off say nothing.

    Args:
        evidence: without what was seen there (`cut_evidence`).
        grid: lines of the cells.
        cuts: the corners.
        config: chances of seeing what is there.
    """
    heads = evidence.heads
    walls = list(evidence.walls)
    seen, unseen = log_odds(np.array([1.0, 0.0]), config.wall_between, config.wall_elsewhere)
    for cut in cuts:
        heads = np.minimum(heads + cut.cells(grid), 1.0)
        for axis in (0, 1):
            ends_m = grid[1 - axis]
            chords_m = np.array([cut.corner.chord_m(axis, at_m) for at_m in grid[axis]])
            inner_m = np.minimum(ends_m[1:], chords_m[:, 1:]) - np.maximum(ends_m[:-1], chords_m[:, :1])
            # A border that was not seen speaks against a wall: this much seen makes up for it.
            silent = np.maximum(inner_m, 0.0) / np.diff(ends_m) * -unseen / (seen - unseen)
            walls[axis] = walls[axis] + np.moveaxis(silent, 0, axis)
    return replace(evidence, heads=heads, walls=(walls[0], walls[1]))
