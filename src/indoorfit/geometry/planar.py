"""Polygons in a plane, joined and overlaid; exact but for rounding by a hundred-millionth of their extent."""

from collections.abc import Sequence

import manifold3d as m3
import numpy as np
from jaxtyping import Float

Rings = Sequence[Float[np.ndarray, "_ 2"]]
"""A polygon: what an odd number of the rings goes around."""


def union(polygons: Sequence[Rings]) -> list[Float[np.ndarray, "_ 2"]]:
    """The outline of all polygons together: outer rings counter-clockwise, holes clockwise."""
    parts = [_section(rings) for rings in polygons]
    whole = parts[0] if len(parts) == 1 else m3.CrossSection.batch_boolean(parts, m3.OpType.Add)
    return [np.asarray(ring) for ring in whole.to_polygons()]


def shared_area(first: Rings, second: Rings) -> float:
    """Area that lies in both polygons, in the square of their unit."""
    return float((_section(first) ^ _section(second)).area())


def _section(rings: Rings) -> m3.CrossSection:
    return m3.CrossSection([np.ascontiguousarray(ring) for ring in rings], m3.FillRule.EvenOdd)
