"""A step, or one wall that was seen twice: walls that face the same way, nearer than the scan is good.

In a scan whose frames do not quite fit together one wall is seen in two places, and two candidates stand for
it. What tells it from a wall with a step is how far apart the places are, and whether the riser between them
was seen. One wall for both costs what their distance says, the second wall costs its position, and the riser
counts as every wall of the plan does.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float

from .candidates import Lines, worth_two_m
from .labelling import Borders, LabelConfig, log_odds
from .level_task import Grid
from .outline import Wall, walls_of

Pair = tuple[int, int, int]
"""An axis, and two of its lines."""


def doubles(
    rooms: Sequence[Bool[np.ndarray, "nx ny"]],
    lines: tuple[Lines, Lines],
    seen: tuple[Float[np.ndarray, "nx1 ny"], Float[np.ndarray, "nx ny1"]],
    forced: Borders,
    scatter_m: float,
    price: float,
    config: LabelConfig,
) -> list[Pair]:
    """Pairs of candidates that are likelier one wall than two.

    Args:
        rooms: cells of each room.
        lines: candidates across x and across y.
        seen: shares of the borders on which wall was seen.
        forced: borders that a person said are wall.
        scatter_m: standard deviation of where one surface was seen.
        price: of one more position, nats.
        config: chances of seeing what is there.

    Returns:
        disjoint pairs, the nearest first.
    """
    grid: Grid = (lines[0].offsets_m, lines[1].offsets_m)
    apart_m = worth_two_m(scatter_m, price)
    evidence: dict[Pair, float] = {}
    for room, mask in enumerate(rooms):
        walls = walls_of(room, mask)
        for riser in walls:
            pair = 1 - riser.axis, riser.cells.start, riser.cells.stop
            if _is_step(riser, walls) and all(lines[pair[0]].seen[list(pair[1:])]):
                nats = _riser_nats(riser, lines[riser.axis], seen[riser.axis], grid, apart_m, config)
                evidence[pair] = evidence.get(pair, 0.0) + nats
    found: list[Pair] = []
    for pair in sorted(evidence, key=lambda p: _apart_m(p, grid)):
        likelier = (0.5 * _apart_m(pair, grid)) ** 2 + (evidence[pair] - price) * scatter_m**2 < 0.0
        free = all(pair[0] != axis or not {*pair[1:]} & {*others} for axis, *others in found)
        if likelier and free and not _is_forced(pair, forced):
            found.append(pair)
    return found


def _apart_m(pair: Pair, grid: Grid) -> float:
    axis, low, high = pair
    return float(grid[axis][high] - grid[axis][low])


def _is_step(riser: Wall, walls: Sequence[Wall]) -> bool:
    """Whether the walls at both ends of one face the same way."""
    ways = [
        {w.outward for w in walls if w.axis != riser.axis and w.line == end and _meets(w, riser)}
        for end in (riser.cells.start, riser.cells.stop)
    ]
    return bool(ways[0] & ways[1])


def _meets(wall: Wall, riser: Wall) -> bool:
    return riser.line in (wall.cells.start, wall.cells.stop)


def _riser_nats(
    riser: Wall,
    lines: Lines,
    seen: Float[np.ndarray, "_ _"],
    grid: Grid,
    apart_m: float,
    config: LabelConfig,
) -> float:
    """Log likelihood ratio of what was seen of a riser: that it is there, or not.

    It says nothing beside a line of which more was seen, so near that it may be the same wall: a wall that
    was seen twice has a second corner, too.
    """
    near = np.abs(lines.offsets_m - lines.offsets_m[riser.line]) < apart_m
    counts = np.bincount(lines.surfel_line[lines.surfel_line >= 0], minlength=len(near))
    if np.any(counts[near] > counts[riser.line]):
        return 0.0
    # Between two layers of a wall there are surfels of neither, on no wall of any direction.
    share = riser.beside(seen)[riser.line] * lines.seen[riser.line]
    odds = log_odds(share, config.wall_between, config.wall_elsewhere)
    length_m = float(np.sum(np.diff(grid[1 - riser.axis])[riser.cells]))
    # However narrow: what hides it, or stands there instead, hides all of it.
    patches = max(1.0, length_m / config.patch_m)
    return patches * riser.mean(odds, grid)


def _is_forced(pair: Pair, forced: Borders) -> bool:
    borders = np.moveaxis(forced[pair[0]], pair[0], 0)
    return bool(np.any(borders[list(pair[1:])]))
