"""The labelling of the plan's cells is the exact minimum of its energy."""

from itertools import product

import numpy as np
import pytest

from indoorfit.discover.candidates import Lines
from indoorfit.discover.evidence import Evidence
from indoorfit.discover.labelling import LabelConfig, cell_costs, label_cells, price_of_wall

PRICE = 3.5  # nats; a wall with a thousand patches


def evidence_of(
    ceiling: np.ndarray,
    floor: np.ndarray,
    walls: tuple[np.ndarray, np.ndarray],
    heads: np.ndarray | None = None,
) -> Evidence:
    """All at one height; the labelling does not look at lintels."""
    heads = np.zeros(ceiling.shape) if heads is None else heads
    return Evidence(ceiling, floor, heads, np.full(ceiling.shape, 2.5), walls, walls)


def random_evidence(nx: int, ny: int, rng: np.random.Generator) -> Evidence:
    return evidence_of(
        ceiling=rng.uniform(0, 1, (nx, ny)),
        floor=rng.uniform(0, 1, (nx, ny)),
        walls=(rng.uniform(0, 1, (nx + 1, ny)), rng.uniform(0, 1, (nx, ny + 1))),
    )


def test_under_a_door_s_head_neither_floor_nor_missing_ceiling_says_anything():
    none = (np.zeros((2, 1)), np.zeros((1, 2)))
    area_m2, config = np.ones((1, 1)), LabelConfig()
    share, open_floor = np.zeros((1, 1)), np.ones((1, 1))
    under = cell_costs(evidence_of(share, open_floor, none, np.ones((1, 1))), area_m2, config)
    assert under == 0.0
    assert cell_costs(evidence_of(share, open_floor, none), area_m2, config) < 0.0


def energy(inside: np.ndarray, evidence: Evidence, grid, config: LabelConfig) -> float:
    """The negative log posterior, written out as its documentation says."""

    def odds(share: float, true: float, false: float) -> float:
        return share * np.log(true / false) + (1 - share) * np.log((1 - true) / (1 - false))

    def gain_of(share: float, fine: float, true: float, false: float) -> float:
        """Of one square metre, of which `fine` is unseen and yet no gap."""
        seen, unseen = odds(1.0, true, false), odds(0.0, true, false)
        coarse = 1.0 - share - fine
        return share * seen / config.patch_m**2 + unseen * (
            fine / config.patch_m**2 + coarse / config.unseen_m**2
        )

    sizes_m = [np.diff(lines) for lines in grid]
    dx, dy = (size_m / config.patch_m for size_m in sizes_m)
    total = 0.0
    for i, j in np.argwhere(inside):
        area_m2, ceiling, floor = sizes_m[0][i] * sizes_m[1][j], evidence.ceiling[i, j], evidence.floor[i, j]
        roofless = min(1.0 - ceiling, floor)
        total -= area_m2 * gain_of(ceiling, roofless, config.ceiling_inside, config.ceiling_outside)
        total -= area_m2 * gain_of(floor, 0.0, config.floor_inside, config.floor_outside)
    padded = np.pad(inside, 1)
    for axis, widths in ((0, dy), (1, dx)):
        border = np.diff(padded.astype(int), axis=axis) != 0
        border = border[:, 1:-1] if axis == 0 else border[1:-1, :]
        for i, j in np.argwhere(border):
            width = widths[j] if axis == 0 else widths[i]
            total -= odds(evidence.walls[axis][i, j], config.wall_between, config.wall_elsewhere) * width
    corners = padded[1:, 1:].astype(int) - padded[:-1, 1:] - padded[1:, :-1] + padded[:-1, :-1]
    return total + PRICE * np.abs(corners).sum()


@pytest.mark.parametrize("seed", range(8))
def test_no_other_labelling_has_a_lower_energy(seed):
    rng = np.random.default_rng(seed)
    nx, ny = 3, 3
    evidence = random_evidence(nx, ny, rng)
    grid = tuple(np.cumsum(rng.uniform(0.2, 1.0, n + 1)) for n in (nx, ny))
    config = LabelConfig()
    found = energy(label_cells(evidence, grid, PRICE, config)[0], evidence, grid, config)
    best = min(
        energy(np.array(bits, bool).reshape(nx, ny), evidence, grid, config)
        for bits in product([0, 1], repeat=nx * ny)
    )
    # The solver proves its answer to a relative 1e-6.
    assert found <= best + 1e-6 * (1.0 + abs(best))


def test_a_room_that_is_seen_in_full_is_inside_and_the_rest_is_not():
    evidence = evidence_of(
        ceiling=np.array([[0.0], [1.0], [0.0]]),
        floor=np.array([[0.0], [1.0], [0.0]]),
        walls=(np.array([[0.0], [1.0], [1.0], [0.0]]), np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]])),
    )
    grid = (np.array([0.0, 2.0, 6.0, 8.0]), np.array([0.0, 4.0]))
    np.testing.assert_array_equal(
        label_cells(evidence, grid, PRICE, LabelConfig())[0].ravel(), [False, True, False]
    )


def test_a_scan_without_any_ceiling_is_labelled_by_its_floor():
    evidence = evidence_of(
        ceiling=np.zeros((2, 1)),
        floor=np.array([[0.9], [0.0]]),
        walls=(np.array([[1.0], [1.0], [0.0]]), np.array([[1.0, 1.0], [0.0, 0.0]])),
    )
    grid = (np.array([0.0, 4.0, 8.0]), np.array([0.0, 4.0]))
    np.testing.assert_array_equal(label_cells(evidence, grid, PRICE, LabelConfig())[0].ravel(), [True, False])


def lines_of(offsets_m: list[float], seen: list[bool]) -> Lines:
    return Lines(np.array(offsets_m), np.array(seen), np.zeros(0, int))


def test_a_pillar_of_which_two_sides_were_seen_is_no_part_of_the_room():
    # Half a metre square; nobody walked round it, but floor and ceiling have a hole there.
    across = lines_of([0.0, 2.0, 2.5, 5.0], [True, True, False, True])
    hole = np.ones((3, 3))
    hole[1, 1] = 0.0
    walls = np.zeros((4, 3))
    walls[[0, 3]] = 1.0
    walls[1, 1] = 1.0
    evidence = evidence_of(ceiling=hole, floor=hole, walls=(walls, walls.T))
    config = LabelConfig()
    price = price_of_wall((across, across), config)
    inside = label_cells(evidence, (across.offsets_m, across.offsets_m), price, config)[0]
    np.testing.assert_array_equal(inside, hole.astype(bool))


def test_the_price_of_a_wall_is_the_length_of_its_name():
    few, many = lines_of([0.0, 1.0], [True, True]), lines_of([0.0, 1.0, 2.0, 3.0, 4.0], [True] * 4 + [False])
    assert price_of_wall((few, few), LabelConfig()) == pytest.approx(np.log(2))
    assert price_of_wall((few, many), LabelConfig()) == pytest.approx(0.5 * np.log(2 * 4))
    # A partial scan shows no wall of one axis; a room has two of each.
    assert price_of_wall((lines_of([0.0], [False]), few), LabelConfig()) == pytest.approx(np.log(2))
    assert price_of_wall((few, many), LabelConfig(wall_price=7.0)) == 7.0
