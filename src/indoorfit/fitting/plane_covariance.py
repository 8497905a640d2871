"""How the planes of a fit err together."""

import numpy as np
from jaxtyping import Float

from .belief import Belief


def plane_covariance(belief: Belief, inflation: float = 1.0) -> Float[np.ndarray, "planes planes"]:
    """Covariance of the plane offsets, square metres: how lengths that share a wall err together.

    Where two noise models are fused, the average with their weights.
    """
    n_planes = len(belief.shape.planes)
    # After the rotation; the yaws of oblique planes are none of the offsets.
    matrix = np.eye(n_planes, 3 + len(belief.shape.parameters), k=3)
    covariance = belief.wall.with_contrasts(matrix).covariance()
    if belief.pose is not None:
        pose = belief.pose.with_contrasts(matrix).covariance()
        covariance = belief.wall_share * covariance + (1.0 - belief.wall_share) * pose
    return inflation**2 * covariance
