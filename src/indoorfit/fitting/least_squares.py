"""The joint fit's core: all plane residuals minimised together, in JAX with optimistix."""

from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from .moments import PlaneMoments
from .plane_residuals import Problem, Unknowns
from .solver_cache import compiled_solver


class Solution(NamedTuple):
    """The minimum and how it was reached."""

    rotation_rad: Float[np.ndarray, " 3"]
    offsets_m: Float[np.ndarray, " planes"]
    cost: float
    """Half the sum of squares."""
    steps: int
    converged: bool


_BLOCK = 32
"""Problems are padded to multiples of this many planes, so that rooms share one compiled solver."""


def solve(
    moments: PlaneMoments, normals: Float[np.ndarray, "planes 3"], start_m: Float[np.ndarray, " planes"]
) -> Solution:
    """Minimise over rotation and offsets.

    Args:
        moments: weighted moments per plane, Manhattan frame at the linearisation point.
        normals: unit vector along each plane's axis, same frame.
        start_m: offsets to start from; planes without weight keep theirs.
    """
    n = len(start_m)
    padding = -n % _BLOCK
    free = (moments.weights > 0).astype(float)
    problem = Problem(
        axes=np.pad(normals, ((0, padding), (0, 0))),
        weights=np.pad(np.where(free > 0, moments.weights, 1.0), (0, padding), constant_values=1.0),
        means_m=np.pad(moments.means_m, ((0, padding), (0, 0))),
        roots=np.pad(moments.roots, ((0, padding), (0, 0), (0, 0))),
        free=np.pad(free, (0, padding)),
        held_m=np.pad(start_m, (0, padding)),
    )
    start = Unknowns(np.zeros(3), problem.held_m)
    # Only for the duration of the call: the host's JAX settings are not ours to change.
    with jax.enable_x64(True):
        rotation, offsets, cost, steps, ok = compiled_solver(n + padding)(start, problem)
        return Solution(np.array(rotation), np.array(offsets)[:n], float(cost), int(steps), bool(ok))
