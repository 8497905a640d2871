"""The minimum of the plan's energy is exact, proved, and reached with a bounded amount of work."""

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from indoorfit.discover.minimise import PlanEnergy, minimise

EVERYTHING = 10_000
"""More open cells than any plan here has."""

ROUNDING = 1e-6
"""Relative tolerance to which the solver proves its answer."""


def contradictory(nx: int, ny: int, seed: int) -> PlanEnergy:
    """Noise instead of evidence, and more of it on the borders than over the cells: no plan is harder."""
    rng = np.random.default_rng(seed)
    borders = rng.normal(-1.0, 5.0, (nx + 1, ny)), rng.normal(-1.0, 5.0, (nx, ny + 1))
    return PlanEnergy(rng.normal(0.0, 1.0, (nx, ny)), borders, float(rng.uniform(2.0, 5.0)))


def storey(n_rooms: int, seed: int) -> tuple[PlanEnergy, np.ndarray]:
    """A chequer of n x n rooms, each a block of 4 x 4 cells with a wall all around but for a door."""
    rng = np.random.default_rng(seed)
    n = 5 * n_rooms + 1
    inside = np.zeros((n, n), bool)
    for i in range(n_rooms):
        for j in range(n_rooms):
            inside[5 * i + 1 : 5 * i + 5, 5 * j + 1 : 5 * j + 5] = True
    padded = np.pad(inside, 1)
    walls = padded[1:, 1:-1] != padded[:-1, 1:-1], padded[1:-1, 1:] != padded[1:-1, :-1]
    cells = np.where(inside, -8.0, 6.0) + rng.normal(0.0, 2.0, (n, n))
    # A tenth of the wall is hidden, and a tenth of the open plan shows wall.
    seen = [np.where(rng.uniform(size=wall.shape) < 0.1, ~wall, wall) for wall in walls]
    borders = [np.where(wall, -5.0, 3.0) + rng.normal(0.0, 1.0, wall.shape) for wall in seen]
    return PlanEnergy(cells, (borders[0], borders[1]), 4.0), inside


def plain_minimum(energy: PlanEnergy) -> float:
    """The definition, word for word, as an integer programme without any tightening."""
    shape = energy.cells.shape
    number = np.pad(np.arange(energy.cells.size).reshape(shape), 1, constant_values=-1)
    terms = []
    for first, second, cost in (
        (number[:-1, 1:-1], number[1:, 1:-1], energy.borders[0]),
        (number[1:-1, :-1], number[1:-1, 1:], energy.borders[1]),
    ):
        terms += [([(i, 1), (j, -1)], c) for i, j, c in zip(first.flat, second.flat, cost.flat, strict=True)]
    blocks = [number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]]
    for cells in zip(*(block.flat for block in blocks), strict=True):
        terms.append((list(zip(cells, (1, -1, -1, 1), strict=True)), energy.corner_price))
    n_cells = energy.cells.size
    rows, columns, values = [], [], []
    for k, (signed, _) in enumerate(terms):
        # |s| = p + m with s = p - m and, by a switch z, p <= 2 z and m <= 2 (1 - z).
        p, m = n_cells + 3 * k, n_cells + 3 * k + 1
        for cell, sign in signed:
            if cell >= 0:
                rows.append(3 * k)
                columns.append(cell)
                values.append(sign)
        for row, column, value in (
            (3 * k, p, -1), (3 * k, m, 1), (3 * k + 1, p, 1), (3 * k + 1, m + 1, -2),
            (3 * k + 2, m, 1), (3 * k + 2, m + 1, 2),
        ):  # fmt: skip
            rows.append(row)
            columns.append(column)
            values.append(value)
    n = n_cells + 3 * len(terms)
    costs = np.concatenate([energy.cells.ravel(), *([c, c, 0.0] for _, c in terms)])
    low = np.tile([0.0, -np.inf, -np.inf], len(terms))
    high = np.tile([0.0, 0.0, 2.0], len(terms))
    bounds = Bounds(0, np.concatenate([np.ones(n_cells), np.tile([2.0, 2.0, 1.0], len(terms))]))
    matrix = coo_array((values, (rows, columns)), shape=(3 * len(terms), n)).tocsr()
    whole = np.concatenate([np.ones(n_cells), np.tile([0, 0, 1], len(terms))])
    constraint = LinearConstraint(matrix, low, high)
    return milp(costs, integrality=whole, bounds=bounds, constraints=constraint).fun


@pytest.mark.parametrize("seed", range(12))
def test_the_minimum_is_that_of_the_plain_integer_programme(seed):
    energy = contradictory(5, 4, seed)
    inside, gap = minimise(energy, EVERYTHING)
    best = plain_minimum(energy)
    assert gap == 0.0
    # The plain programme is solved to HiGHS' default relative gap of 1e-4.
    assert abs(energy.of(inside) - best) <= 1e-4 * (1.0 + abs(best))


@pytest.mark.parametrize("seed", range(6))
def test_no_single_change_of_a_proved_plan_lowers_the_energy(seed):
    energy, _ = storey(2, seed)
    inside, gap = minimise(energy, EVERYTHING)
    assert gap == 0.0
    least = energy.of(inside)
    for cell in np.ndindex(inside.shape):
        changed = inside.copy()
        changed[cell] = ~changed[cell]
        assert energy.of(changed) >= least - ROUNDING * (1.0 + abs(least))


@pytest.mark.parametrize("seed", range(3))
def test_a_storey_of_many_rooms_is_proved_optimal_by_the_relaxation_alone(seed):
    energy, truth = storey(6, seed)
    inside, gap = minimise(energy, max_open_cells=0)
    assert gap == 0.0
    assert energy.of(inside) <= energy.of(truth)
    assert np.mean(inside == truth) > 0.98


def test_the_plan_turns_with_the_evidence():
    energy, _ = storey(2, 7)
    x, y = energy.borders
    turned = PlanEnergy(energy.cells.T.copy(), (y.T.copy(), x.T.copy()), energy.corner_price)
    np.testing.assert_array_equal(minimise(turned, 0)[0], minimise(energy, 0)[0].T)


def test_a_plan_that_is_too_contradictory_comes_with_a_bound_that_holds():
    gaps = []
    for seed in range(6):
        energy = contradictory(7, 7, seed)
        best = energy.of(minimise(energy, EVERYTHING)[0])
        inside, gap = minimise(energy, max_open_cells=0)
        rounding = ROUNDING * (1.0 + abs(best))
        assert best - rounding <= energy.of(inside) <= best + gap + rounding
        gaps.append(gap)
    assert max(gaps) > 0.0, "the plans were meant to be too hard for the relaxation"
