"""The joint fit's core: all plane residuals minimised together, in JAX with optimistix."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx
from jaxtyping import Array, Float

from .moments import PlaneMoments


class Problem(NamedTuple):
    """One least squares problem over the shared rotation and the plane offsets, as arrays."""

    axes: Float[Array, "planes 3"]
    """Unit vector of each plane's axis, Manhattan frame at the linearisation point."""
    weights: Float[Array, " planes"]
    means_m: Float[Array, "planes 3"]
    roots: Float[Array, "planes 3 3"]
    free: Float[Array, " planes"]
    """1 where the offset is determined by points, 0 where it is held."""
    held_m: Float[Array, " planes"]


class Unknowns(NamedTuple):
    """What is fitted."""

    rotation_rad: Float[Array, " 3"]
    """Rotation vector: the planes' normals are ``exp([w]) e_axis``."""
    offsets_m: Float[Array, " planes"]


def rotation_matrix(vector_rad: Float[Array, " 3"]) -> Float[Array, "3 3"]:
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


class Solution(NamedTuple):
    """The minimum and how it was reached."""

    rotation_rad: Float[np.ndarray, " 3"]
    offsets_m: Float[np.ndarray, " planes"]
    cost: float
    """Half the sum of squares."""
    steps: int
    converged: bool


_MAX_STEPS = 64
"""From a start within 10 cm and a degree, Levenberg-Marquardt needs 3 to 12."""
_BLOCK = 32
"""Problems are padded to multiples of this many planes, so that rooms share one compiled solver."""


def solve(
    moments: PlaneMoments, axes: Float[np.ndarray, " planes"], start_m: Float[np.ndarray, " planes"]
) -> Solution:
    """Minimise over rotation and offsets.

    Args:
        moments: weighted moments per plane, Manhattan frame at the linearisation point.
        axes: 0, 1 or 2 for each plane.
        start_m: offsets to start from; planes without weight keep theirs.
    """
    n = len(start_m)
    padding = -n % _BLOCK
    free = (moments.weights > 0).astype(float)
    problem = Problem(
        axes=np.pad(np.eye(3)[axes], ((0, padding), (0, 0))),
        weights=np.pad(np.where(free > 0, moments.weights, 1.0), (0, padding), constant_values=1.0),
        means_m=np.pad(moments.means_m, ((0, padding), (0, 0))),
        roots=np.pad(moments.roots, ((0, padding), (0, 0), (0, 0))),
        free=np.pad(free, (0, padding)),
        held_m=np.pad(start_m, (0, padding)),
    )
    # Only for the duration of the call: the host's JAX settings are not ours to change.
    with jax.enable_x64(True):
        rotation, offsets, cost, steps, ok = _solve(
            Unknowns(jnp.zeros(3), jnp.asarray(problem.held_m)), jax.tree.map(jnp.asarray, problem)
        )
        return Solution(np.array(rotation), np.array(offsets)[:n], float(cost), int(steps), bool(ok))


@eqx.filter_jit
def _solve(start: Unknowns, problem: Problem):
    # Tolerances in the units of the residuals (standard errors): a ten-thousandth of one.
    solver = optx.LevenbergMarquardt(rtol=1e-10, atol=1e-10)
    found = optx.least_squares(residuals, solver, start, problem, max_steps=_MAX_STEPS, throw=False)
    cost = 0.5 * jnp.sum(jnp.square(residuals(found.value, problem)))
    ok = found.result == optx.RESULTS.successful
    return found.value.rotation_rad, found.value.offsets_m, cost, found.stats["num_steps"], ok
