"""Where a wall that nobody saw may stand, and how well that is known.

The plan of least energy puts such a wall on a candidate, but it may stand anywhere in the shadow that hides it:
from where floor, ceiling or another wall were seen last to where the room would get another shape. What was
not seen there says nothing of the place, as all places in a shadow are equally dark; what was seen counts as
in the plan. With the same prior for all places their probabilities are those of the energy, exp(-E); the wall
is put at their mean, the place of least expected square error, with their standard deviation.

Where floor or ceiling end at the candidate along most of the wall, that is no shadow but the wall, and its
place was measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from .candidates import Lines
from .evidence import Evidence, FreeShares, cell_coverage, gather_evidence
from .free_space import FreeSpace
from .labelling import Borders, LabelConfig, cell_costs
from .level_task import Grid, refined
from .minimise import PlanEnergy
from .surfaces import Surfaces

_ENDS = 0.5
"""Along more than this share of a wall floor or ceiling must end for its place to count as measured."""


@dataclass(frozen=True)
class Guess:
    """The place of a wall that nobody saw."""

    axis: int
    """Across x (0) or y (1)."""
    offset_m: float
    std_m: float


@dataclass(frozen=True)
class Outline:
    """The cells of the rooms, with the walls that nobody saw at their likeliest places."""

    grid: Grid
    rooms: list[Bool[np.ndarray, "nx ny"]]
    guesses: tuple[Guess, ...] = ()

    def doubt_m(self, axis: int, offset_m: float) -> float:
        """Standard uncertainty of a wall's place, as far as it is a guess."""
        found = [g.std_m for g in self.guesses if g.axis == axis and g.offset_m == offset_m]
        return max(found, default=0.0)


@dataclass(frozen=True)
class _Wall:
    """A straight piece of one room's outline."""

    room: int
    axis: int
    outward: int
    line: int
    """Of the grid."""
    cells: slice
    """Along the other axis."""


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
        config: chances of seeing what is there. A wall of which less is seen than of walls where none are was
            not seen.
    """
    grid: Grid = (lines[0].offsets_m, lines[1].offsets_m)
    walls = [
        wall
        for room, mask in enumerate(rooms)
        for wall in _walls(room, mask)
        if _seen_share(wall, evidence, grid) < config.wall_elsewhere and not np.any(_along(settled[wall.axis], wall)[wall.line])
    ]
    if not walls:
        return Outline(grid, list(rooms))
    shadows = _Shadows(_finer(lines, {wall.axis for wall in walls}, step_m), surfaces, free, config)
    masks = [refined(mask, grid, shadows.grid) for mask in rooms]
    guessed = [(wall, _guess(_on(shadows.grid, grid, wall), masks, shadows)) for wall in walls]
    return _rebuilt(rooms, grid, [(wall, guess) for wall, guess in guessed if guess is not None])


def _walls(room: int, mask: Bool[np.ndarray, "nx ny"]) -> list[_Wall]:
    found = []
    for axis in (0, 1):
        steps = np.diff(np.moveaxis(np.pad(mask, 1), axis, 0)[:, 1:-1].astype(int), axis=0)
        for outward in (-1, 1):
            for line in range(len(steps)):
                pieces, _ = ndimage.label(steps[line] == -outward)  # type: ignore[misc]
                found += [
                    _Wall(room, axis, outward, line, cells) for (cells,) in ndimage.find_objects(pieces)
                ]
    return found


def _along(borders: np.ndarray, wall: _Wall) -> np.ndarray:
    """Borders or cells, with the lines or cells across the wall first, beside the wall only."""
    return np.moveaxis(borders, wall.axis, 0)[:, wall.cells]


def _seen_share(wall: _Wall, evidence: Evidence, grid: Grid) -> float:
    widths_m = np.diff(grid[1 - wall.axis])[wall.cells]
    return float(np.average(_along(evidence.walls[wall.axis], wall)[wall.line], weights=widths_m))


def _finer(lines: tuple[Lines, Lines], axes: set[int], step_m: float) -> tuple[Lines, Lines]:
    """The candidates, and the places between them that walls across these axes are tried at."""
    finer = list(lines)
    for axis in axes:
        offsets_m = lines[axis].offsets_m
        between = [
            np.linspace(low, high, max(1, int((high - low) / step_m)), endpoint=False)[1:]
            for low, high in zip(offsets_m[:-1], offsets_m[1:], strict=True)
        ]
        finer[axis] = lines[axis].with_unseen(np.concatenate(between))
    return finer[0], finer[1]


class _Shadows:
    """What was seen, on a finer grid; what was not seen costs and earns nothing."""

    def __init__(
        self, lines: tuple[Lines, Lines], surfaces: Surfaces, free: FreeSpace | None, config: LabelConfig
    ):
        self.grid: Grid = (lines[0].offsets_m, lines[1].offsets_m)
        self.evidence = gather_evidence(surfaces, lines)
        if free is not None:
            overhead, air = (
                cell_coverage(passed_m, self.grid, surfaces) for passed_m in (free.overhead_m, free.air_m)
            )
            self.evidence = replace(
                self.evidence,
                ceiling=np.maximum(self.evidence.ceiling, overhead),
                floor=np.maximum(self.evidence.floor, air),
            )
        widths = [np.diff(line) for line in self.grid]
        everywhere = np.ones_like(self.evidence.floor)
        looked = FreeShares(everywhere, everywhere, self.evidence.walls, self.evidence.walls)
        cells = cell_costs(replace(self.evidence, free=looked), np.outer(*widths), config)
        seen = float(np.log(config.wall_between / config.wall_elsewhere))
        x, y = (-seen * share / config.patch_m for share in self.evidence.walls)
        self.energy = PlanEnergy(cells, (x * widths[1][None, :], y * widths[0][:, None]), 0.0)

    def ends_at(self, wall: _Wall) -> bool:
        """Whether floor or ceiling end at a wall of this grid along most of it."""
        widths_m = np.diff(self.grid[1 - wall.axis])[wall.cells]
        for level in (self.evidence.floor, self.evidence.ceiling):
            padded = np.pad(np.moveaxis(level, wall.axis, 0), ((1, 1), (0, 0)))[:, wall.cells]
            drop = wall.outward * (padded[wall.line] - padded[wall.line + 1])
            if np.average(drop, weights=widths_m) > _ENDS:
                return True
        return False


def _guess(wall: _Wall, masks: Sequence[Bool[np.ndarray, "nx ny"]], shadows: _Shadows) -> Guess | None:
    """The mean of the places of one wall on the finer grid; None where it was measured or cannot move."""
    if shadows.ends_at(wall):
        return None
    inside = np.logical_or.reduce(list(masks))
    places = _places(wall, inside, np.moveaxis(masks[wall.room], wall.axis, 0).any(axis=1))
    where_m = shadows.grid[wall.axis][list(places)]
    nats = np.array([shadows.energy.of(labels) for labels in places.values()])
    order = np.argsort(where_m)
    where_m, nats = where_m[order], nats[order]
    if len(where_m) == 1:
        return None
    weight = np.gradient(where_m) * np.exp(nats.min() - nats)
    weight /= weight.sum()
    mean_m = float(weight @ where_m)
    std_m = float(np.sqrt(weight @ (where_m - mean_m) ** 2))
    return Guess(wall.axis, mean_m, std_m) if std_m > 0.0 else None


def _places(
    wall: _Wall, inside: Bool[np.ndarray, "nx ny"], own: Bool[np.ndarray, " cells"]
) -> dict[int, Bool[np.ndarray, "nx ny"]]:
    """Lines that the wall can be moved to, and the labels with the wall there.

    Args:
        wall: on the grid of the labels.
        inside: labels of all rooms.
        own: the cells across the wall that its room has.
    """
    n_corners = _n_corners(inside)
    places = {wall.line: inside}
    across = np.moveaxis(inside, wall.axis, 0)[:, wall.cells]
    # Smaller cubes are taken away from one large one: their walls lie in it.
    low, high = int(np.argmax(own)), len(own) - int(np.argmax(own[::-1]))
    beyond = wall.line if wall.outward > 0 else wall.line - 1
    if low <= beyond < high and np.any(across[beyond]):
        return places
    for way in (1, -1):
        line, joins = wall.line, way == wall.outward
        while low <= line + way <= high:
            cell = line if way > 0 else line - 1
            if np.any(across[cell] == joins):
                break
            labels = places[line].copy()
            np.moveaxis(labels, wall.axis, 0)[cell, wall.cells] = joins
            line += way
            places[line] = labels
            # Another number of corners is another room: where it changes is the last place of this one.
            if _n_corners(labels) != n_corners:
                break
    return places


def _rebuilt(
    rooms: Sequence[Bool[np.ndarray, "nx ny"]], grid: Grid, placed: Sequence[tuple[_Wall, Guess]]
) -> Outline:
    """The outline with walls moved, one after the other: the ends of each follow those that meet it."""
    more = [[guess.offset_m for _, guess in placed if guess.axis == axis] for axis in (0, 1)]
    finer: Grid = (np.unique([*grid[0], *more[0]]), np.unique([*grid[1], *more[1]]))
    masks, guesses = [refined(mask, grid, finer) for mask in rooms], []
    for wall, guess in placed:
        mask = masks[wall.room]
        now = _followed(_on(finer, grid, wall), _walls(wall.room, mask))
        to = int(np.searchsorted(finer[guess.axis], guess.offset_m))
        moved = mask.copy()
        strip = slice(min(now.line, to), max(now.line, to))
        np.moveaxis(moved, wall.axis, 0)[strip, now.cells] = (to - now.line) * wall.outward > 0
        if _n_corners(moved) == _n_corners(mask):
            masks[wall.room] = moved
            guesses.append(guess)
    return Outline(finer, masks, tuple(guesses))


def _followed(wall: _Wall, walls: Sequence[_Wall]) -> _Wall:
    """What has become of a wall: the one on its line that shares most cells with it."""
    same = [other for other in walls if replace(other, cells=wall.cells) == wall]
    return max(same, key=lambda o: min(o.cells.stop, wall.cells.stop) - max(o.cells.start, wall.cells.start))


def _on(fine: Grid, grid: Grid, wall: _Wall) -> _Wall:
    """The same wall on a finer grid."""
    line = int(np.searchsorted(fine[wall.axis], grid[wall.axis][wall.line]))
    along_m = grid[1 - wall.axis]
    low, high = np.searchsorted(fine[1 - wall.axis], [along_m[wall.cells.start], along_m[wall.cells.stop]])
    return replace(wall, line=line, cells=slice(int(low), int(high)))


def _n_corners(inside: Bool[np.ndarray, "nx ny"]) -> int:
    return int(np.abs(np.diff(np.diff(np.pad(inside, 1).astype(int), axis=0), axis=1)).sum())
