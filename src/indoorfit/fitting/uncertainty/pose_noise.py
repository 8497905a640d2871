"""The pose model's noise in plain values and plain words."""

from typing import Any

import numpy as np
from jaxtyping import Float

from .laplace import HyperDraws
from .pose_system import Robustness
from .wall_noise import PRIOR_DOMINATED

_NAMES = ("shift_m", "turn_rad", "drift_odds", "memory_frames", "wall_m", "eta_m", "lean_m")


def describe_pose_noise(
    hyper: HyperDraws, prior_stds: Float[np.ndarray, " 7"], robust: Robustness, converged: bool
) -> dict[str, Any]:
    """Posterior of the seven scales, what the prior decided, and a sentence."""
    medians = np.exp(hyper.mean)
    shares = hyper.std / prior_stds
    dominated = [name for name, share in zip(_NAMES, shares, strict=True) if share > PRIOR_DOMINATED]
    screened = float(np.mean(robust.inflation_m2 > 0))
    described = {
        name: {"median": float(median), "log_std": float(std), "share_of_prior_std": float(share)}
        for name, median, std, share in zip(_NAMES, medians, hyper.std, shares, strict=True)
    }
    drift = medians[2] / (1 + medians[2])
    sentence = (
        f"A frame is off by about {1e3 * medians[0]:.2g} mm and {1e3 * medians[1]:.2g} mrad per axis, "
        f"{100 * drift:.0f} % of it drift that lasts about {medians[3]:.0f} frames; walls and lens add "
        f"{1e3 * medians[4]:.2g} mm that all frames share, and each patch in each frame "
        f"{1e3 * medians[5]:.2g} mm; "
        f"{100 * screened:.0f} % of the wall patches contradict their neighbours and count for little."
    )
    displaced = float(np.mean(np.any(robust.slip_inflation > 0, axis=1)))
    if displaced:
        sentence += f" {100 * displaced:.0f} % of the frames stand far from where the others put them."
    if dominated:
        sentence += " The scan says little about " + " and ".join(dominated) + ": there the prior decides."
    return {
        "model": "pose_field",
        **described,
        "prior_dominated": bool(dominated),
        "prior_dominated_by": dominated,
        "screened_share": screened,
        "displaced_frames_share": displaced,
        "mode_converged": converged,
        "sentence": sentence,
    }
