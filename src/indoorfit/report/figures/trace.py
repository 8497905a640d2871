"""What the step-by-step figures are drawn from."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.fitting import GreedyStep
from indoorfit.model import FaceClass, Polygon, Shape


@dataclass(frozen=True)
class GreedyTrace:
    """The thesis' procedure on one scan, in the Manhattan frame of its first cube, metres."""

    points_m: Float[np.ndarray, "points 3"]
    surfels_m: Float[np.ndarray, "surfels 3"]
    labels: Int[np.ndarray, " surfels"]
    """Segment of each surfel, -1 for none."""
    normals: Float[np.ndarray, "segments 3"]
    """Unit normal of each segment, away from the centroid."""
    areas_m2: Float[np.ndarray, " segments"]
    classes: tuple[FaceClass | None, ...]
    """Of the segments (table 3-1)."""
    steps: tuple[GreedyStep, ...]
    shape: Shape
    polygons: tuple[Polygon, ...]
    """The flat faces of the solid that comes of it."""

    def selected(self) -> dict[FaceClass, tuple[int, ...]]:
        """The segments that the largest cube was fitted to, by class."""
        first = next(step for step in self.steps if step.action == "first cube")
        return {name: first.segments[name] for name in _CLASSES if name in first.segments}

    def components(self) -> tuple[tuple[int, ...], ...]:
        """The remaining wall segments in connected pieces, as they were before the first notch."""
        found = next((step for step in self.steps if step.action == "components"), None)
        return () if found is None else tuple(found.segments.values())


_CLASSES: tuple[FaceClass, ...] = ("front", "back", "left", "right", "floor", "ceiling")
