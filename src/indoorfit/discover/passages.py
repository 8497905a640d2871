"""Doors between rooms: where the inside of the plan is narrow and wall goes on at both sides."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from .evidence import Evidence


@dataclass(frozen=True)
class Passage:
    """What a way through a wall is."""

    door_m: float
    """Greatest clear width."""
    wall_m: float
    """Greatest thickness of the wall."""
    lintel_share: float
    """Least share of the lintel that was seen."""


def open_borders(
    inside: Bool[np.ndarray, "nx ny"],
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    partition_share: float,
    door_m: float,
) -> tuple[Bool[np.ndarray, "nx_1 ny"], Bool[np.ndarray, "nx ny_1"]]:
    """Borders between two inside cells that are neither partition nor door.

    Args:
        inside: labels of cells.
        evidence: shares seen.
        grid: candidate lines, metres.
        partition_share: least share of wall on a partition, of lintel over a door.
        door_m: clear width up to which an opening with a lintel is a door; a wider one is under a beam.
    """
    across_x, across_y = (walls >= partition_share for walls in evidence.walls)
    if evidence.free is not None:
        # Where most of the stretch under the ceiling was passed, it is a cupboard's side or front.
        across_x, across_y = (
            across_x & (evidence.free.over[0] < 0.5),
            across_y & (evidence.free.over[1] < 0.5),
        )
    open_x = inside[1:] & inside[:-1] & ~across_x[1:-1]
    open_y = inside[:, 1:] & inside[:, :-1] & ~across_y[:, 1:-1]
    _shut_doors(open_x, evidence.lintels[0][1:-1], grid[1], partition_share, door_m)
    _shut_doors(open_y.T, evidence.lintels[1][:, 1:-1].T, grid[0], partition_share, door_m)
    return open_x, open_y


def _shut_doors(
    links: Bool[np.ndarray, "lines cells"],
    lintels: Float[np.ndarray, "lines cells"],
    along_m: Float[np.ndarray, " cells1"],
    share: float,
    door_m: float,
) -> None:
    """Take away, in place, the links under a lintel."""
    for links_of_line, seen in zip(links, lintels, strict=True):
        steps = np.diff(np.pad(links_of_line.astype(int), 1))
        for start, end in zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True):
            widths_m = np.diff(along_m[start : end + 1])
            if widths_m.sum() <= door_m and np.average(seen[start:end], weights=widths_m) >= share:
                links_of_line[start:end] = False


def pieces_of(
    inside: Bool[np.ndarray, "nx ny"],
    links: tuple[Bool[np.ndarray, "nx_1 ny"], Bool[np.ndarray, "nx ny_1"]],
) -> Int[np.ndarray, "nx ny"]:
    """Number of the linked piece that each cell belongs to; 0 outside."""
    # Cells at even, borders at odd positions of a doubled grid, so that a wall can cut between cells.
    doubled = np.zeros([2 * n - 1 for n in inside.shape], bool)
    doubled[::2, ::2] = inside
    doubled[1::2, ::2], doubled[::2, 1::2] = links
    labels, _ = ndimage.label(doubled)  # pyright: ignore[reportGeneralTypeIssues]
    return labels[::2, ::2]


def close_passages(
    inside: Bool[np.ndarray, "nx ny"],
    links: tuple[Bool[np.ndarray, "nx_1 ny"], Bool[np.ndarray, "nx ny_1"]],
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    limits: Passage,
    room_m2: float,
) -> Bool[np.ndarray, "nx ny"]:
    """The inside without the reveals of doors that part it into rooms.

    A passage through a wall is a block of inside cells of limited depth and width, with no inside at either
    flank, inside at both ends, and a lintel over one of them. It is closed if two pieces of at least
    `room_m2` fall apart: the neck between two pillars, or before a niche, stays.

    Args:
        inside: labels of cells.
        links: borders across which cells belong together.
        evidence: shares seen.
        grid: candidate lines, metres.
        limits: what a passage is.
        room_m2: least area of a room.
    """
    areas_m2 = np.outer(np.diff(grid[0]), np.diff(grid[1]))
    kept = inside.copy()
    for axis in (0, 1):
        # Views: what is changed in `turned` changes `kept`.
        turned, lines = np.moveaxis(kept, axis, 0), (grid[axis], grid[1 - axis])
        lintels = np.moveaxis(evidence.lintels[axis], axis, 0)
        for block in list(_blocks(turned, lines, limits)):
            before = turned[block].copy()
            if not before.all():
                continue  # part of a passage that was closed already
            if not _under_lintel(lintels, lines[1], block, limits.lintel_share):
                continue
            whole = _large(kept, links, areas_m2, room_m2)
            turned[block] = False
            if _large(kept, links, areas_m2, room_m2) <= whole:
                turned[block] = before
    return kept


def _under_lintel(
    lintels: Float[np.ndarray, "n1 m"],
    along_m: Float[np.ndarray, " m1"],
    block: tuple[slice, slice],
    least_share: float,
) -> bool:
    """Whether a lintel was seen over one of a passage's two ends."""
    through, along = block
    widths_m = np.diff(along_m)[along]
    shares = [np.average(lintels[line, along], weights=widths_m) for line in (through.start, through.stop)]
    return bool(max(shares) >= least_share)


def _large(
    inside: Bool[np.ndarray, "nx ny"],
    links: tuple[Bool[np.ndarray, "nx_1 ny"], Bool[np.ndarray, "nx ny_1"]],
    areas_m2: Float[np.ndarray, "nx ny"],
    room_m2: float,
) -> int:
    """Number of pieces as large as a room."""
    still = links[0] & inside[1:] & inside[:-1], links[1] & inside[:, 1:] & inside[:, :-1]
    pieces = pieces_of(inside, still)
    sizes_m2 = np.bincount(pieces.ravel(), areas_m2.ravel())[1:]
    return int(np.sum(sizes_m2 >= room_m2))


def _blocks(
    inside: Bool[np.ndarray, "n m"],
    lines: tuple[Float[np.ndarray, " n1"], Float[np.ndarray, " m1"]],
    limits: Passage,
) -> Iterator[tuple[slice, slice]]:
    """Passages along the first axis, thinnest walls first."""
    n = inside.shape[0]
    ends = [(i0, i1) for i0 in range(1, n - 1) for i1 in range(i0 + 1, n)]
    ends = [(i0, i1) for i0, i1 in ends if lines[0][i1] - lines[0][i0] <= limits.wall_m]
    ends.sort(key=lambda pair: (lines[0][pair[1]] - lines[0][pair[0]], pair))
    for i0, i1 in ends:
        through = inside[i0:i1].all(axis=0)
        some = np.pad(inside[i0:i1].any(axis=0), 1)
        steps = np.diff(np.pad(through.astype(int), 1))
        for j0, j1 in zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True):
            flanked = not some[j0] and not some[j1 + 1]
            joins = inside[i0 - 1, j0:j1].any() and inside[i1, j0:j1].any()
            if flanked and joins and lines[1][j1] - lines[1][j0] <= limits.door_m:
                yield slice(i0, i1), slice(int(j0), int(j1))
