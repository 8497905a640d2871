"""Settings of the thesis' procedure."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GreedyConfig:
    """Thresholds, each where the thesis states it or as near to its intent as can be."""

    join_m: float = 0.10
    """Segments within this distance of the farthest one join it (3.2.4: "almost no two planes" of a
    building are closer than 10 cm)."""
    inlier_m: float = 0.05
    """RANSAC inliers lie this close to the plane. The thesis gives no number for its MATLAB code; its
    residuals after the selection of inliers end at 5 cm (6.1, figure 6-1)."""
    confidence: float = 0.999
    """Stop rule of RANSAC: the chance that one triple of inliers was drawn."""
    max_draws: int = 1000
    """Upper limit of that rule; at half inliers 52 triples suffice."""
    along: float = 0.8
    """Least component of a wall's normal along its axis (table 3-1)."""
    across: float = 0.2
    """Largest component along the other axes (table 3-1)."""
    min_area_m2: float = 0.20
    """Smaller segments are left out. Surface growing has a smallest segment; ours keeps slivers of up to
    0.1 m² along edges, whose tilted planes would win every search for the farthest. The narrowest wall
    of the thesis, 17.6 cm by 2.68 m, has 0.47 m²."""
    link_m: float = 0.20
    """Distance of the connected components (3.2.5, figure 3-6, whose number is not legible). Segments
    stop some 5 cm short of a corner on either side, more where the cloud is thin."""
    link_spacings: float = 4.0
    """The same distance in surfel spacings, for thin clouds; the larger one counts."""
    reach_share: float = 0.9
    """A plane is wall if its points and one link (half of it at either end, where segments stop short of
    floor and ceiling) span this share of the room's height. A cupboard of 2.1 m under a ceiling of 2.7 m
    spans 0.85, a free wall 1."""
