"""Lines of sight, where the scan tells them: where on a plane each point was taken, whatever its noise.

A depth sensor errs along its line of sight, which moves a point across the plane and along it at once. Who
selects points by the place where they *are* keeps too many of those that err inwards: at the edges of a face,
and at the sensor's largest depth. Selecting by the place where the line of sight *meets the plane* does not.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.model import Frame, Plane, Scan

from .motions import RigidMotions

_LEAST_DISTANCE_M = 0.05
"""A plane that is nearer to the sensor is seen along itself: no line of sight meets it at a known place."""


@dataclass(frozen=True)
class Sight:
    """The sensor's place for every point of a cloud, Manhattan frame."""

    frame: Int[np.ndarray, " points"]
    """Row of each point's frame."""
    centres_m: Float[np.ndarray, "frames 3"]
    depth_axes: Float[np.ndarray, "frames 3"] | None
    """Optical axes, where the scan tells the rotation of every frame."""
    limit_m: float
    """Depth (range, without axes) beyond which the sensor gives nothing; infinite where none shows."""

    def moved(self, motions: RigidMotions) -> "Sight":
        """The same after each frame has moved."""
        centres_m = motions.apply(self.centres_m, np.arange(len(self.centres_m)))
        axes = self.depth_axes
        if axes is not None:
            axes = np.einsum("fij,fj->fi", motions.rotations, axes)
        return Sight(self.frame, centres_m, axes, self.limit_m)

    def seen_from(self, plane: Plane) -> "Sight":
        """The same in the axes of an oblique plane."""
        axes = None if self.depth_axes is None else plane.to_own(self.depth_axes)
        return replace(self, centres_m=plane.to_own(self.centres_m), depth_axes=axes)

    def meet(
        self,
        points_m: Float[np.ndarray, "points 3"],
        chosen: Int[np.ndarray, " chosen"],
        plane: Plane,
        reach_m: float,
    ) -> "Meeting":
        """Where the lines of sight of some points meet a plane.

        Args:
            points_m: all points, same axes as the sight: the plane's own.
            chosen: which of them.
            plane: with its present offset.
            reach_m: points move along their line by at most this much: a wall that registration has put
                beside the plane is no depth error, and at a grazing angle would move by metres.
        """
        centres_m = self.centres_m[self.frame[chosen]]
        rays_m = points_m[chosen] - centres_m
        along_m = rays_m[:, plane.axis]
        before_m = plane.offset_m - centres_m[:, plane.axis]
        faces = plane.outward * before_m > _LEAST_DISTANCE_M
        usable = faces & (plane.outward * along_m > _LEAST_DISTANCE_M)
        stretch = np.where(usable, before_m / np.where(usable, along_m, 1.0), 1.0)
        length_m = np.linalg.norm(rays_m, axis=1)
        limit = reach_m / np.maximum(length_m, reach_m)
        stretch = np.clip(stretch, 1.0 - limit, 1.0 + limit)
        depth_m = length_m
        if self.depth_axes is not None:
            depth_m = np.sum(rays_m * self.depth_axes[self.frame[chosen]], axis=1)
        return Meeting(centres_m + stretch[:, None] * rays_m, usable, stretch * depth_m, depth_m)


@dataclass(frozen=True)
class Meeting:
    """Lines of sight on one plane, one per point."""

    places_m: Float[np.ndarray, "points 3"]
    """Where the line meets the plane."""
    faces: Bool[np.ndarray, " points"]
    """Whether the sensor stands on the side of the plane that can be seen."""
    depth_m: Float[np.ndarray, " points"]
    """Depth (range, without axes) at which the line meets the plane."""
    measured_m: Float[np.ndarray, " points"]
    """Measured depth."""


def sight_of(scan: Scan, frame: Frame) -> Sight | None:
    """Lines of sight in the Manhattan frame; None unless the scan tells the sensor's place of every point.

    Args:
        scan: with `frame_ids` and the poses of all those frames.
        frame: of the Manhattan axes.
    """
    told = scan.sensors()
    if told is None:
        return None
    sensors, index = told
    centres_m = np.stack([sensor.position_m for sensor in sensors])
    rotations = [sensor.rotation for sensor in sensors if sensor.rotation is not None]
    axes = np.stack([rotation[:, 2] for rotation in rotations]) if len(rotations) == len(sensors) else None
    rays_m = scan.points_m - centres_m[index]
    limit_m = _limit(np.linalg.norm(rays_m, axis=1), index)
    if axes is not None:
        depth_m = np.sum(rays_m * axes[index], axis=1)
        by_depth_m = _limit(depth_m, index)
        # A scanner's z axis is its vertical, and no depth; nor is it where conventions differ.
        if np.isfinite(by_depth_m) and depth_m.min() > 0.0:
            limit_m = by_depth_m
        else:
            axes = None
    axes = None if axes is None else axes @ frame.R_manhattan_scan.T
    return Sight(index, frame.to_manhattan(centres_m), axes, limit_m)


_SAME_LIMIT = 0.01
"""Relative. The farthest corners that two frames see do not agree to a hundredth by chance."""
_LIMIT_SHARE = 0.2
"""Share of the frames that must end at the same depth."""


def _limit(depth_m: Float[np.ndarray, " points"], index: Int[np.ndarray, " points"]) -> float:
    """The sensor's largest depth, if many frames end there; else infinity."""
    farthest_m = np.full(int(index.max()) + 1, -np.inf)
    np.maximum.at(farthest_m, index, depth_m)
    limit_m = float(farthest_m.max())
    at_limit: Bool[np.ndarray, " frames"] = farthest_m > (1.0 - _SAME_LIMIT) * limit_m
    enough = max(5.0, _LIMIT_SHARE * len(farthest_m))
    return limit_m if at_limit.sum() >= enough else np.inf
