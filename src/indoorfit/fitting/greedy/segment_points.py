"""The scan's points and surfels by segment."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True)
class SegmentPoints:
    """Points and surfels sorted by segment; Manhattan frame, metres."""

    points_m: Float[np.ndarray, "points 3"]
    point_starts: Int[np.ndarray, " segments1"]
    surfels_m: Float[np.ndarray, "surfels 3"]
    surfel_starts: Int[np.ndarray, " segments1"]

    def points(self, segments: Iterable[int]) -> Float[np.ndarray, "points 3"]:
        """All points of some segments (the thesis' point matrix, 3.2.4)."""
        return _gather(self.points_m, self.point_starts, segments)

    def surfels(self, segments: Iterable[int]) -> Float[np.ndarray, "surfels 3"]:
        """All surfels of some segments."""
        return _gather(self.surfels_m, self.surfel_starts, segments)

    def turned(self, R_new_old: Float[np.ndarray, "3 3"]) -> "SegmentPoints":
        """The same in a frame with the same origin and other axes."""
        return SegmentPoints(
            self.points_m @ R_new_old.T, self.point_starts, self.surfels_m @ R_new_old.T, self.surfel_starts
        )


def segment_points(
    points_m: Float[np.ndarray, "points 3"],
    point_labels: Int[np.ndarray, " points"],
    surfels_m: Float[np.ndarray, "surfels 3"],
    surfel_labels: Int[np.ndarray, " surfels"],
    n_segments: int,
) -> SegmentPoints:
    """Sort by label; label -1 is left out."""
    return SegmentPoints(
        *_sorted(points_m, point_labels, n_segments), *_sorted(surfels_m, surfel_labels, n_segments)
    )


def _sorted(
    rows_m: Float[np.ndarray, "rows 3"], labels: Int[np.ndarray, " rows"], n: int
) -> tuple[Float[np.ndarray, "kept 3"], Int[np.ndarray, " segments1"]]:
    kept = np.flatnonzero(labels >= 0)
    order = kept[np.argsort(labels[kept], kind="stable")]
    return rows_m[order], np.searchsorted(labels[order], np.arange(n + 1))


def _gather(
    rows_m: Float[np.ndarray, "rows 3"], starts: Int[np.ndarray, " segments1"], segments: Iterable[int]
) -> Float[np.ndarray, "picked 3"]:
    return np.concatenate([rows_m[:0]] + [rows_m[starts[k] : starts[k + 1]] for k in segments])
