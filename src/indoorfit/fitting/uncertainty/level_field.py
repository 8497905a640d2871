"""Floor and ceiling err together: a frame that is too high has put both too high."""

from itertools import combinations

import numpy as np
from jaxtyping import Float, Int

from indoorfit.geometry import MAD_TO_STD

from .cells import Cells
from .field import LOG_ETA, LOG_LENGTH, LOG_TAU, Block

_APART_M = 0.35
"""Patches of floor and ceiling within half a patch of each other, in plan, are over each other."""
_CLIP_SIGMAS = 3.0
"""A box on the floor is no error of registration."""


def level_blocks(cells: Cells, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
    """The blocks of floors and ceilings."""
    return tuple(block for block in blocks if cells.axes[block.rows[0]] == 2)


def common_share(
    cells: Cells, levels: tuple[Block, ...], phi: Float[np.ndarray, " 4"], prior: float, weight: float
) -> float:
    """Correlation of the fields of floor and ceiling over each other, 0 to 1.

    The correlation of the residuals of patches over each other, as if they had no noise of their own, and the
    prior, each with its weight. Patches near each other are not independent: their effective number follows
    Clifford, Richardson and Hemon 1989, Biometrics 45.

    Args:
        cells: of all planes.
        levels: see `level_blocks`.
        phi: log of the noise scales.
        prior: the correlation that is expected.
        weight: of the prior, in effective patches.
    """
    found, number = 0.0, 0.0
    tau, length, eta = (float(np.exp(phi[k])) for k in (LOG_TAU, LOG_LENGTH, LOG_ETA))
    for first, second in combinations(levels, 2):
        apart_m = _in_plan_m(cells, first.rows, second.rows)
        nearest = apart_m.argmin(axis=1)
        over = apart_m.min(axis=1) < _APART_M
        if over.sum() < 3:
            continue
        rows = first.rows[over], second.rows[nearest[over]]
        one, other = (_centred(cells.residuals_m[own]) for own in rows)
        scale_m2 = float(np.sqrt(np.mean(one**2) * np.mean(other**2)))
        reliable = tau**2 / (tau**2 + eta**2 + float(np.median(cells.variances_m2[np.concatenate(rows)])))
        likeness = reliable * np.exp(-_in_plan_m(cells, rows[0], rows[0]) / length)
        np.fill_diagonal(likeness, 1.0)
        n = len(one) ** 2 / float(np.sum(likeness**2)) * reliable**2
        correlation = float(np.mean(one * other)) / max(scale_m2, 1e-18) / reliable
        found += n * float(np.clip(correlation, -1.0, 1.0))
        number += n
    return float(np.clip((weight * prior + found) / (weight + number), 0.0, 1.0))


def add_common(
    covariance: Float[np.ndarray, "params params"],
    cells: Cells,
    levels: tuple[Block, ...],
    parts: list[Float[np.ndarray, "params _"]],
    phi: Float[np.ndarray, " 4"],
    share: float,
) -> None:
    """Add what floors and ceilings have in common, in place: share tau^2 exp(-h / l), h in plan.

    Fields with one correlation at every place have a covariance matrix for every share from 0 to 1.

    Args:
        covariance: of theta.
        cells: of all planes.
        levels: see `level_blocks`.
        parts: d theta / d residual of each level's own cells.
        phi: log of the noise scales.
        share: correlation at one place.
    """
    tau_m2, length_m = np.exp(2 * phi[LOG_TAU]), np.exp(phi[LOG_LENGTH])
    for i, j in combinations(range(len(levels)), 2):
        shape = np.exp(-_in_plan_m(cells, levels[i].rows, levels[j].rows) / length_m)
        both = share * tau_m2 * (parts[i] @ shape @ parts[j].T)
        covariance += both + both.T


def _in_plan_m(
    cells: Cells, first: Int[np.ndarray, " n"], second: Int[np.ndarray, " m"]
) -> Float[np.ndarray, "n m"]:
    plan_m = cells.centroids_m[:, :2]
    return np.linalg.norm(plan_m[first][:, None] - plan_m[second][None], axis=2)


def _centred(residuals_m: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    away_m = residuals_m - np.median(residuals_m)
    limit_m = _CLIP_SIGMAS * MAD_TO_STD * float(np.median(np.abs(away_m)))
    return np.clip(away_m, -limit_m, limit_m)
