"""Which cells are inside: the most probable labelling of the plan, found exactly."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from indoorfit.errors import ConfigError, InputError
from indoorfit.model import Note

from .evidence import Evidence


@dataclass(frozen=True)
class LabelConfig:
    """Probabilities of seeing something, given what is there; their logarithms are the energy."""

    patch_m: float = 0.3
    """Evidence is counted once per square of this side (once per this length of wall): what hides a
    surface, a lamp or a shelf, is about that large, so finer pixels are not independent."""
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
    wall_price: float | None = None
    """Cost of every wall of the outline, for the position that it adds: by default half the logarithm of
    the number of patches of surface that were seen, about 3.5 (Schwarz 1978)."""

    time_limit_s: float = 10.0
    """Seconds for the solver, which needs a fraction of one for a room; a storey of sixteen rooms takes
    minutes to be proved optimal and gets the best plan found until then, with a warning."""

    def __post_init__(self) -> None:
        chances = ("ceiling_inside", "ceiling_outside", "floor_inside", "floor_outside")
        for name in (*chances, "wall_between", "wall_elsewhere"):
            value = getattr(self, name)
            if not 0.0 < value < 1.0:
                raise ConfigError(
                    f"discover.labels.{name}: got {value}; needed a probability between 0 and 1. "
                    "Fix: leave it out for the default."
                )


def label_cells(
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    seen_m2: float,
    config: LabelConfig,
) -> tuple[Bool[np.ndarray, "nx ny"], tuple[Note, ...]]:
    """Minimise the negative log posterior of inside/outside labels over the plan's cells.

    Each cell pays or earns for the ceiling and floor seen over it, each border between inside and
    outside for the wall seen on it, each corner of the outline the price of a wall (an outline has as
    many walls as corners). It is a small integer programme, solved to optimality by HiGHS; everything
    beyond the outermost lines is outside.

    Args:
        evidence: shares seen, see `Evidence`.
        grid: candidate lines, Manhattan frame, metres.
        seen_m2: area of all surfaces that were seen, for the price of a wall.
        config: see `LabelConfig`.
    """
    widths = [np.diff(line) for line in grid]
    cells = -_cell_gain(evidence, np.outer(*widths) / config.patch_m**2, config)
    number = np.pad(np.arange(cells.size).reshape(cells.shape), 1, constant_values=-1)
    pairs, costs = [], []
    for axis in (0, 1):
        along = widths[1][None, :] if axis == 0 else widths[0][:, None]
        cost = -_log_odds(evidence.walls[axis], config.wall_between, config.wall_elsewhere)
        below = number[:-1, 1:-1] if axis == 0 else number[1:-1, :-1]
        above = number[1:, 1:-1] if axis == 0 else number[1:-1, 1:]
        pairs.append(np.stack([below.ravel(), above.ravel()], axis=1))
        costs.append((cost * along / config.patch_m).ravel())
    blocks = [number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]]
    around = np.stack([block.ravel() for block in blocks], axis=1)
    price = config.wall_price
    if price is None:
        # As many observations as the evidence is counted in.
        price = 0.5 * float(np.log(max(seen_m2 / config.patch_m**2, np.e)))
    borders = np.concatenate(pairs), np.concatenate(costs)
    chosen, gap = _solve(cells.ravel(), *borders, around, price, config.time_limit_s)
    # A whole wall's price short of the best is worth a warning.
    notes = (_gap_note(gap, config.time_limit_s),) if gap > price else ()
    return chosen.reshape(cells.shape), notes


def _gap_note(gap: float, limit_s: float) -> Note:
    return Note(
        "PLAN_NOT_OPTIMAL",
        f"The plan is too large to be labelled exactly in {limit_s:.0f} s: a better one by up to {gap:.0f} "
        "nats may exist, some walls' worth. Look at it closely; raise discover.labels.time_limit_s, or cut "
        "the scan into parts of a few rooms.",
    )


def _log_odds(share: np.ndarray, if_true: float, if_false: float) -> np.ndarray:
    """Log likelihood ratio per patch, of which the share `share` was seen."""
    return share * np.log(if_true / if_false) + (1.0 - share) * np.log((1.0 - if_true) / (1.0 - if_false))


def _cell_gain(
    evidence: Evidence, patches: Float[np.ndarray, "nx ny"], config: LabelConfig
) -> Float[np.ndarray, "nx ny"]:
    gain = _log_odds(evidence.floor, config.floor_inside, config.floor_outside)
    # A scan without any ceiling says nothing by not showing it over a cell.
    if np.any(evidence.ceiling > 0):
        gain = gain + _log_odds(evidence.ceiling, config.ceiling_inside, config.ceiling_outside)
    return gain * patches


def _solve(
    cell_costs: Float[np.ndarray, " cells"],
    pairs: Int[np.ndarray, "borders 2"],
    border_costs: Float[np.ndarray, " borders"],
    around: Int[np.ndarray, "vertices 4"],
    corner_price: float,
    time_limit_s: float,
) -> tuple[Bool[np.ndarray, " cells"], float]:
    """min c.x + w.b + price * k  with  b = |x_i - x_j|  and  k = |x_1 - x_2 - x_3 + x_4| at each vertex.

    Index -1 stands for the outside, whose label is 0.
    """
    n_cells, n_borders, n_corners = len(cell_costs), len(pairs), len(around)
    b = n_cells + np.arange(n_borders)
    k = n_cells + n_borders + np.arange(n_corners)
    rows = _Rows(n_cells + n_borders + n_corners)
    # The four facets of b = |x_i - x_j|: two hold it up, two hold it down where wall is rewarded.
    for first, second, border, upper in ((1, -1, -1, 0), (-1, 1, -1, 0), (-1, -1, 1, 0), (1, 1, 1, 2)):
        rows.add([(pairs[:, 0], first), (pairs[:, 1], second), (b, border)], upper)
    # The price holds k down. A straight wall through a vertex gives 0, a corner 1, touching corners 2.
    for sign in (1, -1):
        signed = [(around[:, q], sign * s) for q, s in enumerate((1, -1, -1, 1))]
        rows.add([*signed, (k, -1)], 0)
    costs = np.concatenate([cell_costs, border_costs, np.full(n_corners, corner_price)])
    upper = np.concatenate([np.ones(n_cells + n_borders), np.full(n_corners, 2.0)])
    # Borders and corners are whole numbers by themselves once the cells are.
    whole = np.concatenate([np.ones(n_cells), np.zeros(n_borders + n_corners)])
    result = milp(
        costs,
        integrality=whole,
        bounds=Bounds(0, upper),  # pyright: ignore[reportArgumentType]
        constraints=rows.constraint(),
        options={"mip_rel_gap": 1e-4, "time_limit": time_limit_s},
    )
    if result.x is None:
        raise InputError(
            f"discover: {len(cell_costs)} cells of the plan could not be labelled in {time_limit_s:.0f} s. "
            "Fix: raise discover.labels.time_limit_s, or cut the scan into parts of a few rooms."
        )
    return result.x[:n_cells] > 0.5, float(result.fun - result.mip_dual_bound)


class _Rows:
    """Collects sparse inequality rows."""

    def __init__(self, n_columns: int):
        self.n_columns = n_columns
        self.row: list[np.ndarray] = []
        self.column: list[np.ndarray] = []
        self.value: list[np.ndarray] = []
        self.upper: list[np.ndarray] = []
        self.n_rows = 0

    def add(self, terms: list[tuple[np.ndarray, int]], upper: int) -> None:
        """Append one block of rows: the sum of columns times factors is at most `upper`."""
        n = len(terms[0][0])
        for columns, factor in terms:
            kept = columns >= 0
            self.row.append(self.n_rows + np.flatnonzero(kept))
            self.column.append(columns[kept])
            self.value.append(np.full(int(kept.sum()), float(factor)))
        self.upper.append(np.full(n, upper))
        self.n_rows += n

    def constraint(self) -> LinearConstraint:
        """All rows as one constraint."""
        matrix = coo_array(
            (np.concatenate(self.value), (np.concatenate(self.row), np.concatenate(self.column))),
            shape=(self.n_rows, self.n_columns),
        )
        return LinearConstraint(matrix.tocsr(), -np.inf, np.concatenate(self.upper))  # pyright: ignore
