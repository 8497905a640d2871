"""Is each face flat and parallel to the others, so that one number can be its distance?"""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import ndtr, ndtri

from indoorfit.model import Note

from ..uncertainty.cells import ROTATIONS, Cells
from ..uncertainty.field import log_likelihoods
from ..uncertainty.wall_field import WallFieldConfig, fit_wall_field
from .config import HonestyConfig
from .evidence import U95, Evidence

_SHAPES = 4
"""Extra columns per plane: slope and bow along either axis within it."""
_NO_TILT_RAD = 1e-6
"""A microradian moves the end of a wall of 10 m by 10 um: the field's own tilt is as good as none."""
_KNOWN_LOG_STD = 0.01
"""To a hundredth, so that the data have no say in it."""
_MIN_CELLS = 8
"""Fewer cells cannot tell an offset, two slopes and two bows from noise."""


def flatness_notes(evidence: Evidence, config: HonestyConfig, field: WallFieldConfig) -> tuple[Note, ...]:
    """NOT_PARALLEL and NOT_PLANAR.

    Every face gets two slopes and two bows of its own beside its offset, and the wall field is estimated
    anew: a tilted wall must not pass as one that wanders. A face is reported where one of them is larger than
    `tilt_sigmas` of its standard uncertainty (more for many faces, so that a false alarm is as likely as in a
    single test), and moves its ends by more than its position's own interval, or that of half of the faces.
    """
    planes = evidence.cells.plane
    judged = [k for k in evidence.judged if np.sum(planes == k) >= _MIN_CELLS]
    if not judged:
        return ()
    cells, halves_m = _freed(evidence, judged)
    effects_m, stds_m = _effects(cells, len(judged), field)
    limits_m = U95 * evidence.offset_std_m[judged]
    # A spoilt wall has widened its own interval, and would raise its own bar.
    limits_m = np.minimum(limits_m, np.median(limits_m))
    factor = _for_all(config.tilt_sigmas, int(np.isfinite(stds_m).sum()))
    found = (np.abs(effects_m) > factor * stds_m) & (np.abs(effects_m) > limits_m[:, None])
    notes = []
    for first, code in ((0, "NOT_PARALLEL"), (2, "NOT_PLANAR")):
        rows = np.flatnonzero(found[:, first : first + 2].any(axis=1))
        if len(rows):
            parts = [
                _said(
                    code,
                    evidence.listed([judged[row]]),
                    effects_m[row],
                    stds_m[row],
                    halves_m[row],
                    found[row],
                )
                for row in rows
            ]
            notes.append(Note(code, _message(code, parts), evidence.named(judged[row] for row in rows)))
    return tuple(notes)


def _for_all(sigmas: float, n_tests: int) -> float:
    """The factor that n tests together exceed as seldom as one exceeds `sigmas` (Bonferroni)."""
    return float(-ndtri(ndtr(-sigmas) / max(n_tests, 1)))


def _said(
    code: str,
    name: str,
    effects_m: Float[np.ndarray, " 4"],
    stds_m: Float[np.ndarray, " 4"],
    halves_m: Float[np.ndarray, " 2"],
    found: Bool[np.ndarray, " 4"],
) -> str:
    """One face in words, with the larger of what was found along its two directions."""
    columns = (0, 1) if code == "NOT_PARALLEL" else (2, 3)
    k = max((column for column in columns if found[column]), key=lambda column: abs(effects_m[column]))
    size_mm, std_mm = 1e3 * abs(effects_m[k]), 1e3 * stds_m[k]
    if code == "NOT_PARALLEL":
        angle_deg = np.degrees(np.arctan(1e-3 * size_mm / halves_m[k]))
        return f"{name} by {angle_deg:.2g}° ({_mm(2.0 * size_mm, 2.0 * std_mm)} from end to end)"
    return f"{name} by {_mm(size_mm, std_mm)}"


def _mm(size_mm: float, std_mm: float) -> str:
    """Both with the decimals that the uncertainty has."""
    decimals = max(0, int(np.ceil(-np.log10(max(std_mm, 1e-3)))))
    return f"{size_mm:.{decimals}f} ± {std_mm:.{decimals}f} mm"


def _message(code: str, parts: list[str]) -> str:
    if code == "NOT_PARALLEL":
        return (
            f"Out of parallel: {'; '.join(parts)}. Lengths that end there differ from place to place; the "
            "value is that of the mean plane, and its interval does not cover the difference. Say where you "
            "measure, or raise type_b.definition_std_m."
        )
    return (
        f"Not flat: {'; '.join(parts)} between middle and ends. Lengths that end there differ from place to "
        "place; the value is that of the mean plane. Say where you measure, or raise type_b.definition_std_m."
    )


def _freed(evidence: Evidence, judged: list[int]) -> tuple[Cells, Float[np.ndarray, "faces 2"]]:
    """Cells with free slopes and bows instead of the rotation, and half the extent of every face.

    The columns are scaled so that a parameter is the effect at the face's ends in metres.
    """
    kept = np.isin(evidence.cells.plane, judged)
    old = evidence.cells
    n_offsets = old.n_params - ROTATIONS
    design = np.zeros((int(kept.sum()), ROTATIONS + n_offsets + _SHAPES * len(judged)))
    planes, centroids = old.plane[kept], old.centroids_m[kept]
    design[np.arange(len(planes)), ROTATIONS + planes] = -1.0
    halves_m = np.ones((len(judged), 2))
    for k, plane in enumerate(judged):
        rows = np.flatnonzero(planes == plane)
        start = ROTATIONS + n_offsets + _SHAPES * k
        own_m = evidence.shape.planes[plane].to_own(centroids[rows])
        for j, axis in enumerate(a for a in range(3) if a != evidence.shape.planes[plane].axis):
            along = own_m[:, axis]
            low, high = along.min(), along.max()
            halves_m[k, j] = max(0.5 * (high - low), 1e-3)
            scaled = (along - 0.5 * (low + high)) / halves_m[k, j]
            design[rows, start + j] = scaled - scaled.mean()
            # Three patches in a row are the least that can show a bow.
            if len(np.unique(np.round(scaled, 1))) >= 3:
                design[rows, start + 2 + j] = scaled**2 - np.mean(scaled**2)
    freed = Cells(
        plane=planes,
        design=design,
        centroids_m=centroids,
        residuals_m=old.residuals_m[kept],
        variances_m2=old.variances_m2[kept],
        counts=old.counts[kept],
    )
    return freed, halves_m


def _effects(
    cells: Cells, n_faces: int, config: WallFieldConfig
) -> tuple[Float[np.ndarray, "faces 4"], Float[np.ndarray, "faces 4"]]:
    """Slopes and bows with their standard uncertainties, metres at the faces' ends; zero where not free."""
    # Screened anew, too: what a plane contradicts may be what a tilted plane explains.
    # Slopes are free here: a field that has them, too, in the room or on one wall, could be any part of them.
    straight = replace(
        config, tilt_median_rad=_NO_TILT_RAD, tilt_log_std=_KNOWN_LOG_STD, wall_dof=float("inf")
    )
    fit = fit_wall_field(cells, straight)
    _, steps, covariances = log_likelihoods(fit.field, fit.mode.point[None], fit.inflation_m2)
    values, variances = np.zeros(cells.n_params), np.full(cells.n_params, np.inf)
    values[cells.seen], variances[cells.seen] = steps[0], np.diagonal(covariances[0])
    first = cells.n_params - _SHAPES * n_faces
    shape = (n_faces, _SHAPES)
    return values[first:].reshape(shape), np.sqrt(variances[first:]).reshape(shape)
