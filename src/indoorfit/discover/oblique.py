"""Walls that follow neither axis: the lines on which they were seen."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import FaceClass, Segments, Surfels

from .surfaces import Surfaces
from .world import WorldConfig, oblique_segments

_SAME_YAW = float(np.cos(np.radians(5.0)))
"""Pieces of one wall agree within this angle: a piece of 1 m that is off by 5 cm is turned by 3 degrees."""


@dataclass(frozen=True)
class ObliqueLine:
    """One upright plane that follows neither axis, as far as it was seen; Manhattan frame."""

    yaw_rad: float
    """Of its normal; to which side it looks is not known."""
    offset_m: float
    points_m: Float[np.ndarray, "points 3"]
    """Its surfels."""
    segments: Int[np.ndarray, " _"]
    """The segments that they come from."""

    @property
    def normal(self) -> Float[np.ndarray, " 2"]:
        """Unit vector across it."""
        return np.array([np.cos(self.yaw_rad), np.sin(self.yaw_rad)])

    @property
    def along(self) -> Float[np.ndarray, " 2"]:
        """Unit vector along it."""
        return np.array([-np.sin(self.yaw_rad), np.cos(self.yaw_rad)])

    @property
    def ends_m(self) -> Float[np.ndarray, "2 2"]:
        """Where it was seen to begin and to end: all but the outermost hundredth."""
        reach_m = np.percentile(self.points_m[:, :2] @ self.along, [1, 99])
        return self.offset_m * self.normal + reach_m[:, None] * self.along

    def crossing_m(self, axis: int, at_m: float) -> Float[np.ndarray, " 2"]:
        """Where it crosses a line of constant x or y."""
        other_m = (self.offset_m - self.normal[axis] * at_m) / self.normal[1 - axis]
        return np.array([at_m, other_m] if axis == 0 else [other_m, at_m])

    def closing_m(self, axis: int, walls_m: Float[np.ndarray, " n"], reach_m: float) -> list[float]:
        """Where its two ends lie across an axis: where it meets the walls along that axis, if near its ends.

        Args:
            axis: 0 or 1.
            walls_m: positions of the walls across the other axis.
            reach_m: how far its last surfel may lie before such a wall.
        """
        found = []
        for end_m in self.ends_m:
            near_m = walls_m[np.abs(walls_m - end_m[1 - axis]) < reach_m]
            place_m = end_m
            if len(near_m):
                nearest = near_m[np.argmin(np.abs(near_m - end_m[1 - axis]))]
                place_m = self.crossing_m(1 - axis, float(nearest))
            found.append(float(place_m[axis]))
        return found


def oblique_lines(
    surfels: Surfels,
    segments: Segments,
    classes: tuple[FaceClass | None, ...],
    surfaces: Surfaces,
    merge_m: float,
    config: WorldConfig,
) -> tuple[ObliqueLine, ...]:
    """The oblique walls of a scan, largest first.

    Args:
        surfels: Manhattan frame.
        segments: of these surfels.
        classes: of these segments.
        surfaces: sorted evidence.
        merge_m: pieces that lie nearer to each other's line are one wall, as on the other walls.
        config: what counts as oblique.
    """
    chosen = np.flatnonzero(
        oblique_segments(segments, config, config.min_oblique_m2)
        & np.array([name is None for name in classes], bool)
        & (segments.centres_m[:, 2] < surfaces.ceiling_height_m)
    )
    groups: list[list[int]] = []
    for k in chosen[np.argsort(-segments.areas_m2[chosen], kind="stable")].tolist():
        home = next((group for group in groups if _one_wall(segments, group[0], k, merge_m)), None)
        if home is None:
            groups.append([k])
        else:
            home.append(k)
    return tuple(_line(surfels, segments, np.array(group)) for group in groups)


def _one_wall(segments: Segments, first: int, second: int, merge_m: float) -> bool:
    normal, other = segments.normals[first], segments.normals[second]
    apart_m = (segments.centres_m[second] - segments.centres_m[first])[:2] @ normal[:2]
    return abs(float(normal @ other)) > _SAME_YAW and abs(float(apart_m)) < merge_m


def _line(surfels: Surfels, segments: Segments, group: Int[np.ndarray, " _"]) -> ObliqueLine:
    """The upright plane through the surfels of some segments."""
    points_m = surfels.positions_m[np.isin(segments.labels, group)]
    mean_m = points_m[:, :2].mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((points_m[:, :2] - mean_m).T))
    normal = axes[:, 0]
    yaw_rad = float(np.arctan2(normal[1], normal[0]))
    return ObliqueLine(yaw_rad, float(normal @ mean_m), points_m, group)
