"""Whitened plane residuals over one shared rotation and the plane offsets, in JAX."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float


class Problem(NamedTuple):
    """One least squares problem over the shared rotation and the plane offsets, as arrays."""

    axes: Float[Array | np.ndarray, "planes 3"]
    """Unit vector of each plane's axis, Manhattan frame at the linearisation point."""
    weights: Float[Array | np.ndarray, " planes"]
    means_m: Float[Array | np.ndarray, "planes 3"]
    roots: Float[Array | np.ndarray, "planes 3 3"]
    free: Float[Array | np.ndarray, " planes"]
    """1 where the offset is determined by points, 0 where it is held."""
    held_m: Float[Array | np.ndarray, " planes"]


class Unknowns(NamedTuple):
    """What is fitted."""

    rotation_rad: Float[Array | np.ndarray, " 3"]
    """Rotation vector: the planes' normals are ``exp([w]) e_axis``."""
    offsets_m: Float[Array | np.ndarray, " planes"]


def rotation_matrix(vector_rad: Float[Array | np.ndarray, " 3"]) -> Float[Array, "3 3"]:
    """Rodrigues' formula, smooth at zero.

    Source: Rodrigues 1840. Both branches of each `where` are guarded, or the gradient at 0 is NaN.
    """
    squared = vector_rad @ vector_rad
    small = squared < 1e-12
    safe = jnp.where(small, 1.0, squared)
    angle = jnp.sqrt(safe)
    first = jnp.where(small, 1.0 - squared / 6.0, jnp.sin(angle) / angle)
    second = jnp.where(small, 0.5 - squared / 24.0, (1.0 - jnp.cos(angle)) / safe)
    x, y, z = vector_rad
    cross = jnp.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return jnp.eye(3) + first * cross + second * (cross @ cross)


def residuals(unknowns: Unknowns, problem: Problem) -> Float[Array, "planes 4"]:
    """Whitened residuals, four per plane; their squares add up to the weighted squares of all points.

    Returns:
        no unit. Smooth everywhere. Planes without points hold their offset by a unit residual.
    """
    normals = problem.axes @ rotation_matrix(unknowns.rotation_rad).T
    tilt = jnp.einsum("pij,pj->pi", problem.roots, normals)
    distance_m = jnp.sum(normals * problem.means_m, axis=1) - unknowns.offsets_m
    held = unknowns.offsets_m - problem.held_m
    shift = jnp.where(problem.free > 0, jnp.sqrt(problem.weights) * distance_m, held)
    return jnp.concatenate([tilt * problem.free[:, None], shift[:, None]], axis=1)
