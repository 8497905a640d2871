"""Which cells are inside: the most probable labelling of the plan, found exactly."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

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
    line_price: float = 5.0
    """Cost of every candidate line that the outline uses: half the logarithm of the number of surfels,
    about 5 (10 000 to 40 000 of them), for the position that it adds (Schwarz 1978)."""


def label_cells(
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    config: LabelConfig,
) -> Bool[np.ndarray, "nx ny"]:
    """Minimise the negative log posterior of inside/outside labels over the plan's cells.

    Each cell pays or earns for the ceiling and floor seen over it, each border between inside and
    outside for the wall seen on it, each candidate line that is used pays its price. It is a small
    integer programme, solved to optimality by HiGHS; everything beyond the outermost lines is outside.

    Args:
        evidence: shares seen, see `Evidence`.
        grid: candidate lines, Manhattan frame, metres.
        config: see `LabelConfig`.
    """
    widths = [np.diff(line) for line in grid]
    cells = -_cell_gain(evidence, np.outer(*widths) / config.patch_m**2, config)
    n_cells = cells.size
    number = np.pad(np.arange(n_cells).reshape(cells.shape), 1, constant_values=-1)
    pairs, costs, used_line = [], [], []
    for axis, offset in ((0, 0), (1, len(grid[0]))):
        along = widths[1][None, :] if axis == 0 else widths[0][:, None]
        cost = -_log_odds(evidence.walls[axis], config.wall_between, config.wall_elsewhere)
        cost = cost * along / config.patch_m
        below = number[:-1, 1:-1] if axis == 0 else number[1:-1, :-1]
        above = number[1:, 1:-1] if axis == 0 else number[1:-1, 1:]
        pairs.append(np.stack([below.ravel(), above.ravel()], axis=1))
        costs.append(cost.ravel())
        line = np.indices(cost.shape)[axis]
        used_line.append(line.ravel() + offset)
    borders = (np.concatenate(pairs), np.concatenate(costs), np.concatenate(used_line))
    chosen = _solve(cells.ravel(), *borders, config.line_price)
    return chosen.reshape(cells.shape)


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
    pairs: np.ndarray,
    border_costs: Float[np.ndarray, " borders"],
    line_of_border: np.ndarray,
    line_price: float,
) -> Bool[np.ndarray, " cells"]:
    """min c.x + w.b + price * l  with  b = |x_i - x_j|  and  l >= b for the borders of a line."""
    n_cells, n_borders = len(cell_costs), len(pairs)
    n_lines = int(line_of_border.max()) + 1
    n = n_cells + n_borders + n_lines
    b = n_cells + np.arange(n_borders)
    rows = _Rows(n)
    # The four facets of b = |x_i - x_j|: two hold it up, two hold it down where wall is rewarded.
    one = np.ones(n_borders)
    for first, second, border, upper in ((1, -1, -1, 0), (-1, 1, -1, 0), (-1, -1, 1, 0), (1, 1, 1, 2)):
        rows.add([(pairs[:, 0], first * one), (pairs[:, 1], second * one), (b, border * one)], upper)
    rows.add([(b, one), (n_cells + n_borders + line_of_border, -one)], upper=0)
    costs = np.concatenate([cell_costs, border_costs, np.full(n_lines, line_price)])
    result = milp(costs, integrality=np.ones(n), bounds=Bounds(0, 1), constraints=rows.constraint())
    assert result.x is not None, "all-outside is always feasible"
    return result.x[:n_cells] > 0.5


class _Rows:
    """Collects sparse inequality rows."""

    def __init__(self, n_columns: int):
        self.n_columns = n_columns
        self.row: list[np.ndarray] = []
        self.column: list[np.ndarray] = []
        self.value: list[np.ndarray] = []
        self.upper: list[np.ndarray] = []
        self.n_rows = 0

    def add(self, terms: list[tuple[np.ndarray, np.ndarray]], upper: float) -> None:
        """Append one block of rows: the sum of the terms is at most `upper`."""
        n = len(terms[0][0])
        for columns, values in terms:
            kept = columns >= 0
            self.row.append(self.n_rows + np.flatnonzero(kept))
            self.column.append(columns[kept])
            self.value.append(values[kept])
        self.upper.append(np.full(n, upper))
        self.n_rows += n

    def constraint(self) -> LinearConstraint:
        """All rows as one constraint."""
        matrix = coo_array(
            (np.concatenate(self.value), (np.concatenate(self.row), np.concatenate(self.column))),
            shape=(self.n_rows, self.n_columns),
        )
        return LinearConstraint(matrix.tocsr(), -np.inf, np.concatenate(self.upper))  # pyright: ignore
