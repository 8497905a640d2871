"""Candidate wall lines: where walls were seen, and where floor and ceiling end without one."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from .surfaces import Surfaces


@dataclass(frozen=True)
class CandidateConfig:
    """What counts as a candidate."""

    merge_m: float = 0.06
    """Wall pieces whose positions differ by less are one candidate. Steps of 10 cm are built (a duct, a
    chimney breast), steps of 5 cm hardly; the thesis joins up to 10 cm."""
    min_area_m2: float = 0.10
    """Least area of wall on a candidate: half the side of a 10 cm pilaster 2 m high."""
    min_end_m: float = 0.5
    """Least length over which floor or ceiling must end together to suggest an unseen wall there."""


@dataclass(frozen=True)
class Lines:
    """The candidates of one axis, in increasing order."""

    offsets_m: Float[np.ndarray, " lines"]
    seen: np.ndarray
    """(lines,) bool: whether wall was seen there, or only the end of floor or ceiling."""
    segment_line: dict[int, int]
    """The line of every wall segment that lies on one."""


def candidate_lines(surfaces: Surfaces, axis: int, config: CandidateConfig) -> Lines:
    """Candidates perpendicular to one plan axis.

    Args:
        surfaces: sorted evidence, Manhattan frame.
        axis: 0 for lines of constant x, 1 for constant y.
        config: see `CandidateConfig`.
    """
    labels = surfaces.wall_segments[axis]
    across_m = surfaces.walls_m[axis][:, axis]
    area_m2 = (surfaces.pixel_m / 2.0) ** 2
    offsets_m, members = _cluster(labels, across_m, area_m2, config)
    ends_m = _coverage_ends(surfaces, axis, config)
    fresh_m = [end for end in ends_m if all(abs(end - offset) > _end_reach(surfaces) for offset in offsets_m)]
    everything = np.concatenate([offsets_m, fresh_m])
    order = np.argsort(everything, kind="stable")
    rank = np.argsort(order, kind="stable")
    segment_line = {segment: int(rank[k]) for k, group in enumerate(members) for segment in group}
    return Lines(everything[order], (np.arange(len(everything)) < len(offsets_m))[order], segment_line)


def _cluster(
    labels: Int[np.ndarray, " n"], across_m: Float[np.ndarray, " n"], area_m2: float, config: CandidateConfig
) -> tuple[Float[np.ndarray, " lines"], list[list[int]]]:
    """Join wall segments of nearly the same position, largest first, so that slivers never bridge walls."""
    segments, counts = np.unique(labels, return_counts=True)
    position_m = {int(s): float(np.median(across_m[labels == s])) for s in segments}
    groups: list[list[int]] = []
    centres: list[float] = []
    sizes: list[int] = []
    for k in np.argsort(-counts, kind="stable"):
        segment = int(segments[k])
        near = [g for g, c in enumerate(centres) if abs(c - position_m[segment]) < config.merge_m]
        if not near:
            groups.append([segment])
            centres.append(position_m[segment])
            sizes.append(int(counts[k]))
            continue
        g = min(near, key=lambda g: abs(centres[g] - position_m[segment]))
        groups[g].append(segment)
        sizes[g] += int(counts[k])
    large = [g for g, size in enumerate(sizes) if size * area_m2 >= config.min_area_m2]
    return np.array([centres[g] for g in large]), [groups[g] for g in large]


def _end_reach(surfaces: Surfaces) -> float:
    """How far the end of floor or ceiling may lie from the wall that ends it."""
    return 1.5 * surfaces.pixel_m + 3.0 * surfaces.noise_m


def _coverage_ends(surfaces: Surfaces, axis: int, config: CandidateConfig) -> list[float]:
    """Positions at which floor or ceiling stops along at least `min_end_m`."""
    ends: list[float] = []
    for points_m in (surfaces.ceiling_m, surfaces.floor_m):
        if len(points_m) == 0:
            continue
        along, across = points_m[:, 1 - axis], points_m[:, axis]
        row = np.floor(along / surfaces.pixel_m).astype(int)
        for sign in (-1.0, 1.0):
            ends += _row_ends(row, sign * across, sign, surfaces.pixel_m, config)
    return _distinct(ends, _end_reach(surfaces))


def _row_ends(
    row: Int[np.ndarray, " n"],
    across_m: Float[np.ndarray, " n"],
    sign: float,
    pixel_m: float,
    config: CandidateConfig,
) -> list[float]:
    """Where, going up `across_m`, rows of surfels stop; only stops that many rows share."""
    order = np.lexsort((across_m, row))
    row, across_m = row[order], across_m[order]
    gap_m = 3.0 * pixel_m
    last = np.append((row[1:] != row[:-1]) | (across_m[1:] - across_m[:-1] > gap_m), True)
    stops_m = np.sort(across_m[last])
    needed = max(2, int(np.ceil(config.min_end_m / pixel_m)))
    found: list[float] = []
    k = 0
    while k < len(stops_m):
        inside = np.searchsorted(stops_m, stops_m[k] + 1.5 * pixel_m, side="right")
        if inside - k >= needed:
            # The surface goes on beyond its last surfel by half their spacing.
            found.append(sign * (float(stops_m[inside - 1]) + 0.25 * pixel_m))
            k = inside
        else:
            k += 1
    return found


def _distinct(values: list[float], reach: float) -> list[float]:
    kept: list[float] = []
    for value in values:
        if all(abs(value - other) > reach for other in kept):
            kept.append(value)
    return kept
