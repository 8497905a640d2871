"""Random rectilinear rooms: a rectangle from which corners, bays and pillars are taken one by one."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from indoorfit.errors import ConfigError
from indoorfit.model import Shape

from .presets import Rectangle, plan_minus_rectangles

_TRIES = 150
"""Cuts tried before starting again from a new rectangle; 14 walls in 3 x 3 m need about 60."""


@dataclass(frozen=True)
class RandomRoomSettings:
    """Limits of random rooms."""

    size_m: tuple[float, float] = (3.0, 8.0)
    """Range of both clear plan extents."""
    height_m: tuple[float, float] = (2.3, 3.2)
    """Range of the clear height."""
    min_step_m: float = 0.15
    """Shortest wall and smallest distance of two parallel walls' lines."""
    min_passage_m: float = 0.7
    """Narrowest part of the room; a person with a scanner must pass."""
    max_cut_share: float = 0.45
    """Largest extent of a cut as a share of the room's."""
    pillars: bool = True
    """Whether pillars may stand free (they count as four walls)."""


DEFAULT_RANDOM_ROOM = RandomRoomSettings()


def random_room(
    rng: np.random.Generator, n_walls: int = 8, settings: RandomRoomSettings = DEFAULT_RANDOM_ROOM
) -> Shape:
    """A random rectilinear room with exactly `n_walls` walls.

    Args:
        rng: decides everything; the same state gives the same room.
        n_walls: even, at least 4; a pillar counts as four.
        settings: limits.

    Returns:
        Manhattan frame, low corner at the origin, floor z = 0.

    Raises:
        ConfigError: `n_walls` is odd or below 4, or does not fit within the limits.
    """
    if n_walls < 4 or n_walls % 2:
        raise ConfigError(
            f"simulate: {n_walls} walls; a rectilinear room has an even number of at least 4. "
            "Fix: choose 4, 6, 8, ..."
        )
    for _ in range(30):
        size_m = np.round(rng.uniform(*settings.size_m, 2), 3)
        cuts = _grow(rng, n_walls, size_m, settings)
        if cuts is not None:
            height_m = round(float(rng.uniform(*settings.height_m)), 3)
            return plan_minus_rectangles(float(size_m[0]), float(size_m[1]), height_m, cuts)
    raise ConfigError(
        f"simulate: found no room with {n_walls} walls of {settings.min_step_m:g} m or more. "
        "Fix: fewer walls, larger rooms, or smaller min_step_m and min_passage_m."
    )


@dataclass(frozen=True)
class _Plan:
    """Cells of a rectangle minus cuts."""

    x_m: Float[np.ndarray, " nx1"]
    y_m: Float[np.ndarray, " ny1"]
    mask: Bool[np.ndarray, "nx ny"]


def _grow(
    rng: np.random.Generator, n_walls: int, size_m: Float[np.ndarray, " 2"], settings: RandomRoomSettings
) -> list[Rectangle] | None:
    cuts: list[Rectangle] = []
    walls = 4
    for _ in range(_TRIES):
        if walls == n_walls:
            return cuts
        candidate = [*cuts, _random_cut(rng, _plan(size_m, cuts), size_m, n_walls - walls, settings)]
        plan = _plan(size_m, candidate)
        grown = _count_walls(plan.mask)
        # A cut that swallows an earlier one lowers the count; one that covers a side changes the size.
        if walls < grown <= n_walls and _is_sound(plan, size_m, settings):
            cuts, walls = candidate, grown
    return None


def _random_cut(
    rng: np.random.Generator,
    plan: _Plan,
    size_m: Float[np.ndarray, " 2"],
    remaining: int,
    settings: RandomRoomSettings,
) -> Rectangle:
    """A corner (two more walls), a bay or a pillar (four more) of random size, not yet checked."""
    low, high = settings.min_step_m, settings.max_cut_share
    dx, dy = (round(float(rng.uniform(low, max(high * s, low * 1.01))), 3) for s in size_m)
    kind = rng.choice(["corner", "corner", "bay", "pillar"])
    if remaining < 4 or kind == "corner":
        corners = _convex_corners(plan)
        x, y, sx, sy = corners[rng.integers(len(corners))]
        return (min(x, x + sx * dx), max(x, x + sx * dx), min(y, y + sy * dy), max(y, y + sy * dy))
    if kind == "pillar" and settings.pillars:
        dx, dy = min(dx, 0.8), min(dy, 0.8)
        x, y = (round(float(rng.uniform(0.0, s - d)), 3) for s, d in zip(size_m, (dx, dy), strict=True))
        return (x, x + dx, y, y + dy)
    x, y = (round(float(rng.uniform(0.0, s - d)), 3) for s, d in zip(size_m, (dx, dy), strict=True))
    side = rng.integers(4)
    if side < 2:
        x = 0.0 if side == 0 else float(size_m[0]) - dx
    else:
        y = 0.0 if side == 2 else float(size_m[1]) - dy
    # Subtraction and addition must meet the wall bitwise, or a sliver of 1e-16 m appears.
    x1 = float(size_m[0]) if side == 1 else x + dx
    y1 = float(size_m[1]) if side == 3 else y + dy
    return (x, x1, y, y1)


def _plan(size_m: Float[np.ndarray, " 2"], cuts: list[Rectangle]) -> _Plan:
    x_m = np.unique([0.0, size_m[0]] + [x for cut in cuts for x in cut[:2]])
    y_m = np.unique([0.0, size_m[1]] + [y for cut in cuts for y in cut[2:]])
    mask = np.ones((len(x_m) - 1, len(y_m) - 1), bool)
    for x0, x1, y0, y1 in cuts:
        (i0, i1), (j0, j1) = np.searchsorted(x_m, (x0, x1)), np.searchsorted(y_m, (y0, y1))
        mask[i0:i1, j0:j1] = False
    return _Plan(x_m, y_m, mask)


def _convex_corners(plan: _Plan) -> list[tuple[float, float, int, int]]:
    """Corners with the room in one quadrant only: x, y and the signs of the way into the room."""
    padded = np.pad(plan.mask, 1)
    found = []
    for i, x in enumerate(plan.x_m):
        for j, y in enumerate(plan.y_m):
            block = padded[i : i + 2, j : j + 2]
            if block.sum() == 1:
                a, b = np.argwhere(block)[0]
                found.append((float(x), float(y), 2 * int(a) - 1, 2 * int(b) - 1))
    return found


def _count_walls(mask: Bool[np.ndarray, "nx ny"]) -> int:
    """Number of straight wall runs: as many as the outline has corners."""
    padded = np.pad(mask, 1).astype(int)
    blocks = padded[:-1, :-1] + padded[1:, :-1] + padded[:-1, 1:] + padded[1:, 1:]
    return int(np.isin(blocks, (1, 3)).sum())


def _is_sound(plan: _Plan, size_m: Float[np.ndarray, " 2"], settings: RandomRoomSettings) -> bool:
    """Connected, full extents, lines far enough apart, no passage too narrow, no cells that only touch."""
    steps = np.concatenate([np.diff(plan.x_m), np.diff(plan.y_m)])
    # 1e-9 m: sums of rounded sizes may fall short of the limit by rounding.
    if steps.min() < settings.min_step_m - 1e-9:
        return False
    if abs(plan.x_m[-1] - size_m[0]) > 0 or plan.x_m[0] < 0 or plan.y_m[0] < 0:
        return False
    if abs(plan.y_m[-1] - size_m[1]) > 0:
        return False
    mask = plan.mask
    sides = (mask[0], mask[-1], mask[:, 0], mask[:, -1])
    if not all(side.any() for side in sides):
        return False
    diagonal = (mask[:-1, :-1] == mask[1:, 1:]) & (mask[1:, :-1] == mask[:-1, 1:])
    diagonal &= mask[:-1, :-1] != mask[1:, :-1]
    if diagonal.any() or ndimage.label(mask)[1] != 1:  # pyright: ignore[reportIndexIssue]
        return False
    return _narrowest_m(plan) >= settings.min_passage_m


def _narrowest_m(plan: _Plan) -> float:
    """Length of the shortest straight run inside the room, along x or y."""
    shortest = np.inf
    for lines_m, rows in ((plan.x_m, plan.mask.T), (plan.y_m, plan.mask)):
        for row in rows:
            edges = np.flatnonzero(np.diff(np.pad(row, 1).astype(int)))
            runs_m = lines_m[edges[1::2]] - lines_m[edges[0::2]]
            shortest = min(shortest, float(runs_m.min(initial=np.inf)))
    return shortest
