"""The residuals' derivatives, by JAX and by hand."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from indoorfit.fitting.moments import plane_moments
from indoorfit.fitting.plane_residuals import Problem, Unknowns, residuals, rotation_matrix


@pytest.fixture
def problem() -> Problem:
    """Six planes, one of them without points."""
    rng = np.random.default_rng(0)
    plane = rng.integers(0, 5, 200)
    points_m = rng.uniform(-2, 2, (200, 3))
    moments = plane_moments(points_m, plane, rng.uniform(1, 3, 200), 6)
    free = (moments.weights > 0).astype(float)
    weights = np.where(free > 0, moments.weights, 1.0)
    return Problem(
        np.eye(3)[np.arange(6) % 3], weights, moments.means_m, moments.roots, free, np.linspace(-1, 1, 6)
    )


def cost(vector, problem: Problem):
    found = residuals(Unknowns(vector[:3], vector[3:]), problem)
    return 0.5 * jnp.sum(jnp.square(found))


@pytest.mark.parametrize("scale", [0.0, 1e-7, 1e-3, 0.3], ids=["zero", "tiny", "small", "large"])
def test_gradient_equals_central_differences(problem, scale):
    rng = np.random.default_rng(1)
    x = np.concatenate([scale * rng.normal(size=3), rng.uniform(-1, 1, 6)])
    with jax.enable_x64(True):
        gradient = np.asarray(jax.grad(cost)(jnp.asarray(x), problem))
        numeric = np.empty(9)
        for k in range(9):
            # Fourth-order central difference: truncation h^4 and rounding eps/h balance near 1e-3.
            h = 1e-3
            values = [float(cost(jnp.asarray(x + s * h * np.eye(9)[k]), problem)) for s in (-2, -1, 1, 2)]
            numeric[k] = np.dot([1, -8, 8, -1], values) / (12 * h)
    assert np.all(np.isfinite(gradient))
    # Relative to the largest component: 1e-8.
    np.testing.assert_allclose(gradient, numeric, atol=1e-8 * np.abs(gradient).max())


def test_jacobian_equals_central_differences_residual_by_residual(problem):
    x = np.random.default_rng(2).uniform(-0.2, 0.2, 9)

    def rows(vector):
        return residuals(Unknowns(vector[:3], vector[3:]), problem).ravel()

    with jax.enable_x64(True):
        jacobian = np.asarray(jax.jacfwd(rows)(jnp.asarray(x)))
        for k in range(9):
            step = 1e-5 * np.eye(9)[k]
            numeric = (
                np.asarray(rows(jnp.asarray(x + step))) - np.asarray(rows(jnp.asarray(x - step)))
            ) / 2e-5
            # Truncation h^2 = 1e-10 and rounding 1e-16 / 1e-5 = 1e-11, times numbers of order 20.
            np.testing.assert_allclose(jacobian[:, k], numeric, atol=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-6, 1.1e-6, 1e-3, 1.0, 3.0])
def test_rotation_matrix_is_the_exponential(angle):
    vector = angle * np.array([2.0, -1.0, 2.0]) / 3.0
    with jax.enable_x64(True):
        matrix = np.asarray(rotation_matrix(jnp.asarray(vector)))
    # Rounding; 1 - cos(x) loses digits below 1e-3, but is multiplied by x^2.
    np.testing.assert_allclose(
        matrix, Rotation.from_rotvec(vector).as_matrix(), atol=1e-15 + 1e-14 * (angle > 0)
    )


def test_planes_without_points_are_held_and_do_not_turn_the_room(problem):
    with jax.enable_x64(True):
        held = problem.held_m[5]
        found = residuals(Unknowns(np.array([0.2, 0.1, 0.0]), np.append(np.zeros(5), held)), problem)
    np.testing.assert_array_equal(np.asarray(found)[5], 0.0)


def test_precision_is_double(problem):
    with jax.enable_x64(True):
        found = residuals(Unknowns(np.zeros(3), np.zeros(6)), problem)
    assert found.dtype == jnp.float64
