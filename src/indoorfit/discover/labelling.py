"""Which cells are inside: the most probable labelling of the plan, found exactly."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.errors import ConfigError
from indoorfit.model import Note

from .candidates import Lines
from .evidence import Evidence
from .minimise import PlanEnergy, minimise

Borders = tuple[Bool[np.ndarray, "nx1 ny"], Bool[np.ndarray, "nx ny1"]]
"""A choice among the borders of constant x, and of constant y; the outermost included."""

FORBIDDEN_NATS = 1e5
"""Cost of a forbidden border: the evidence of a storey of 1000 m² is some ten thousand nats."""


@dataclass(frozen=True)
class LabelConfig:
    """Probabilities of seeing something, given what is there; their logarithms are the energy."""

    patch_m: float = 0.3
    """Evidence is counted once per square of this side (once per this length of wall): what hides a
    surface, a lamp or a shelf, is about that large, so finer pixels are not independent."""
    unseen_m: float = 0.5
    """What was not seen of floor and ceiling is counted once per square of this side: a shadow of a
    thing or of a wall's corner, or a place where the path never looked, has one cause and is that large.
    Ceiling that is missing over floor that was seen is no gap, and counts patch by patch."""
    ceiling_inside: float = 0.9
    """Chance that a patch of ceiling over the room was seen: nothing hides it but lamps and gaps."""
    ceiling_outside: float = 0.05
    """Chance that a patch of ceiling outside was seen, through doors and windows."""
    floor_inside: float = 0.6
    """Chance that a patch of the room's floor was seen, between the furniture."""
    floor_outside: float = 0.15
    """Chance that a patch of floor outside was seen: doors reach down to it."""
    wall_between: float = 0.7
    """Chance that a stretch of the room's wall was seen, beside furniture and windows."""
    wall_elsewhere: float = 0.05
    """Chance of wall up to the ceiling where the room does not end: partitions, wardrobes."""
    passed_between: float = 0.05
    """Chance that lines of sight passed, right below the ceiling, a stretch where the room's wall is: tall
    windows, and frames that slipped. Of walls that were not seen these are few: `wall_between` has the
    rest."""
    passed_elsewhere: float = 0.7
    """Chance that they passed it where the room goes on; where they did not, nobody looked, or what stands
    in the room hid it."""
    wall_price: float | None = None
    """Cost in nats of every wall of the outline and of every level; by default, see `price_of_wall` and
    `price_of_one`."""

    max_open_cells: int = 200
    """Cells that the linear relaxation may leave open for branch and bound, which then takes seconds. Scans
    of rooms and storeys leave none; with more open cells the plan is the best that was found, with a
    warning that says how far off it can be."""

    def __post_init__(self) -> None:
        levels = ("ceiling_inside", "ceiling_outside", "floor_inside", "floor_outside")
        walls = ("wall_between", "wall_elsewhere", "passed_between", "passed_elsewhere")
        for name in (*levels, *walls):
            value = getattr(self, name)
            if not 0.0 < value < 1.0:
                raise ConfigError(
                    f"discover.labels.{name}: got {value}; needed a probability between 0 and 1. "
                    "Fix: leave it out for the default."
                )
        if self.wall_price is not None and not self.wall_price >= 0.0:
            raise ConfigError(
                f"discover.labels.wall_price: got {self.wall_price}; needed a price of at least 0. "
                "Fix: leave it out for the default."
            )


def label_cells(
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    price: float,
    config: LabelConfig,
    forbidden: Borders | None = None,
) -> tuple[Bool[np.ndarray, "nx ny"], tuple[Note, ...]]:
    """Minimise the negative log posterior of inside/outside labels over the plan's cells.

    Each cell pays or earns for the ceiling and floor seen over it, each border between inside and
    outside for the wall seen on it, each corner of the outline the price of a wall (an outline has as
    many walls as corners). `minimise` finds the optimum; everything beyond the outermost lines is outside.

    Args:
        evidence: shares seen, see `Evidence`.
        grid: candidate lines, Manhattan frame, metres.
        price: of a wall, nats, see `price_of_wall`.
        config: see `LabelConfig`.
        forbidden: borders of constant x, of constant y, along which no outline may run.
    """
    energy = plan_energy(evidence, grid, price, config, forbidden)
    inside, gap = minimise(energy, config.max_open_cells)
    # A whole wall's price short of the best is worth a warning.
    return inside, (_gap_note(gap),) if gap > price else ()


def plan_energy(
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    price: float,
    config: LabelConfig,
    forbidden: Borders | None = None,
) -> PlanEnergy:
    """The terms of the energy that `label_cells` minimises, nats."""
    widths = [np.diff(line) for line in grid]
    cells = cell_costs(evidence, np.outer(*widths), config)
    borders = []
    for axis in (0, 1):
        along = widths[1][None, :] if axis == 0 else widths[0][:, None]
        cost = -_border_odds(evidence, axis, config)
        cost = cost * along / config.patch_m
        borders.append(cost if forbidden is None else np.where(forbidden[axis], FORBIDDEN_NATS, cost))
    return PlanEnergy(cells, (borders[0], borders[1]), price)


def _border_odds(evidence: Evidence, axis: int, config: LabelConfig) -> Float[np.ndarray, "_ _"]:
    """Log likelihood ratios of the borders of constant `axis`, per patch: the room ends there, or not."""
    seen = evidence.walls[axis]
    odds = log_odds(seen, config.wall_between, config.wall_elsewhere)
    if evidence.free is None:
        return odds
    # What was passed was not seen: it says more than that.
    _, unseen = _odds_of_one(config.wall_between, config.wall_elsewhere)
    passed = float(np.log(config.passed_between / config.passed_elsewhere))
    return odds + evidence.free.walls[axis] * (passed - unseen)


def price_of_one(seen_m2: float, config: LabelConfig) -> float:
    """What one more parameter costs, in nats: half the logarithm of the sample's size (Schwarz 1978).

    Args:
        seen_m2: area of all surfaces that were seen.
        config: see `LabelConfig`.
    """
    if config.wall_price is not None:
        return config.wall_price
    # As many observations as the evidence is counted in.
    return 0.5 * float(np.log(max(seen_m2 / config.patch_m**2, np.e)))


def price_of_wall(lines: tuple[Lines, Lines], config: LabelConfig) -> float:
    """What one more wall of the outline costs, in nats: to name its line among those where wall was seen.

    The lines have their positions already, so a wall is a choice among N of them, and that takes log N
    (Rissanen 1978); the mean over both axes, as the outline turns from one to the other at every corner.
    Lines where only floor or ceiling ends do not count: their number grows with the furniture, not with the
    walls.
    """
    if config.wall_price is not None:
        return config.wall_price
    # A room has two walls of each axis, seen or not.
    return float(np.mean([np.log(max(2, int(np.sum(of_axis.seen)))) for of_axis in lines]))


def _gap_note(gap: float) -> Note:
    return Note(
        "PLAN_NOT_OPTIMAL",
        f"The evidence for walls is too contradictory for the plan to be proved the best: a better one by up "
        f"to {gap:.0f} nats may exist, some walls' worth. Look at it closely; raise "
        "discover.labels.max_open_cells, or cut the scan into parts of a few rooms.",
    )


def log_odds(share: np.ndarray, if_true: float, if_false: float) -> np.ndarray:
    """Log likelihood ratio per patch, of which the share `share` was seen."""
    return share * np.log(if_true / if_false) + (1.0 - share) * np.log((1.0 - if_true) / (1.0 - if_false))


def _odds_of_one(if_true: float, if_false: float) -> tuple[float, float]:
    """Log likelihood ratios of a patch that was seen, and of one that was not."""
    return float(np.log(if_true / if_false)), float(np.log((1.0 - if_true) / (1.0 - if_false)))


def cell_costs(
    evidence: Evidence, area_m2: Float[np.ndarray, "nx ny"], config: LabelConfig
) -> Float[np.ndarray, "nx ny"]:
    """What each cell costs if it is inside, nats: minus the log odds of its ceiling and floor."""
    fine, coarse = area_m2 / config.patch_m**2, area_m2 / config.unseen_m**2
    seen, unseen = _odds_of_one(config.floor_inside, config.floor_outside)
    # What is under a door's head is a doorway's floor or the room's: it says nothing, nor does what the head
    # hides.
    known = 1.0 - evidence.heads
    floor = np.minimum(evidence.floor, known)
    air, overhead = _no_absence(evidence, known)
    gain = floor * fine * seen + (known - np.maximum(floor, air)) * coarse * unseen
    # A scan without any ceiling says nothing by not showing it over a cell.
    if np.any(evidence.ceiling > 0):
        seen, unseen = _odds_of_one(config.ceiling_inside, config.ceiling_outside)
        # Over floor that was seen the missing ceiling is no gap: somebody looked there, and it is a terrace;
        # but for where the look passed no opening and just did not go up.
        ceiling = np.minimum(evidence.ceiling, known)
        absent = known - np.maximum(ceiling, overhead)
        missing = np.minimum(absent, np.maximum(floor - air, 0.0))
        gain += ceiling * fine * seen + (missing * fine + (absent - missing) * coarse) * unseen
    return -gain


def _no_absence(
    evidence: Evidence, known: Float[np.ndarray, "nx ny"]
) -> tuple[Float[np.ndarray, "nx ny"], Float[np.ndarray, "nx ny"]]:
    """Shares of cells where lines of sight passed, so that unseen floor, unseen ceiling say nothing.

    The place is empty, and just not a look at its floor or ceiling. That alone makes it no part of the room:
    a single look through an opening of which neither lintel nor head was seen passes many square metres.
    """
    if evidence.free is None:
        return np.zeros_like(known), np.zeros_like(known)
    return np.minimum(evidence.free.air, known), np.minimum(evidence.free.overhead, known)
