"""What the procedure did, step by step, and what came of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float

from indoorfit.model import FaceClass, Frame, Note, Shape

Action = Literal["planes", "first cube", "components", "set aside", "cube", "no cube"]
"""`planes`: RANSAC per segment (3.2.2); `first cube`: the largest cube (3.2.4); `components`: the remaining
segments in connected pieces; `set aside`: segments taken for furniture; `cube`: a cube to be subtracted;
`no cube`: planes that make none (all 3.2.5)."""


@dataclass(frozen=True)
class FittedPlane:
    """A plane with a normal of its own; Manhattan frame of the finished fit."""

    name: str
    """Face class, or the segment's number."""
    normal: Float[np.ndarray, " 3"]
    """Unit length, away from the origin that was in use (4.2.2; for a component its centroid)."""
    centre_m: Float[np.ndarray, " 3"]
    """Centroid of the inliers."""
    n_points: int
    n_inliers: int
    rms_m: float
    """Root mean square distance of the inliers."""

    def distance_m(self, origin_m: Float[np.ndarray, " 3"]) -> float:
        """Perpendicular distance of an origin from the plane, positive along the normal (3.2.2)."""
        return float(self.normal @ (self.centre_m - origin_m))

    @property
    def tilt_rad(self) -> float:
        """Angle between the normal and the nearest axis of the Manhattan frame."""
        return float(np.arccos(min(1.0, float(np.max(np.abs(self.normal))))))


@dataclass(frozen=True)
class GreedyStep:
    """One step, for the figures of the thesis (5-1 to 5-7)."""

    section: str
    """Section of the thesis, e.g. ``3.2.4``."""
    action: Action
    segments: Mapping[FaceClass, tuple[int, ...]] | Mapping[str, tuple[int, ...]]
    """Selected segments by face class, or by component."""
    cube: str | None = None
    """The cube that this step made."""
    parent: str | None = None
    """The cube from which it is subtracted."""
    bounds_m: Float[np.ndarray, "2 3"] | None = None
    """Low and high corner of that cube, Manhattan frame; infinite where it is open (3.2.5)."""
    planes: tuple[FittedPlane, ...] = ()
    corners_m: Float[np.ndarray, "corners 2 3"] = field(default_factory=lambda: np.zeros((0, 2, 3)))
    """Intersection points of two walls with the floor and with the ceiling (3.2.5, 5.1.2)."""


@dataclass(frozen=True)
class GreedyFit:
    """The model of the thesis' procedure."""

    shape: Shape
    frame: Frame
    """The start frame turned by the rotation of the first cube; same origin."""
    steps: tuple[GreedyStep, ...]
    notes: tuple[Note, ...]
    converged: bool
    """False where the least squares of the first cube did not settle."""
