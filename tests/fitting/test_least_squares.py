"""The solver ends at the one minimum, from wherever it starts."""

import jax
import numpy as np
import pytest
from scipy.optimize import least_squares as scipy_least_squares
from scipy.spatial.transform import Rotation

from indoorfit.fitting.least_squares import solve
from indoorfit.fitting.moments import plane_moments

AXES = np.array([0, 0, 1, 1, 2, 2])
TRUE_M = np.array([-2.0, 2.0, -1.5, 1.5, -1.2, 1.3])
SIGMA_M = 0.005


def observed(seed: int = 0, per_plane: int = 200, turn=(0.01, -0.02, 0.015)):
    rng = np.random.default_rng(seed)
    plane = np.repeat(np.arange(6), per_plane)
    local = rng.uniform(-1.2, 1.2, (len(plane), 3))
    local[np.arange(len(plane)), AXES[plane]] = TRUE_M[plane] + rng.normal(0, SIGMA_M, len(plane))
    points_m = local @ Rotation.from_rotvec(turn).as_matrix().T
    return points_m, plane, np.full(len(plane), SIGMA_M**-2)


def by_scipy(points_m, plane, weights):
    """The same problem point by point with another solver."""

    def rows(x):
        normals = Rotation.from_rotvec(x[:3]).as_matrix()[:, AXES].T
        return np.sqrt(weights) * (np.sum(normals[plane] * points_m, axis=1) - x[3:][plane])

    return scipy_least_squares(
        rows, np.concatenate([np.zeros(3), TRUE_M]), xtol=1e-15, ftol=1e-15, gtol=1e-12
    )


def test_minimum_is_that_of_the_points():
    points_m, plane, weights = observed()
    found = solve(plane_moments(points_m, plane, weights, 6), np.eye(3)[AXES], TRUE_M)
    expected = by_scipy(points_m, plane, weights)
    assert found.converged
    # Solver: 1e-8 of a standard error of a plane (0.35 mm), a thousandfold for the weakly curved directions.
    np.testing.assert_allclose(found.offsets_m, expected.x[3:], atol=1e-8)
    np.testing.assert_allclose(found.rotation_rad, expected.x[:3], atol=1e-8)
    np.testing.assert_allclose(found.cost, expected.cost, rtol=1e-8)


def test_truth_is_recovered_within_its_standard_errors():
    points_m, plane, weights = observed(1, turn=(0.02, 0.01, -0.03))
    found = solve(plane_moments(points_m, plane, weights, 6), np.eye(3)[AXES], TRUE_M)
    # Six offsets, four standard errors each.
    np.testing.assert_allclose(found.offsets_m, TRUE_M, atol=4 * SIGMA_M / np.sqrt(200))
    np.testing.assert_allclose(found.rotation_rad, (0.02, 0.01, -0.03), atol=4 * SIGMA_M / np.sqrt(400))


@pytest.mark.parametrize("seed", range(5))
def test_perturbed_starts_end_at_the_same_minimum(seed):
    points_m, plane, weights = observed(2)
    moments = plane_moments(points_m, plane, weights, 6)
    reference = solve(moments, np.eye(3)[AXES], TRUE_M)
    # As far as the reach of the association: 10 cm.
    start = TRUE_M + np.random.default_rng(seed).uniform(-0.1, 0.1, 6)
    found = solve(moments, np.eye(3)[AXES], start)
    assert found.converged
    # Ten times the solver's tolerance, as above.
    np.testing.assert_allclose(found.offsets_m, reference.offsets_m, atol=1e-7)
    assert found.cost <= reference.cost * (1 + 1e-9)


def test_planes_without_points_keep_their_place():
    points_m, plane, weights = observed(3)
    moments = plane_moments(points_m[plane != 3], plane[plane != 3], weights[plane != 3], 6)
    start = TRUE_M.copy()
    start[3] = 1.77
    found = solve(moments, np.eye(3)[AXES], start)
    # Rounding of the solver's steps.
    assert found.offsets_m[3] == pytest.approx(1.77, abs=1e-12)
    np.testing.assert_allclose(
        np.delete(found.offsets_m, 3), np.delete(TRUE_M, 3), atol=4 * SIGMA_M / np.sqrt(200)
    )


@pytest.mark.parametrize("n_planes", [6, 31, 32, 33, 70])
def test_padding_to_blocks_changes_nothing(n_planes):
    rng = np.random.default_rng(4)
    axes = np.arange(n_planes) % 3
    true_m = rng.uniform(-3, 3, n_planes)
    plane = np.repeat(np.arange(n_planes), 30)
    points_m = rng.uniform(-1, 1, (len(plane), 3))
    points_m[np.arange(len(plane)), axes[plane]] = true_m[plane]
    found = solve(
        plane_moments(points_m, plane, np.full(len(plane), 1e4), n_planes), np.eye(3)[axes], true_m + 0.01
    )
    # Exact data: what is left is the solver's tolerance, 1e-8 of a standard error of 1 cm / sqrt(30).
    np.testing.assert_allclose(found.offsets_m, true_m, atol=1e-8)
    np.testing.assert_allclose(found.rotation_rad, 0.0, atol=1e-8)


def test_settings_of_the_host_are_left_alone():
    before = jax.config.read("jax_enable_x64")
    points_m, plane, weights = observed(5)
    solve(plane_moments(points_m, plane, weights, 6), np.eye(3)[AXES], TRUE_M)
    assert jax.config.read("jax_enable_x64") == before
