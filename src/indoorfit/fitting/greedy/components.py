"""Connected components of the remaining segments (thesis 3.2.5)."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from .segment_points import SegmentPoints


def connected_segments(cloud: SegmentPoints, segments: Sequence[int], link_m: float) -> list[tuple[int, ...]]:
    """Group segments whose surfels are linked by steps of at most `link_m`.

    Surfels stand for the points, each of which lies within a voxel of one; the link is as exact as that.

    Returns:
        segments of each component, the component with the most surfels first.
    """
    if not segments:
        return []
    sizes = [len(cloud.surfels([segment])) for segment in segments]
    owner = np.repeat(np.arange(len(segments)), sizes)
    pairs = KDTree(cloud.surfels(segments)).query_pairs(link_m, output_type="ndarray")
    # A segment is connected by construction, so segments can be the nodes.
    links = owner[pairs]
    n = len(segments)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(n, n))
    count, labels = connected_components(graph, directed=False)
    groups = [
        tuple(segment for segment, label in zip(segments, labels, strict=True) if label == c)
        for c in range(count)
    ]
    weight = dict(zip(segments, sizes, strict=True))
    return sorted(groups, key=lambda group: (-sum(weight[k] for k in group), group))
