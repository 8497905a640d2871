"""Floor and ceiling err together: how far, and what that does to heights and to nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from cell_rooms import REGIMES, simulate_cell_room

from indoorfit.fitting.uncertainty import Cells, WallFieldConfig, wall_field_predictive
from indoorfit.fitting.uncertainty.field import build_field
from indoorfit.fitting.uncertainty.level_field import common_share, level_blocks

CONFIG = WallFieldConfig()
TAU_M, LENGTH_M, ETA_M = 0.01, 1.0, 1e-4
PHI = np.log([TAU_M, LENGTH_M, ETA_M, 1e-6])


def floor_and_ceiling(share: float, seed: int, height_m: float = 2.5) -> Cells:
    """Two levels of 8 x 8 m in patches of 0.7 m with fields of the given correlation."""
    rng = np.random.default_rng(seed)
    side = np.arange(0.35, 8.0, 0.7)
    plan = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    n = len(plan)
    distance = np.linalg.norm(plan[:, None] - plan[None], axis=2)
    root = np.linalg.cholesky(TAU_M**2 * np.exp(-distance / LENGTH_M) + 1e-12 * np.eye(n))
    common, *own = (root @ rng.standard_normal(n) for _ in range(3))
    residuals = [np.sqrt(share) * common + np.sqrt(1.0 - share) * field for field in own]
    centroids = np.concatenate([np.column_stack([plan, np.full(n, z)]) for z in (0.0, height_m)])
    plane = np.repeat([0, 1], n)
    design = np.zeros((2 * n, 5))
    design[:, :3] = np.cross([0.0, 0.0, 1.0], centroids)
    design[np.arange(2 * n), 3 + plane] = -1.0
    return Cells(
        plane=plane,
        design=design,
        centroids_m=centroids,
        residuals_m=np.concatenate(residuals),
        variances_m2=np.full(2 * n, 1e-10),
        counts=np.full(2 * n, 100),
    )


def estimated(cells: Cells, prior: float = 0.7, weight: float = 0.0) -> float:
    return common_share(cells, level_blocks(cells, build_field(cells).blocks), PHI, prior, weight)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_the_correlation_is_estimated_where_there_are_many_patches(share):
    found = [estimated(floor_and_ceiling(share, seed)) for seed in range(12)]
    # Of 121 patches some 50 are effective: 0.14 each, 0.04 the mean of twelve; negative ones count as none.
    assert np.mean(found) == pytest.approx(share, abs=0.12)


def test_without_patches_over_each_other_the_expectation_stands():
    cells = floor_and_ceiling(0.5, 1)
    away = cells.centroids_m + np.where(cells.plane == 1, 20.0, 0.0)[:, None] * [1.0, 0.0, 0.0]
    assert estimated(replace(cells, centroids_m=away), prior=0.7, weight=8.0) == pytest.approx(0.7)


def test_noise_of_the_patches_does_not_hide_the_correlation():
    rng = np.random.default_rng(3)
    found = []
    for seed in range(12):
        cells = floor_and_ceiling(0.8, seed)
        noisy = cells.residuals_m + rng.normal(0.0, TAU_M, len(cells.plane))
        variances = np.full(len(cells.plane), TAU_M**2)
        found.append(estimated(replace(cells, residuals_m=noisy, variances_m2=variances)))
    # The observed correlation is half of it.
    assert np.mean(found) > 0.6


def test_what_is_common_narrows_heights_and_nothing_else():
    room = simulate_cell_room(11, REGIMES["p20real"])
    apart = replace(CONFIG, level_common=0.0, level_weight=1e9)
    together = replace(CONFIG, level_common=1.0, level_weight=1e9)
    narrow, wide = (
        wall_field_predictive(room.cells, room.contrasts, config, np.random.default_rng(0))
        for config in (together, apart)
    )
    heights = np.array([kind == "height" for kind in room.kinds])
    assert np.all(narrow.std[heights] < 0.8 * wide.std[heights])
    # Walls share the rotation with floor and ceiling, whose covariance changes a little.
    np.testing.assert_allclose(narrow.std[~heights], wide.std[~heights], rtol=0.02)
    np.testing.assert_allclose(narrow.mean, wide.mean, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
def test_every_share_gives_a_covariance_matrix(share):
    room = simulate_cell_room(12, REGIMES["p20"])
    config = replace(CONFIG, level_common=share, level_weight=1e9)
    answer = wall_field_predictive(room.cells, room.contrasts, config, np.random.default_rng(0))
    for covariance in answer.covariances:
        values = np.linalg.eigvalsh(covariance)
        # Rounding of the largest eigenvalue.
        assert values.min() > -1e-10 * values.max()
