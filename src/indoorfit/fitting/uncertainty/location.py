"""Robust estimate of theta from cells: Student-t weights, iterated."""

import numpy as np
from jaxtyping import Float

from indoorfit.geometry import MAD_TO_STD

from .cells import ROTATIONS, Cells

ROTATION_PRIOR_STD_RAD = 1.0
"""Keeps the normal equations regular where the cells do not fix the rotation (a single plane). A radian is
more than the 24-fold labelling leaves open, and moves a determined one by less than 1e-6 of its error."""


def ridge(n_params: int) -> Float[np.ndarray, " params"]:
    """Prior precision per parameter: 1/rad^2 for the rotation, none for the offsets."""
    precision = np.zeros(n_params)
    precision[:ROTATIONS] = 1.0 / ROTATION_PRIOR_STD_RAD**2
    return precision


def weighted_map(cells: Cells, precisions: Float[np.ndarray, " cells"]) -> Float[np.ndarray, "params cells"]:
    """The linear map L with ``step = L @ residuals_m`` that minimises the weighted squares.

    Args:
        cells: with `cells.seen` true for at least the offsets that matter; unseen rows of L are zero.
        precisions: 1/m^2 per cell.
    """
    normal, weighted = _normal_equations(cells, precisions)
    linear = np.zeros((cells.n_params, len(precisions)))
    linear[cells.seen] = np.linalg.solve(normal, weighted)
    return linear


def _normal_equations(
    cells: Cells, precisions: Float[np.ndarray, " cells"]
) -> tuple[Float[np.ndarray, "seen seen"], Float[np.ndarray, "seen cells"]]:
    """Matrix and right-hand sides, one for each cell, of the step in the parameters that were seen."""
    design = -cells.design[:, cells.seen]  # the step must cancel the residual, hence the sign
    weighted = design.T * precisions
    return weighted @ design + np.diag(ridge(cells.n_params)[cells.seen]), weighted


def student_t_precisions(
    cells: Cells, dof: float, max_steps: int = 50, tolerance: float = 1e-6
) -> Float[np.ndarray, " cells"]:
    """Cell precisions of a Student-t fit with base weights 1 / s, 1/m^2.

    s, the standard error from the points alone, makes 1 / s lie between 1 / s^2 (right for point noise
    alone) and 1 (right for registration error alone). It does not depend on the noise model, so that the
    estimate stands still when the field becomes nearly singular. Cells that are seen from far away or at a
    grazing angle are noisy and biased together, and count for less, as sqrt(n) alone would not have it.

    Args:
        cells: residuals and design.
        dof: degrees of freedom; 4 gives 95 % efficiency at the normal within a few per cent.
        max_steps: of the reweighting, which converges linearly; more than enough.
        tolerance: largest relative change of a weight that counts as standing still.
    """
    # Floored at a thousandth of the median: exact cells of a noise-free simulation must not take over.
    point_std_m = np.sqrt(cells.variances_m2)
    base = 1.0 / np.maximum(point_std_m, 1e-3 * np.median(point_std_m) + 1e-12)
    base = base / np.mean(base)
    # Medians per plane start inside the bulk even where a third of a wall is furniture.
    centre = np.zeros(int(cells.plane.max()) + 1)
    for plane in np.unique(cells.plane):
        centre[plane] = np.median(cells.residuals_m[cells.plane == plane])
    remaining = cells.residuals_m - centre[cells.plane]
    weights = np.zeros_like(base)
    scale = 1.0
    for _ in range(max_steps):
        # 1 nm: a noise-free simulation must not divide by zero.
        scale = max(MAD_TO_STD * float(np.median(np.abs(remaining))), 1e-9)
        updated = (dof + 1) / (dof + (remaining / scale) ** 2)
        still = float(np.max(np.abs(updated - weights))) < tolerance
        weights = updated
        if still:
            break
        # One right-hand side: the whole map would take most of the time of a storey's fit.
        normal, weighted = _normal_equations(cells, base * weights / scale**2)
        step = np.linalg.solve(normal, weighted @ cells.residuals_m)
        remaining = cells.residuals_m + cells.design[:, cells.seen] @ step
    return base * weights / scale**2
