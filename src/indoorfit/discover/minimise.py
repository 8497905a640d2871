"""The exact minimum of the plan's energy: a linear programme that is nearly always whole by itself.

    min  sum c_i x_i + sum w_b |x_i - x_j| + price * sum_v k_v

over cells x in {0, 1}; a border b lies between two cells, k_v counts the corners of the outline at vertex v
(0, 1, or 2 where two corners touch), and beyond the grid is outside, x = 0.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.optimize import Bounds, LinearConstraint, OptimizeResult, linprog, milp
from scipy.sparse import coo_array, csr_array

_WHOLE = 1e-6
"""Relative difference of energies that is rounding: the solver's own tolerance is 1e-7."""
_MAX_NODES = 100
"""Branches of the search; a plan whose open cells are few needs fewer than ten."""


@dataclass(frozen=True)
class PlanEnergy:
    """The terms of the energy on a grid of cells, without unit (nats)."""

    cells: Float[np.ndarray, "nx ny"]
    """Cost of a cell being inside."""
    borders: tuple[Float[np.ndarray, "nx1 ny"], Float[np.ndarray, "nx ny1"]]
    """Cost of the outline running along a border of constant x, of constant y; the outermost included."""
    corner_price: float | Float[np.ndarray, "nx1 ny1"]
    """Cost of a corner of the outline, not negative: one for all vertices, or one for each."""

    def of(self, inside: Bool[np.ndarray, "nx ny"]) -> float:
        """The energy of one labelling."""
        padded = np.pad(inside.astype(int), 1)
        along_x = np.abs(np.diff(padded, axis=0))[:, 1:-1]
        along_y = np.abs(np.diff(padded, axis=1))[1:-1]
        corners = self.corner_price * np.abs(np.diff(np.diff(padded, axis=0), axis=1))
        borders = np.sum(self.borders[0] * along_x) + np.sum(self.borders[1] * along_y)
        return float(np.sum(self.cells * inside) + borders + corners.sum())


def minimise(energy: PlanEnergy, max_open_cells: int) -> tuple[Bool[np.ndarray, "nx ny"], float]:
    """Find the labelling of least energy.

    The relaxation has the facets of |x_i - x_j| and, around every vertex, those that tie the corners to the
    four borders; without the latter half a wall everywhere would cost no corner. Its minimum is whole, and
    hence the answer, for scans of rooms and storeys. Else cells whose reduced cost exceeds the gap to a
    rounded labelling are settled (Nemhauser and Wolsey 1988, section II.5.1), and branch and bound decides
    the rest. All limits count work, not seconds: the same plan gets the same labels on any machine.

    Args:
        energy: the terms.
        max_open_cells: unsettled cells up to which branch and bound is tried.

    Returns:
        the labels, and by how much a better labelling could at most have less energy: 0 where proved.
    """
    programme = _Programme(energy)
    relaxed = programme.relax()
    inside = _rounded(energy, programme.cells_of(relaxed.x))
    gap = energy.of(inside) - relaxed.fun
    if gap <= _WHOLE * (1.0 + abs(relaxed.fun)):
        return inside, 0.0
    lower, upper = programme.settled(relaxed, gap)
    if np.sum(lower[: inside.size] < upper[: inside.size]) > max_open_cells:
        return inside, gap
    searched = programme.search(lower, upper)
    if searched.x is not None:
        found = programme.cells_of(searched.x) > 0.5
        inside = found if energy.of(found) < energy.of(inside) else inside
        bound = searched.mip_dual_bound
        gap = energy.of(inside) - (relaxed.fun if bound is None else max(bound, relaxed.fun))
    return inside, gap if gap > _WHOLE * (1.0 + abs(relaxed.fun)) else 0.0


def _rounded(energy: PlanEnergy, shares: Float[np.ndarray, "nx ny"]) -> Bool[np.ndarray, "nx ny"]:
    """The best labelling that one threshold on the relaxed cells gives."""
    # Vertices of the relaxation lie at halves, thirds and quarters.
    candidates = [shares > threshold for threshold in (0.5, 0.1, 0.3, 0.7, 0.9)]
    return min(candidates, key=energy.of)


class _Programme:
    """The relaxation as a sparse linear programme over cells, borders and corners, in this order."""

    def __init__(self, energy: PlanEnergy):
        self.shape = energy.cells.shape
        n_cells = energy.cells.size
        n_x, n_y = (costs.size for costs in energy.borders)
        n_corners = (self.shape[0] + 1) * (self.shape[1] + 1)
        corners = np.broadcast_to(energy.corner_price, (self.shape[0] + 1, self.shape[1] + 1)).ravel()
        self.costs = np.concatenate(
            [energy.cells.ravel(), energy.borders[0].ravel(), energy.borders[1].ravel(), corners]
        )
        self.n_cells = n_cells
        self.upper = np.concatenate([np.ones(n_cells + n_x + n_y), np.full(n_corners, 2.0)])
        # Index -1 stands for what lies outside the grid, where everything is 0.
        cell = np.pad(np.arange(n_cells).reshape(self.shape), 1, constant_values=-1)
        across_x = n_cells + np.arange(n_x).reshape(energy.borders[0].shape)
        across_y = n_cells + n_x + np.arange(n_y).reshape(energy.borders[1].shape)
        corner = n_cells + n_x + n_y + np.arange(n_corners)
        rows = _Rows()
        _tie_borders(rows, cell[:-1, 1:-1], cell[1:, 1:-1], across_x)
        _tie_borders(rows, cell[1:-1, :-1], cell[1:-1, 1:], across_y)
        _tie_corners(rows, cell, across_x, across_y, corner)
        self.matrix, self.limits = rows.matrix(len(self.costs))

    def relax(self) -> OptimizeResult:
        """Minimum over shares instead of labels, at a vertex of the polytope."""
        bounds = np.stack([np.zeros_like(self.upper), self.upper], axis=1)
        result = linprog(self.costs, A_ub=self.matrix, b_ub=self.limits, bounds=bounds, method="highs-ds")
        assert result.x is not None, "the programme is bounded, and nothing inside is feasible"
        return result

    def settled(
        self, relaxed: OptimizeResult, gap: float
    ) -> tuple[Float[np.ndarray, " columns"], Float[np.ndarray, " columns"]]:
        """Bounds of all columns, equal for cells that cannot change within the gap."""
        lower, upper = np.zeros_like(self.upper), self.upper.copy()
        cells = slice(0, self.n_cells)
        upper[cells][relaxed.lower.marginals[cells] > gap] = 0.0
        lower[cells][-relaxed.upper.marginals[cells] > gap] = 1.0
        return lower, upper

    def search(
        self, lower: Float[np.ndarray, " columns"], upper: Float[np.ndarray, " columns"]
    ) -> OptimizeResult:
        """Branch and bound."""
        # Borders and corners are whole numbers by themselves once the cells are.
        whole = np.zeros(len(self.costs))
        whole[: self.n_cells] = 1
        return milp(
            self.costs,
            integrality=whole,
            bounds=Bounds(lower, upper),  # pyright: ignore[reportArgumentType]
            constraints=LinearConstraint(self.matrix, -np.inf, self.limits),  # pyright: ignore
            options={"mip_rel_gap": 1e-7, "node_limit": _MAX_NODES},
        )

    def cells_of(self, values: Float[np.ndarray, " columns"]) -> Float[np.ndarray, "nx ny"]:
        """The cells' part of a solution."""
        return values[: self.n_cells].reshape(self.shape)


def _tie_borders(
    rows: "_Rows",
    below: Int[np.ndarray, "n m"],
    above: Int[np.ndarray, "n m"],
    border: Int[np.ndarray, "n m"],
) -> None:
    """The four facets of b = |x_i - x_j|: two hold it up, two hold it down where wall is rewarded."""
    i, j, b = below.ravel(), above.ravel(), border.ravel()
    for first, second, sign, limit in ((1, -1, -1, 0), (-1, 1, -1, 0), (-1, -1, 1, 0), (1, 1, 1, 2)):
        rows.add([(i, first), (j, second), (b, sign)], limit)


def _tie_corners(
    rows: "_Rows",
    cell: Int[np.ndarray, "nx2 ny2"],
    across_x: Int[np.ndarray, "nx1 ny"],
    across_y: Int[np.ndarray, "nx ny1"],
    corner: Int[np.ndarray, " vertices"],
) -> None:
    """Hold the corners up; the price holds them down.

    A straight wall through a vertex gives 0, a corner 1, touching corners 2: ``|x_1 - x_2 - x_3 + x_4|``.
    In terms of the borders that meet there: a wall that comes in on one side and does not go on makes a
    corner, and so do four borders that meet, twice.
    """
    blocks = [cell[:-1, :-1], cell[1:, :-1], cell[:-1, 1:], cell[1:, 1:]]
    for sign in (1, -1):
        signed = [(block.ravel(), sign * s) for block, s in zip(blocks, (1, -1, -1, 1), strict=True)]
        rows.add([*signed, (corner, -1)], 0)
    along_y = np.pad(across_x, ((0, 0), (1, 1)), constant_values=-1)
    along_x = np.pad(across_y, ((1, 1), (0, 0)), constant_values=-1)
    pairs = [(along_y[:, :-1].ravel(), along_y[:, 1:].ravel()), (along_x[:-1].ravel(), along_x[1:].ravel())]
    for before, after in pairs:
        rows.add([(before, 1), (after, -1), (corner, -1)], 0)
        rows.add([(before, -1), (after, 1), (corner, -1)], 0)
    rows.add([(border, 1) for pair in pairs for border in pair] + [(corner, -1)], 2)


class _Rows:
    """Collects sparse inequality rows."""

    def __init__(self) -> None:
        self.row: list[np.ndarray] = []
        self.column: list[np.ndarray] = []
        self.value: list[np.ndarray] = []
        self.limit: list[np.ndarray] = []
        self.n_rows = 0

    def add(self, terms: list[tuple[np.ndarray, int]], limit: int) -> None:
        """Append one block of rows: the sum of columns times factors is at most `limit`."""
        n = len(terms[0][0])
        for columns, factor in terms:
            kept = columns >= 0
            self.row.append(self.n_rows + np.flatnonzero(kept))
            self.column.append(columns[kept])
            self.value.append(np.full(int(kept.sum()), float(factor)))
        self.limit.append(np.full(n, float(limit)))
        self.n_rows += n

    def matrix(self, n_columns: int) -> tuple[csr_array, Float[np.ndarray, " rows"]]:
        """All rows, and what each is at most."""
        entries = np.concatenate(self.value), (np.concatenate(self.row), np.concatenate(self.column))
        return coo_array(entries, shape=(self.n_rows, n_columns)).tocsr(), np.concatenate(self.limit)
