"""How far the points of a scan lie from the model: all together, and place by place on each face."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.fitting import AssociationConfig, claims
from indoorfit.geometry import MAD_TO_STD
from indoorfit.model import Face, FitResult

_CELLS = 90
"""Along the longer side of a face, at most: finer than a hand's breadth on most walls."""
_MIN_CELL_M = 0.05
_MIN_POINTS = 3
"""A median of fewer is one point's noise."""
_BINS = 41
_SHOWN_STDS = 5.0
"""Reach of the histogram in robust standard deviations; beyond it are things in the room."""


@dataclass(frozen=True)
class ResidualMap:
    """Medians of the residuals on a face, row 0 at the top, columns to the right as seen from inside."""

    face: str
    cell_m: float
    medians_m: Float[np.ndarray, "rows columns"]
    """Positive in front of the face, on the room's side; NaN where fewer than three points were seen."""


@dataclass(frozen=True)
class Residuals:
    """Signed distances of the points that belong to a face from that face, positive into the room."""

    n_points: int
    std_m: float
    """Robust: 1.4826 times the median absolute deviation."""
    edges_m: Float[np.ndarray, " edges"]
    """Of the histogram's bins, around zero."""
    counts: Int[np.ndarray, " bins"]
    maps: tuple[ResidualMap, ...]


def residuals_of(
    result: FitResult,
    points_m: Float[np.ndarray, "points 3"],
    association: AssociationConfig | None = None,
) -> Residuals | None:
    """Distances of all points that the faces claim, as the joint fit does.

    Args:
        result: the fitted model.
        points_m: the scan, scan frame, metres.
        association: which points a plane may claim.

    Returns:
        None where no face claims a point.
    """
    local = result.frame.to_manhattan(points_m)
    claimed = [own for own, _ in claims(local, result.shape, association or AssociationConfig())]
    everything, maps = [], []
    for face in result.faces:
        plane = result.shape.planes[face.plane]
        corners = plane.to_own(result.frame.to_manhattan(face.rings_m[0]))
        low, high = corners.min(axis=0), corners.max(axis=0)
        own = plane.to_own(local[claimed[face.plane]])
        along = [axis for axis in range(3) if axis != plane.axis]
        # A plane may hold several faces; each gets its own points.
        own = own[((own >= low) & (own <= high))[:, along].all(axis=1)]
        if len(own):
            residuals_m = (own[:, plane.axis] - plane.offset_m) * _inward(result, face)
            everything.append(residuals_m)
            maps.append(_map(face, own, residuals_m, low, high, result))
    if not everything:
        return None
    together = np.concatenate(everything)
    std_m = max(MAD_TO_STD * float(np.median(np.abs(together - np.median(together)))), 1e-5)
    reach_m = _SHOWN_STDS * std_m
    counts, edges_m = np.histogram(together, bins=_BINS, range=(-reach_m, reach_m))
    return Residuals(len(together), std_m, edges_m, counts, tuple(maps))


def _inward(result: FitResult, face: Face) -> float:
    """+1 or -1: the direction into the room along the axis of the face's plane."""
    return -float(result.shape.planes[face.plane].outward)


def _map(
    face: Face,
    points: Float[np.ndarray, "points 3"],
    residuals_m: Float[np.ndarray, " points"],
    low: Float[np.ndarray, " 3"],
    high: Float[np.ndarray, " 3"],
    result: FitResult,
) -> ResidualMap:
    """Medians in square cells; Manhattan frame."""
    plane = result.shape.planes[face.plane]
    if plane.axis == 2:
        # As on the plan: x to the right, y upward.
        across, up, sign = 0, 1, 1.0
    else:
        across, up = 1 - plane.axis, 2
        # Looking along the outward normal with z up, the right hand points to outward x z.
        sign = _inward(result, face) * (1.0 if plane.axis == 0 else -1.0)
    cell_m = max(_MIN_CELL_M, float(np.max(high - low)) / _CELLS)
    columns, rows = (max(1, int(np.ceil((high[k] - low[k]) / cell_m - 1e-9))) for k in (across, up))
    from_left = points[:, across] - low[across] if sign > 0 else high[across] - points[:, across]
    column = np.clip((from_left / cell_m).astype(np.int64), 0, columns - 1)
    row = np.clip(((high[up] - points[:, up]) / cell_m).astype(np.int64), 0, rows - 1)
    return ResidualMap(face.id, cell_m, _medians(row * columns + column, residuals_m, rows, columns))


def _medians(
    cell: Int[np.ndarray, " points"], values: Float[np.ndarray, " points"], rows: int, columns: int
) -> Float[np.ndarray, "rows columns"]:
    order = np.lexsort((values, cell))
    counts = np.bincount(cell, minlength=rows * columns)
    starts = np.cumsum(counts) - counts
    medians = np.full(rows * columns, np.nan)
    full = np.flatnonzero(counts >= _MIN_POINTS)
    lower, upper = starts[full] + (counts[full] - 1) // 2, starts[full] + counts[full] // 2
    medians[full] = 0.5 * (values[order[lower]] + values[order[upper]])
    return medians.reshape(rows, columns)
