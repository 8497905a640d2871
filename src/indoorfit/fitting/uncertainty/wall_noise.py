"""The wall field's noise model in plain values and plain words."""

from typing import Any

import numpy as np
from jaxtyping import Float

from .laplace import HyperDraws

PRIOR_DOMINATED = 0.8
"""A posterior this wide, as a share of the prior's standard deviation, has learnt next to nothing."""

_NAMES = ("tau_m", "length_m", "eta_m", "tilt_rad")


def describe_wall_noise(
    hyper: HyperDraws,
    prior_stds: Float[np.ndarray, " 4"],
    inflation_m2: Float[np.ndarray, " cells"],
    variances_m2: Float[np.ndarray, " cells"],
    converged: bool,
) -> dict[str, Any]:
    """Posterior of tau, l and eta (metres) and tilt (radians), what the prior decided, and a sentence.

    A field below the cells' own point noise has no length worth knowing: that is a clean scan, and not one
    that the prior dominates. The tilt never makes it one: where walls are turned by less than they wander,
    no tilt can be told from none, and none matters.
    """
    medians = np.exp(hyper.mean)
    shares = hyper.std / prior_stds
    clean = medians[0] < float(np.sqrt(np.median(variances_m2)))
    wide = [name for name, share in zip(_NAMES[:3], shares, strict=False) if share > PRIOR_DOMINATED]
    dominated = [] if clean else wide
    screened = float(np.mean(inflation_m2 > 0))
    described = {
        name: {"median": float(median), "log_std": float(std), "share_of_prior_std": float(share)}
        for name, median, std, share in zip(_NAMES, medians, hyper.std, shares, strict=True)
    }
    tau_mm, eta_mm, tilt_deg = 1e3 * medians[0], 1e3 * medians[2], np.degrees(medians[3])
    sentence = (
        f"Each wall's position wanders by about {tau_mm:.2g} mm over patches of about {medians[1]:.1f} m "
        f"(registration, warping), is turned as a whole by about {tilt_deg:.2g} degrees, and single patches "
        f"scatter by another {eta_mm:.2g} mm; "
        f"{100 * screened:.0f} % of the patches contradict their neighbours and count for little."
    )
    if dominated:
        sentence += " The scan says little about " + " and ".join(dominated) + ": there the prior decides."
    return {
        "model": "wall_field",
        **described,
        "prior_dominated": bool(dominated),
        "prior_dominated_by": dominated,
        "screened_share": screened,
        "mode_converged": converged,
        "sentence": sentence,
    }
