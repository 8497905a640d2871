"""Whether a level is part of the building: worth its price, parted by a jump, and no furniture."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from .level_task import Grid, Kind, LevelConfig
from .risers import jumps_m


@dataclass(frozen=True)
class Look:
    """What the scan shows of one height over a room's plan."""

    on: Kind
    mask: Bool[np.ndarray, "nx ny"]
    """The room's cells."""
    grid: Grid
    here_m: Float[np.ndarray, "n 3"]
    """Surfels at the height."""
    others_m: Float[np.ndarray, "m 3"]
    """Surfels of the floor (ceiling) at other heights."""
    rise_m: float
    """Distance from the main level."""
    gain: Float[np.ndarray, "nx ny"]
    """Of a cell at this height: log odds of what is seen there, at it and at other heights."""
    side_gain: tuple[Float[np.ndarray, "nx0 ny"], Float[np.ndarray, "nx ny0"]] | None
    """Of a side of the level on each inner border; None where the rise is too small to show one."""
    pixel_m: float
    price: float
    """Of one parameter, nats."""


def is_building(piece: Bool[np.ndarray, "nx ny"], look: Look, config: LevelConfig) -> bool:
    """Judge one connected piece of a level."""
    free = _free_sides(piece, look.mask)
    # The level itself is one parameter, each free side another. Upright faces help to place a level, but
    # it must be worth its price by what is seen of itself.
    if float(look.gain[piece].sum()) <= look.price * (1 + sum(free)):
        return False
    widths = [np.diff(line) for line in look.grid]
    area_m2 = float(widths[0] @ piece @ widths[1])
    extents_m = [float(w[piece.any(axis=1 - a)].sum()) for a, w in enumerate(widths)]
    # Less than two rows of pixels cannot be told from the scatter of an edge.
    if area_m2 < max(config.min_area_m2, 1.5 * look.pixel_m * max(extents_m)):
        return False
    # A surface that slopes has levels without a jump between them.
    jump_m = jumps_m(piece, look.mask, look.grid, look.here_m, look.others_m)
    if len(jump_m) and float(np.median(jump_m)) < config.step_m:
        return False
    spans = not (free[0] or free[1]) or not (free[2] or free[3])
    stands_free = all(free) or look.rise_m > config.max_rise_m or min(extents_m) < config.walkable_m
    if look.on == "floor" and not spans and stands_free:
        return False
    # What reaches from wall to wall rests on them; anything else must be seen to hang or stand.
    return spans or _joined(piece, look)


def _joined(piece: Bool[np.ndarray, "nx ny"], look: Look) -> bool:
    """Whether the faces between the level and the main one are worth a parameter: else it hangs free."""
    if look.side_gain is None:
        return False
    sides = _borders(piece, look.mask)
    return sum(float(gain[side].sum()) for gain, side in zip(look.side_gain, sides, strict=True)) > look.price


def _borders(
    piece: Bool[np.ndarray, "nx ny"], mask: Bool[np.ndarray, "nx ny"]
) -> tuple[Bool[np.ndarray, "nx0 ny"], Bool[np.ndarray, "nx ny0"]]:
    """Inner borders, of constant x and of constant y, between a piece and other cells of the room."""
    rest = mask & ~piece
    across_x = (piece[1:] & rest[:-1]) | (rest[1:] & piece[:-1])
    across_y = (piece[:, 1:] & rest[:, :-1]) | (rest[:, 1:] & piece[:, :-1])
    return across_x, across_y


def _free_sides(piece: Bool[np.ndarray, "nx ny"], mask: Bool[np.ndarray, "nx ny"]) -> tuple[bool, ...]:
    """Whether the piece ends within the room towards -x, +x, -y and +y."""
    rest = mask & ~piece
    return (
        bool((piece[1:] & rest[:-1]).any()),
        bool((rest[1:] & piece[:-1]).any()),
        bool((piece[:, 1:] & rest[:, :-1]).any()),
        bool((rest[:, 1:] & piece[:, :-1]).any()),
    )
