"""The walls of the rooms in the plan, and how they are moved."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool
from scipy import ndimage

from .level_task import Grid, refined


@dataclass(frozen=True)
class Wall:
    """A straight piece of one room's outline, on some grid."""

    room: int
    axis: int
    """Across x (0) or y (1)."""
    outward: int
    """+1 or -1: the direction along `axis` that leaves the room."""
    line: int
    """Of the grid."""
    cells: slice
    """Of the grid, along the other axis."""

    def beside(self, values: np.ndarray) -> np.ndarray:
        """Borders or cells along the wall only, its own axis first."""
        return np.moveaxis(values, self.axis, 0)[:, self.cells]

    def mean(self, shares: np.ndarray, grid: Grid) -> float:
        """Mean of shares of the cells, or borders, along the wall, by length."""
        widths_m = np.diff(grid[1 - self.axis])[self.cells]
        return float(np.average(shares, weights=widths_m))

    def on(self, finer: Grid, grid: Grid) -> "Wall":
        """The same wall on a grid that has all lines of its own and others."""
        line = int(np.searchsorted(finer[self.axis], grid[self.axis][self.line]))
        ends_m = grid[1 - self.axis][[self.cells.start, self.cells.stop]]
        low, high = np.searchsorted(finer[1 - self.axis], ends_m)
        return replace(self, line=line, cells=slice(int(low), int(high)))


@dataclass(frozen=True)
class Place:
    """Where a wall that nobody saw is put, and how well that is known."""

    offset_m: float
    std_m: float


@dataclass(frozen=True)
class Outline:
    """The cells of the rooms, with the walls that nobody saw at their places."""

    grid: Grid
    rooms: list[Bool[np.ndarray, "nx ny"]]
    moved: tuple[tuple[Wall, Place], ...] = ()
    """The walls that nobody saw, on the grid before, and where they are now; some could not be moved."""

    def doubt_m(self, room: int, axis: int, outward: int, offset_m: float) -> float:
        """Standard uncertainty of a room's walls at a place, as far as it is a guess."""
        own = (room, axis, outward, offset_m)
        found = [p.std_m for w, p in self.moved if (w.room, w.axis, w.outward, p.offset_m) == own]
        return max(found, default=0.0)


def walls_of(room: int, cells: Bool[np.ndarray, "nx ny"]) -> list[Wall]:
    """All walls of a room that has these cells."""
    found = []
    for axis in (0, 1):
        steps = np.diff(np.moveaxis(np.pad(cells, 1), axis, 0)[:, 1:-1].astype(int), axis=0)
        for outward in (-1, 1):
            for line in range(len(steps)):
                pieces, _ = ndimage.label(steps[line] == -outward)  # type: ignore[misc]
                found += [Wall(room, axis, outward, line, piece) for (piece,) in ndimage.find_objects(pieces)]
    return found


def n_corners(cells: Bool[np.ndarray, "nx ny"]) -> int:
    """Corners of the outline of some cells; two where corners touch."""
    return int(np.abs(np.diff(np.diff(np.pad(cells, 1).astype(int), axis=0), axis=1)).sum())


def with_moved(
    rooms: Sequence[Bool[np.ndarray, "nx ny"]], grid: Grid, moves: Sequence[tuple[Wall, Place]]
) -> Outline:
    """Move walls, one after the other: the ends of each follow those that meet it.

    A move that would make or lose a corner, part the room, or run into another one, because another wall was
    moved before, is left out; so is that of a wall that is gone. A wall that so stays is no better known for
    it: its doubt reaches over the place it was to have. That is lost where another wall shares its line.

    Args:
        rooms: cells of each room.
        grid: lines of the cells.
        moves: walls on this grid, and where to.
    """
    places_m = [[place.offset_m for wall, place in moves if wall.axis == axis] for axis in (0, 1)]
    finer: Grid = (np.unique([*grid[0], *places_m[0]]), np.unique([*grid[1], *places_m[1]]))
    masks, moved = [refined(mask, grid, finer) for mask in rooms], []
    for wall, place in moves:
        mask = masks[wall.room].copy()
        now = _followed(wall.on(finer, grid), walls_of(wall.room, mask))
        if now is None:
            continue
        to = int(np.searchsorted(finer[wall.axis], place.offset_m))
        now.beside(mask)[min(now.line, to) : max(now.line, to)] = (to - now.line) * wall.outward > 0
        free = not any(np.any(mask & other) for room, other in enumerate(masks) if room != wall.room)
        if free and n_corners(mask) == n_corners(masks[wall.room]) and _in_one_piece(mask):
            masks[wall.room] = mask
            moved.append((wall, place))
        elif not _shares_its_line(now, walls_of(wall.room, masks[wall.room])):
            line_m = float(finer[wall.axis][now.line])
            moved.append((wall, Place(line_m, float(np.hypot(place.std_m, place.offset_m - line_m)))))
    return Outline(finer, masks, tuple(moved))


def _shares_its_line(wall: Wall, walls: Sequence[Wall]) -> bool:
    """Whether another wall of the room lies on one's line: a plane has one uncertainty."""
    return sum((other.axis, other.line) == (wall.axis, wall.line) for other in walls) > 1


def _in_one_piece(cells: Bool[np.ndarray, "nx ny"]) -> bool:
    return ndimage.label(cells)[1] == 1  # type: ignore[misc]


def _followed(wall: Wall, walls: Sequence[Wall]) -> Wall | None:
    """What has become of a wall whose ends have moved: the one on its line that shares most cells with it."""
    same = [other for other in walls if replace(other, cells=wall.cells) == wall]
    shared = [min(o.cells.stop, wall.cells.stop) - max(o.cells.start, wall.cells.start) for o in same]
    return same[int(np.argmax(shared))] if max(shared, default=0) > 0 else None
