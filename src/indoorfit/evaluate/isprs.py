"""The measures of the ISPRS benchmark on indoor modelling, over the faces of two models.

Completeness is the share of the reference's area that lies within a buffer b of the source's surfaces,
correctness the share of the source's area within b of the reference's, and accuracy the median distance of
sample points on the reference to the nearest surface of the source, of those nearer than a cut-off r. The
benchmark's tables have b = r = 10 cm, its figures 0 to 15 cm.

Areas are summed over the cells of a fine regular grid on every face, each judged by its middle, whose
distance to the other surface is exact: a share is off by at most one row of cells around what is wrong. As
in the benchmark, surfaces count whatever they face.

Source: K. Khoshelham et al., An evaluation framework for benchmarking indoor modelling methods, ISPRS
Archives XLII-4 (2018); Results of the ISPRS benchmark on indoor modelling, ISPRS Open J. 2 (2021);
https://www.isprs.org/resources/datasets/benchmarks/IndoorModeling/results.aspx for the definitions.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.errors import ConfigError
from indoorfit.model import FaceKind, FitResult

from .alignment import flat_faces

SPACING_M = 0.05
"""Edge of a cell: a third of the largest buffer, and some ten thousand cells in a room."""
BUFFERS_M = tuple(np.round(np.arange(0.0, 0.1501, 0.01), 2).tolist())
_ALL: tuple[FaceKind, ...] = ("wall", "floor", "ceiling", "step")
_CHUNK = 4096


@dataclass(frozen=True)
class IsprsCurves:
    """The three measures for each buffer; metres and shares of 1."""

    buffers_m: tuple[float, ...]
    completeness: tuple[float, ...]
    correctness: tuple[float, ...]
    accuracy_m: tuple[float, ...]
    """With the buffer as cut-off r; NaN where no sample is that near."""


@dataclass(frozen=True)
class _Samples:
    """Middles of cells on faces, scan frame, with the cells' areas and the distance to the other model."""

    areas_m2: Float[np.ndarray, " cells"]
    distances_m: Float[np.ndarray, " cells"]


def isprs_curves(
    source: FitResult,
    reference: FitResult,
    buffers_m: Sequence[float] = BUFFERS_M,
    kinds: Collection[FaceKind] = _ALL,
    spacing_m: float = SPACING_M,
) -> IsprsCurves:
    """All three measures over a range of buffers.

    Args:
        source: the model to be judged, scan frame.
        reference: what it is judged by, same scan frame.
        buffers_m: values of b, which also serve as r.
        kinds: faces that count; the benchmark's published tables take walls only.
        spacing_m: edge of the cells.

    Raises:
        ConfigError: the spacing is not positive.
    """
    on_reference = _sample(reference, source, kinds, spacing_m)
    on_source = _sample(source, reference, kinds, spacing_m)
    return IsprsCurves(
        tuple(buffers_m),
        tuple(_share(on_reference, b) for b in buffers_m),
        tuple(_share(on_source, b) for b in buffers_m),
        tuple(_median(on_reference, r) for r in buffers_m),
    )


def completeness(
    source: FitResult, reference: FitResult, buffer_m: float = 0.10, kinds: Collection[FaceKind] = _ALL
) -> float:
    """Share of the reference's area within `buffer_m` of the source."""
    return _share(_sample(reference, source, kinds, SPACING_M), buffer_m)


def correctness(
    source: FitResult, reference: FitResult, buffer_m: float = 0.10, kinds: Collection[FaceKind] = _ALL
) -> float:
    """Share of the source's area within `buffer_m` of the reference."""
    return _share(_sample(source, reference, kinds, SPACING_M), buffer_m)


def accuracy_m(
    source: FitResult, reference: FitResult, cutoff_m: float = 0.10, kinds: Collection[FaceKind] = _ALL
) -> float:
    """Median distance from the reference to the source over what is nearer than `cutoff_m`; else NaN."""
    return _median(_sample(reference, source, kinds, SPACING_M), cutoff_m)


_ROUNDING_M = 1e-9
"""Surfaces that coincide are some 1e-15 m apart; at b = 0 they must still count as equal."""


def _share(samples: _Samples, buffer_m: float) -> float:
    total = samples.areas_m2.sum()
    near = samples.distances_m <= buffer_m + _ROUNDING_M
    return float(samples.areas_m2[near].sum() / total) if total > 0.0 else float("nan")


def _median(samples: _Samples, cutoff_m: float) -> float:
    """Median by area: the samples of a face stand for cells of one size, those of two faces may not."""
    near = samples.distances_m <= cutoff_m + _ROUNDING_M
    if not near.any():
        return float("nan")
    order = np.argsort(samples.distances_m[near])
    areas = np.cumsum(samples.areas_m2[near][order])
    return float(samples.distances_m[near][order][np.searchsorted(areas, 0.5 * areas[-1])])


def _sample(on: FitResult, to: FitResult, kinds: Collection[FaceKind], spacing_m: float) -> _Samples:
    """Cells on one model with their distances to the other."""
    if not spacing_m > 0.0:
        raise ConfigError(f"evaluate: spacing_m is {spacing_m:g}; it must be positive. Fix: 0.05 or so.")
    points, areas = [np.empty((0, 3))], [np.empty(0)]
    for face in flat_faces(on):
        if face.face.kind in kinds:
            for low, high in face.cells_m:
                middles, area = _grid(low, high, int(np.argmax(np.abs(face.inward))), spacing_m)
                points.append(middles)
                # An oblique wall is longer than what its strips show along one axis.
                areas.append(np.full(len(middles), area / np.max(np.abs(face.inward))))
    boxes = [face.cells_m for face in flat_faces(to) if face.face.kind in kinds]
    in_scan_m = on.frame.to_scan(np.concatenate(points))
    distances_m = _distances_m(to.frame.to_manhattan(in_scan_m), boxes)
    return _Samples(np.concatenate(areas), distances_m)


def _grid(
    low: Float[np.ndarray, " 3"], high: Float[np.ndarray, " 3"], axis: int, spacing_m: float
) -> tuple[Float[np.ndarray, "cells 3"], float]:
    """Middles of equal cells of about the spacing that fill a rectangle, and the area of one."""
    lines = [np.array([0.5 * (low[axis] + high[axis])])] * 3
    area = 1.0
    for k in range(3):
        if k != axis:
            n = max(1, int(np.ceil((high[k] - low[k]) / spacing_m - 1e-9)))
            lines[k] = low[k] + (np.arange(n) + 0.5) * (high[k] - low[k]) / n
            area *= (high[k] - low[k]) / n
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3), float(area)


def _distances_m(
    points_m: Float[np.ndarray, "points 3"], boxes: list[Float[np.ndarray, "cells 2 3"]]
) -> Float[np.ndarray, " points"]:
    """Distance of each point to the nearest of some (flat) boxes; infinite without any."""
    nearest = np.full(len(points_m), np.inf)
    if not boxes:
        return nearest
    low, high = np.concatenate(boxes).transpose(1, 0, 2)
    for start in range(0, len(points_m), _CHUNK):
        part = points_m[start : start + _CHUNK, None]
        outside = np.maximum(np.maximum(low - part, part - high), 0.0)
        nearest[start : start + _CHUNK] = np.sqrt((outside**2).sum(axis=-1)).min(axis=1)
    return nearest
