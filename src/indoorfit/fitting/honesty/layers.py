"""Is a wall there twice, as when two passes of the scan were not brought together?"""

import numpy as np
from jaxtyping import Float

from indoorfit.model import Note

from .config import HonestyConfig
from .evidence import U95, Evidence, FacePoints

_PANEL_M = 2.0
"""About what one frame sees: on less, few frames that slipped a little each look like layers."""
_SQUARE_M = 0.1
"""In a square of this size both layers of a doubled wall are seen, but only one side of furniture's edge."""
_MIN_POINTS = 300
_MIN_SQUARE_POINTS = 6
_WINDOW = 0.2
"""Width of the windows in which density is counted, as a share of the layers' distance."""


def layer_notes(evidence: Evidence, points: FacePoints, config: HonestyConfig) -> tuple[Note, ...]:
    """LAYERED: faces with two layers over each other, farther apart than patches wander."""
    # What lies within the noise model's reach is in the intervals.
    noise = evidence.wall.noise
    wander_m = float(np.hypot(noise["tau_m"]["median"], noise["eta_m"]["median"]))
    parts, found = [], []
    for plane in evidence.judged:
        gaps_m = _layered_panels(points.places_m[plane], points.residuals_m[plane], config)
        wide = [gap_m for gap_m in gaps_m if 0.5 * gap_m > U95 * wander_m]
        if wide:
            gap_mm = 1e3 * float(np.median(wide))
            where = f"in {len(wide)} panel(s) of {_PANEL_M:g} m"
            found.append(plane)
            parts.append(f"{evidence.listed([plane])} ({gap_mm:.0f} mm apart {where})")
    if not parts:
        return ()
    return (
        Note(
            "LAYERED",
            f"Two layers over each other: {'; '.join(parts)}. Two passes of the scan do not agree, and the "
            "points cannot tell which one is right; the value lies between them. Register the scan again, or "
            "measure by hand.",
            evidence.named(found),
        ),
    )


def _layered_panels(
    places_m: Float[np.ndarray, "points 2"], residuals_m: Float[np.ndarray, " points"], config: HonestyConfig
) -> list[float]:
    """Distance of the layers in every panel that has two."""
    if len(residuals_m) < _MIN_POINTS:
        return []
    cells = np.floor((places_m - places_m.min(axis=0)) / _PANEL_M).astype(np.int64)
    key = cells[:, 0] * (int(cells[:, 1].max()) + 1) + cells[:, 1]
    order = np.argsort(key, kind="stable")
    gaps_m = []
    for rows in np.split(order, np.flatnonzero(np.diff(key[order])) + 1):
        if len(rows) >= _MIN_POINTS:
            gap_m = _layer_gap(places_m[rows], residuals_m[rows], config)
            if gap_m is not None:
                gaps_m.append(gap_m)
    return gaps_m


def _layer_gap(
    places_m: Float[np.ndarray, "points 2"], residuals_m: Float[np.ndarray, " points"], config: HonestyConfig
) -> float | None:
    """Distance of two layers, or None where there is one."""
    ordered = np.sort(residuals_m)
    n = len(ordered)
    count = np.arange(1, n)
    low = np.cumsum(ordered)[:-1] / count
    high = (ordered.sum() - np.cumsum(ordered)[:-1]) / (n - count)
    # Otsu's threshold: the split with the largest variance between the two sides.
    k = int(np.argmax(count * (n - count) * (high - low) ** 2))
    share = (k + 1) / n
    gap_m = float(high[k] - low[k])
    if min(share, 1.0 - share) < config.layer_share or gap_m <= 0.0:
        return None
    centres_m = np.array([low[k], 0.5 * (low[k] + high[k]), high[k]])
    near = np.abs(residuals_m - centres_m[:, None]) < 0.5 * _WINDOW * gap_m
    first, valley, second = near.sum(axis=1)
    # The valley must be one beyond the chance of counting, too.
    peak = min(first, second)
    if valley + 2.0 * np.sqrt(valley + 1.0) > peak or valley > config.layer_valley * peak:
        return None
    upper = residuals_m > ordered[k]
    return gap_m if _mixed_share(places_m, upper, config.layer_share) >= config.layer_mixed else None


def _mixed_share(places_m: Float[np.ndarray, "points 2"], upper: np.ndarray, least: float) -> float:
    """Share of the squares with enough points in which both layers occur."""
    squares = np.floor(places_m / _SQUARE_M).astype(np.int64)
    squares -= squares.min(axis=0)
    key = squares[:, 0] * (int(squares[:, 1].max()) + 1) + squares[:, 1]
    total = np.bincount(key)
    share = np.bincount(key, upper)[total >= _MIN_SQUARE_POINTS] / total[total >= _MIN_SQUARE_POINTS]
    return float(np.mean((share >= least) & (share <= 1.0 - least))) if len(share) else 0.0
