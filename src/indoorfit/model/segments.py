"""Planar pieces of a cloud: what segmentation hands on, and what classification makes of them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True)
class Surfels:
    """Voxels with a local plane each: the front end's working set."""

    positions_m: Float[np.ndarray, "surfels 3"]
    """Centre of each surfel, relative to the cloud's origin."""
    normals: Float[np.ndarray, "surfels 3"]
    """Unit normal, sign arbitrary."""
    roughness_m: Float[np.ndarray, " surfels"]
    """Root mean square distance of the neighbourhood's points from its plane."""
    planarity: Float[np.ndarray, " surfels"]
    """1 for a perfect plane, 0 where two directions have no spread apart (lines, edges, blobs)."""
    neighbours: Int[np.ndarray, "surfels k"]
    """Indices of the nearest surfels, nearest first, itself included."""
    spacing_m: float
    """Median distance of neighbouring surfels."""
    area_m2: float
    """Mean surface area that one surfel stands for."""


@dataclass(frozen=True)
class Segments:
    """Connected flat pieces of the cloud (surface growing, thesis 3.2.1)."""

    labels: Int[np.ndarray, " surfels"]
    """Segment of each surfel, -1 for none."""
    normals: Float[np.ndarray, "segments 3"]
    """Unit normal, pointing away from the cloud's centroid (thesis 4.2.2)."""
    distances_m: Float[np.ndarray, " segments"]
    """Perpendicular distance of the plane from the centroid, >= 0 (thesis 3.2.2)."""
    centres_m: Float[np.ndarray, "segments 3"]
    """Centroid of each segment."""
    areas_m2: Float[np.ndarray, " segments"]
    rms_m: Float[np.ndarray, " segments"]
    """Root mean square distance of the segment's surfels from its plane."""

    @property
    def n_segments(self) -> int:
        """Number of segments."""
        return len(self.normals)
