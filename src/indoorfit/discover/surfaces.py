"""The classified surfels as discovery looks at them: walls by axis, floor and ceiling from above."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.errors import InputError
from indoorfit.geometry import MAD_TO_STD
from indoorfit.model import FaceClass, Segments, Surfels


@dataclass(frozen=True)
class Surfaces:
    """Evidence in the Manhattan frame, with the sizes that its resolution allows."""

    walls_m: tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "m 3"]]
    """Surfels of walls perpendicular to x, and to y."""
    wall_segments: tuple[Int[np.ndarray, " n"], Int[np.ndarray, " m"]]
    """The segment of each of them."""
    stray_m: Float[np.ndarray, "s 3"]
    """Surfels of no surface: edges, and walls too narrow for a surface of their own."""
    ceiling_m: Float[np.ndarray, "c 3"]
    vault_m: Float[np.ndarray, "v 3"]
    """Surfels of large sloped surfaces overhead, vaults and roofs: they tell what is inside, no height."""
    floor_m: Float[np.ndarray, "f 3"]
    floor_height_m: float
    """The level with most floor."""
    ceiling_height_m: float
    """The level with most ceiling; the top of the walls where no ceiling was seen."""
    pixel_m: float
    """Side of a square on which a fully scanned surface shows four surfels on average."""
    noise_m: float
    """Median distance of surfels from their segments' planes."""
    scatter_m: float
    """Standard deviation of where one surface was seen: of floor or ceiling about its plane, the lesser. What
    the sensor adds is small; the rest is registration, which moves walls as well."""


_MIN_CEILING_M2 = 0.5
"""Less than this is a lamp or a shelf, and the scan is taken as one without a ceiling."""
_CEILING_GAP_M = 0.8
"""A ceiling is at most this far below the highest tenth of the walls: a lowered one by half a metre, the
tenth itself another quarter; a cupboard stands a metre below."""
_FLOOR_GAP_M = 0.3
"""A floor lies this near the lowest tenth of the walls, or it is a table: of a wall of 2.5 m the lowest
tenth ends at 0.25 m, a table stands at 0.75 m."""
_LEVEL_M = 0.15
"""Level surfels nearer than this to the main level tell how it scatters: three standard deviations of 5 cm,
the worst registration that is foreseen. A step within it is the lesser part and moves no median deviation."""
_MIN_SCATTERED = 50
"""A robust standard deviation of so many is good to 16 %."""
_BESIDE_M = 0.3
"""Walls stand at the edge of floor and ceiling, or this far beyond where it was not seen."""


def find_surfaces(surfels: Surfels, segments: Segments, classes: tuple[FaceClass | None, ...]) -> Surfaces:
    """Sort the surfels of classified segments.

    Raises:
        InputError: no walls, or no floor.
    """
    kind = np.array([_KINDS[name] for name in classes] + [-1])[segments.labels]
    walls = (surfels.positions_m[kind == 0], surfels.positions_m[kind == 1])
    floor_m, ceiling_m = surfels.positions_m[kind == 2], surfels.positions_m[kind == 3]
    heights_m = np.concatenate([wall[:, 2] for wall in walls])
    if len(heights_m) == 0:
        raise InputError(
            "discover: no upright surfaces; a room needs walls. Fix: check --up, or scan the walls as well."
        )
    floor_height_m = _main_level(floor_m[:, 2]) if len(floor_m) else np.inf
    indoors = _within(np.concatenate(walls), np.concatenate([floor_m, ceiling_m]))
    heights_m = heights_m[indoors] if np.any(indoors) else heights_m
    # Reflections reach below the floor: hence the tenth percentile.
    foot_m, top_m = np.percentile(heights_m, [10, 99])
    if floor_height_m > foot_m + _FLOOR_GAP_M:
        lowest = f" (the lowest level surface is {floor_height_m - foot_m:.2f} m above it)"
        raise InputError(
            "discover: no floor at the foot of the walls"
            + (lowest if len(floor_m) else "")
            + "; heights and volumes would be made up. Fix: scan the floor as well, or check --up."
        )
    seen = len(ceiling_m) * surfels.area_m2 >= _MIN_CEILING_M2
    ceiling_height_m = _main_level(ceiling_m[:, 2]) if seen else float(top_m)
    if ceiling_height_m < np.percentile(heights_m, 90) - _CEILING_GAP_M:
        # The walls go on above it: a bed or a table, in a scan without a ceiling.
        seen, ceiling_height_m = False, float(top_m)
    return Surfaces(
        walls_m=walls,
        wall_segments=(segments.labels[kind == 0], segments.labels[kind == 1]),
        stray_m=surfels.positions_m[segments.labels == -1],
        ceiling_m=ceiling_m if seen else ceiling_m[:0],
        vault_m=surfels.positions_m[_overhead(segments, classes, 0.5 * (foot_m + top_m))],
        floor_m=floor_m,
        floor_height_m=floor_height_m,
        ceiling_height_m=ceiling_height_m,
        pixel_m=2.0 * np.sqrt(surfels.area_m2),
        noise_m=float(np.median(segments.rms_m)),
        scatter_m=_scatter_m(
            floor_m[np.abs(floor_m[:, 2] - floor_height_m) < _LEVEL_M],
            ceiling_m[np.abs(ceiling_m[:, 2] - ceiling_height_m) < _LEVEL_M],
        ),
    )


_VAULT_M2 = 2.0
"""Least size of a sloped surface that covers a room; lampshades and lids are smaller."""
_SLOPE = (float(np.sin(np.radians(8.0))), float(np.cos(np.radians(8.0))))
"""Height components of normals between upright and level, as walls and ceilings are told from the rest."""


def _overhead(
    segments: Segments, classes: tuple[FaceClass | None, ...], least_m: float
) -> Bool[np.ndarray, " surfels"]:
    steep = np.abs(segments.normals[:, 2])
    vault = np.array([name is None for name in classes], bool) & (segments.areas_m2 >= _VAULT_M2)
    vault &= (steep > _SLOPE[0]) & (steep < _SLOPE[1]) & (segments.centres_m[:, 2] > least_m)
    return np.append(vault, False)[segments.labels]


_KINDS = {None: -1, "left": 0, "right": 0, "back": 1, "front": 1, "floor": 2, "ceiling": 3}


def _within(points_m: Float[np.ndarray, "n 3"], level_m: Float[np.ndarray, "m 3"]) -> Bool[np.ndarray, " n"]:
    """Points in the plan of level surfaces, but for their outermost hundredth: not houses over the street."""
    if len(level_m) == 0:
        return np.ones(len(points_m), bool)
    low_m, high_m = np.percentile(level_m[:, :2], [1, 99], axis=0)
    xy_m = points_m[:, :2]
    return np.all((xy_m >= low_m - _BESIDE_M) & (xy_m <= high_m + _BESIDE_M), axis=1)


def _scatter_m(*levels_m: Float[np.ndarray, "_ 3"]) -> float:
    """Robust standard deviation about the plane of the better of two surfaces; 0 where none tells."""
    scatter_m = []
    for points_m in levels_m:
        if len(points_m) >= _MIN_SCATTERED:
            plane = np.column_stack([points_m[:, :2], np.ones(len(points_m))])
            residuals_m = points_m[:, 2] - plane @ np.linalg.lstsq(plane, points_m[:, 2])[0]
            scatter_m.append(MAD_TO_STD * np.median(np.abs(residuals_m - np.median(residuals_m))))
    return float(min(scatter_m, default=0.0))


def _main_level(heights_m: Float[np.ndarray, " n"]) -> float:
    """The most frequent height, to the median within 5 cm of the histogram's peak."""
    edges = np.arange(heights_m.min() - 0.05, heights_m.max() + 0.10, 0.05)
    counts = np.histogram(heights_m, edges)[0]
    peak_m = edges[int(np.argmax(counts))] + 0.025
    return float(np.median(heights_m[np.abs(heights_m - peak_m) <= 0.05]))
