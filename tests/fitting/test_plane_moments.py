"""Moments say all that least squares needs to know of the points."""

import jax
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from indoorfit.fitting.moments import plane_moments
from indoorfit.fitting.plane_residuals import Problem, Unknowns, residuals


def points_of(seed: int, n: int = 60, planes: int = 4):
    rng = np.random.default_rng(seed)
    plane = rng.integers(0, planes, n)
    points_m = rng.uniform(-3, 3, (n, 3))
    points_m[np.arange(n), plane % 3] = plane - 1.5 + rng.normal(0, 0.01, n)
    return points_m, plane, rng.uniform(0, 1e4, n)


def full_cost(points_m, plane, weights, rotation_rad, offsets_m) -> float:
    """Half the weighted sum of squared distances, point by point."""
    normals = Rotation.from_rotvec(rotation_rad).as_matrix()[:, np.arange(len(offsets_m)) % 3].T
    distances = np.sum(normals[plane] * points_m, axis=1) - offsets_m[plane]
    return 0.5 * float(weights @ distances**2)


def compressed_cost(points_m, plane, weights, rotation_rad, offsets_m) -> float:
    n = len(offsets_m)
    moments = plane_moments(points_m, plane, weights, n)
    problem = Problem(
        np.eye(3)[np.arange(n) % 3], moments.weights, moments.means_m, moments.roots, np.ones(n), offsets_m
    )
    with jax.enable_x64(True):
        found = residuals(Unknowns(np.asarray(rotation_rad), offsets_m), problem)
        return 0.5 * float(np.sum(np.square(np.asarray(found))))


SMALL = st.floats(-0.1, 0.1)


@given(seed=st.integers(0, 10_000), rotation_rad=st.tuples(SMALL, SMALL, SMALL), shift_m=SMALL)
def test_compressed_cost_equals_that_of_all_points(seed, rotation_rad, shift_m):
    points_m, plane, weights = points_of(seed)
    offsets_m = np.arange(4) - 1.5 + shift_m
    full = full_cost(points_m, plane, weights, rotation_rad, offsets_m)
    # Rounding: 1e-10 of the cost; moments are centred, so no digits cancel.
    np.testing.assert_allclose(
        compressed_cost(points_m, plane, weights, rotation_rad, offsets_m), full, rtol=1e-10
    )


def test_planes_without_points_have_no_weight_and_no_scatter():
    moments = plane_moments(np.ones((3, 3)), np.array([0, 0, 2]), np.array([1.0, 2.0, 0.0]), 4)
    np.testing.assert_array_equal(moments.weights, [3.0, 0.0, 0.0, 0.0])
    assert np.all(np.isfinite(moments.roots))
    np.testing.assert_array_equal(moments.means_m[3], 0.0)


def test_roots_are_symmetric_and_square_to_the_scatter():
    points_m, plane, weights = points_of(1)
    moments = plane_moments(points_m, plane, weights, 4)
    for k in range(4):
        centred = points_m[plane == k] - np.average(points_m[plane == k], axis=0, weights=weights[plane == k])
        scatter = (weights[plane == k, None] * centred).T @ centred
        # Rounding of numbers of order 1e6.
        np.testing.assert_allclose(
            moments.roots[k] @ moments.roots[k], scatter, atol=1e-8 * np.abs(scatter).max()
        )
        np.testing.assert_allclose(moments.roots[k], moments.roots[k].T, atol=1e-9 * np.abs(scatter).max())


def test_order_and_splitting_of_points_do_not_matter():
    points_m, plane, weights = points_of(2)
    order = np.random.default_rng(0).permutation(len(plane))
    a = plane_moments(points_m, plane, weights, 4)
    b = plane_moments(points_m[order], plane[order], weights[order], 4)
    c = plane_moments(np.vstack([points_m] * 2), np.tile(plane, 2), np.tile(weights / 2, 2), 4)
    for other in (b, c):
        # Rounding; roots hold square roots of near-zero eigenvalues, good to 1e-8 of the largest.
        np.testing.assert_allclose(other.weights, a.weights, rtol=1e-12)
        np.testing.assert_allclose(other.means_m, a.means_m, atol=1e-12)
        np.testing.assert_allclose(other.roots, a.roots, atol=1e-6 * np.abs(a.roots).max())
