"""Do the residuals look as the noise model says, and did they teach it anything?"""

import numpy as np
from scipy.special import gammaincc

from indoorfit.model import Note

from ..uncertainty.field import block_covariance, build_field
from .config import HonestyConfig
from .evidence import Evidence

_MIN_CELLS = 5


def misfit_notes(evidence: Evidence, config: HonestyConfig) -> tuple[Note, ...]:
    """MISFIT: faces whose patches scatter far more than the common noise model says.

    The squares of a face's whitened residuals add up to chi-square, one degree of freedom less than patches
    for its own offset.
    """
    screened = evidence.wall.screened
    noise = evidence.wall.noise
    phi = np.log([noise[name]["median"] for name in ("tau_m", "length_m", "eta_m", "tilt_rad")])
    none = np.zeros(len(evidence.cells.plane))
    found = []
    for block in build_field(evidence.cells).blocks:
        plane = int(evidence.cells.plane[block.rows[0]])
        kept = np.ones(len(block.rows), bool) if screened is None else ~screened[block.rows]
        dof = int(kept.sum()) - 1
        if plane not in evidence.judged or dof < _MIN_CELLS:
            continue
        covariance = block_covariance(block, phi, none)[np.ix_(kept, kept)]
        residuals = block.target_m[kept]
        weighted = np.linalg.solve(covariance, np.column_stack([residuals, np.ones(dof + 1)]))
        offset = weighted[:, 0].sum() / weighted[:, 1].sum()
        square = float((residuals - offset) @ (weighted[:, 0] - offset * weighted[:, 1]))
        by_chance = float(gammaincc(0.5 * dof, 0.5 * square))
        if square > config.misfit_ratio * dof and by_chance < config.misfit_chance:
            found.append((plane, np.sqrt(square / dof)))
    if not found:
        return ()
    parts = "; ".join(f"{evidence.listed([plane])} by a factor of {ratio:.1f}" for plane, ratio in found)
    return (
        Note(
            "MISFIT",
            f"More scatter than the noise model has for the room as a whole: {parts}. Intervals of lengths "
            "that end there have been widened for it. Look there for what is not wall; scan it "
            "again or measure by hand.",
            evidence.named(plane for plane, _ in found),
        ),
    )


def prior_notes(evidence: Evidence) -> tuple[Note, ...]:
    """PRIOR_DOMINATED: the scan did not teach the noise model how large the errors are."""
    if not evidence.wall.noise.get("prior_dominated", False):
        return ()
    names = evidence.wall.noise["prior_dominated_by"]
    share = max(evidence.wall.noise[name]["share_of_prior_std"] for name in names)
    return (
        Note(
            "PRIOR_DOMINATED",
            f"The scan says little about how its errors behave ({', '.join(names)}: the uncertainty of the "
            f"logarithm is {100 * share:.0f} % of what it was before): widths of intervals are set by the "
            "prior. Choose the configuration of your sensor, or scan more of the walls.",
        ),
    )


def seen_notes(evidence: Evidence, config: HonestyConfig) -> tuple[Note, ...]:
    """OCCLUDED and CONTAMINATED: how much of each face was seen, and how much of that agrees."""
    coverage = evidence.data.coverage
    hidden = [k for k in evidence.judged if coverage[k] < config.min_coverage]
    notes = []
    if hidden:
        shares = ", ".join(f"{100 * coverage[k]:.0f} %" for k in hidden[:6])
        notes.append(
            Note(
                "OCCLUDED",
                f"Seen over less than {100 * config.min_coverage:.0f} % of its area: "
                f"{evidence.listed(hidden)} ({shares}). What was measured may be what stands before it; "
                "scan it again or measure by hand.",
                evidence.named(hidden),
            )
        )
    screened = evidence.wall.screened
    if screened is None:
        return tuple(notes)
    planes = evidence.cells.plane
    screened = screened[: len(planes)]
    spoilt = []
    for k in evidence.judged:
        own = screened[planes == k]
        # Two of a small face's few patches may be chance.
        if own.sum() > 2 and own.mean() > config.max_screened:
            spoilt.append((k, int(own.sum()), len(own)))
    if spoilt:
        parts = "; ".join(f"{evidence.listed([k])}: {bad} of {n} patches" for k, bad, n in spoilt)
        notes.append(
            Note(
                "CONTAMINATED",
                f"Much of what was taken for wall contradicts the rest of it: {parts}. They count for little "
                "in the fit, but if more than half of a face is furniture, the furniture is measured. "
                "The plan marks the wall; clear it and scan it again, or measure by hand.",
                evidence.named(k for k, _, _ in spoilt),
            )
        )
    return tuple(notes)
