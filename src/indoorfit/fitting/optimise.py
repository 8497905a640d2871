"""Levenberg-Marquardt over all plane residuals (optimistix)."""

import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Bool, Float, Int

from .plane_residuals import Problem, Unknowns, residuals

_MAX_STEPS = 64
"""From a start within 10 cm and a degree, Levenberg-Marquardt needs 3 to 12."""


def minimise(
    start: Unknowns, problem: Problem
) -> tuple[Float[Array, " 3"], Float[Array, " planes"], Float[Array, ""], Int[Array, ""], Bool[Array, ""]]:
    """Rotation, offsets, cost, steps and whether it converged; traceable, never raises."""
    # In the units of the residuals (standard errors): a hundred-millionth of one.
    solver = optx.LevenbergMarquardt(rtol=1e-8, atol=1e-8)
    found = optx.least_squares(residuals, solver, start, problem, max_steps=_MAX_STEPS, throw=False)
    cost = 0.5 * jnp.sum(jnp.square(residuals(found.value, problem)))
    ok = found.result == optx.RESULTS.successful
    rotation, offsets = (jnp.asarray(part) for part in found.value)
    return rotation, offsets, cost, found.stats["num_steps"], ok
