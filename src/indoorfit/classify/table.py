"""Segments -> the six classes of the thesis (Table 3-1 and the half-height rule, 3.2.3)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.model import FaceClass, Segments


@dataclass(frozen=True)
class ClassifyConfig:
    """Bounds on the normals' components and on the height of floor and ceiling."""

    along: float = 0.8
    """Least component along the class' axis (Table 3-1)."""
    across: float = 0.2
    """Largest component along the other axes (Table 3-1)."""
    floor_below: float = 0.15
    """Floor segments lie in this lowest share of the height. The thesis keeps those at half the height
    from the centroid; a table at 0.75 m of 2.7 m is at 0.28, a platform of two steps at 0.13."""
    ceiling_above: float = 0.7
    """Ceiling segments lie above this share of the height, so that dropped ceilings stay."""


_BROAD = 0.5
"""Share of the largest level segment's area from which on another above the walls' middle is a ceiling: it is
as large as the floor, tables and cupboards cover less than half of one."""

_CLASSES: tuple[FaceClass, ...] = ("left", "right", "back", "front", "floor", "ceiling")


def classify(segments: Segments, config: ClassifyConfig) -> tuple[FaceClass | None, ...]:
    """Label every segment, or None where it fits no class.

    Args:
        segments: Manhattan axes, normals pointing away from the centroid.
        config: see `ClassifyConfig`.
    """
    axis = np.argmax(np.abs(segments.normals), axis=1)
    along = np.take_along_axis(segments.normals, axis[:, None], axis=1)[:, 0]
    others = np.abs(segments.normals).copy()
    np.put_along_axis(others, axis[:, None], 0.0, axis=1)
    fits = (np.abs(along) >= config.along) & (others.max(axis=1, initial=0.0) <= config.across)
    heights_m = segments.centres_m[:, 2]
    level = fits & (axis == 2)
    upright = fits & (axis < 2)
    low_m, high_m = _height_range(heights_m, segments.areas_m2, level, upright)
    share = (heights_m - low_m) / max(high_m - low_m, 1e-9)
    classes: list[FaceClass | None] = []
    for k in range(segments.n_segments):
        if not fits[k]:
            classes.append(None)
        elif axis[k] < 2:
            classes.append(_CLASSES[2 * axis[k] + (along[k] > 0)])
        else:
            # Height decides, not the normal's sign: away from the centroid is up only above it.
            floor, ceiling = share[k] <= config.floor_below, share[k] >= config.ceiling_above
            classes.append("floor" if floor else "ceiling" if ceiling else None)
    return tuple(classes)


def _height_range(
    heights_m: Float[np.ndarray, " n"],
    areas_m2: Float[np.ndarray, " n"],
    level: Bool[np.ndarray, " n"],
    upright: Bool[np.ndarray, " n"],
) -> tuple[float, float]:
    """Lowest and highest level of note: the outermost segments with a tenth of the largest one's area.

    Where no ceiling was seen, the walls tell the height: their middle lies half-way up. Not where one was:
    what stands before the walls hides their lower half, and lifts the middle of what is seen of them.
    """
    if not level.any():
        return 0.0, 0.0
    notable = heights_m[level & (areas_m2 >= 0.1 * areas_m2[level].max())]
    low_m, high_m = float(notable.min()), float(notable.max())
    if upright.any():
        middle_m = float(np.average(heights_m[upright], weights=areas_m2[upright]))
        broad = level & (areas_m2 >= _BROAD * areas_m2[level].max())
        if not np.any(heights_m[broad] > middle_m):
            high_m = max(high_m, 2.0 * middle_m - low_m)
    return low_m, high_m
