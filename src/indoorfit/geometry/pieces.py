"""The connected parts of a plane: each is a face of its own."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from scipy import ndimage

from .exposure import Exposure


@dataclass(frozen=True)
class SeenPiece:
    """What was seen of one connected part of a plane."""

    part: Exposure
    n_points: int
    coverage: float
    """Share of its area that points were seen on, 0 to 1."""


def pieces(exposure: Exposure) -> tuple[Exposure, ...]:
    """The visible part of a plane, taken apart where it is not connected; none where nothing is visible.

    Floors and ceilings with corners cut off count as one.
    """
    if exposure.corners:
        return (exposure,)
    labels, n = ndimage.label(exposure.mask)  # type: ignore[misc]
    return tuple(replace(exposure, mask=labels == k) for k in range(1, n + 1))


def seen_pieces(
    exposure: Exposure,
    points_m: Float[np.ndarray, "points 3"],
    coverage: Callable[[Exposure, Float[np.ndarray, "points 3"]], float],
    margin_m: float = 0.0,
) -> tuple[SeenPiece, ...]:
    """What was seen of each connected part of a plane.

    Args:
        exposure: of the plane.
        points_m: that lie on it, in its own axes.
        coverage: share of a part's area that some points, at least one, speak for.
        margin_m: points this far inside a part's edges are its own; negative: this far outside.
    """
    parts, found = pieces(exposure), []
    for part in parts:
        own_m = points_m if len(parts) == 1 else points_m[part.contains(points_m, margin_m)]
        found.append(SeenPiece(part, len(own_m), coverage(part, own_m) if len(own_m) else 0.0))
    return tuple(found)
