"""Candidate wall lines: where walls were seen, and where floor and ceiling end without one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from .oblique import ObliqueLine
from .surfaces import Surfaces


@dataclass(frozen=True)
class CandidateConfig:
    """What counts as a candidate."""

    merge_m: float = 0.06
    """Wall pieces whose positions differ by less are one candidate, however good the scan. Steps of 10 cm are
    built (a duct, a chimney breast), steps of 5 cm hardly; the thesis joins up to 10 cm."""
    min_area_m2: float = 0.10
    """Least area of wall on a candidate: half the side of a 10 cm pilaster 2 m high."""
    min_end_m: float = 0.5
    """Least length over which floor, ceiling or a wall must end together to suggest an unseen wall there."""


@dataclass(frozen=True)
class Lines:
    """The candidates of one axis, in increasing order."""

    offsets_m: Float[np.ndarray, " lines"]
    seen: np.ndarray
    """(lines,) bool: whether wall was seen there, or only the end of floor or ceiling."""
    surfel_line: Int[np.ndarray, " n"]
    """The line of every wall surfel of this axis, -1 for none."""

    def with_unseen(self, offsets_m: Float[np.ndarray, " more"]) -> "Lines":
        """These lines and others at which no wall was seen."""
        everything = np.concatenate([self.offsets_m, offsets_m])
        order = np.argsort(everything, kind="stable")
        # The last rank serves surfels without a line.
        rank = np.append(np.argsort(order, kind="stable"), -1)
        seen = np.concatenate([self.seen, np.zeros(len(offsets_m), bool)])
        return Lines(everything[order], seen[order], rank[self.surfel_line])

    def joined(self, pairs: Sequence[tuple[int, int]]) -> "Lines":
        """These lines with disjoint pairs of neighbours as one, in the place where more was seen."""
        keep, home = np.ones(len(self.offsets_m), bool), np.arange(len(self.offsets_m))
        counts = np.bincount(self.surfel_line[self.surfel_line >= 0], minlength=len(keep))
        for pair in pairs:
            weak, strong = sorted(pair, key=lambda k: int(counts[k]))
            keep[weak], home[weak] = False, strong
        # The last rank serves surfels without a line.
        rank = np.append((np.cumsum(keep) - 1)[home], -1)
        return Lines(self.offsets_m[keep], self.seen[keep], rank[self.surfel_line])


def widened(config: CandidateConfig, surfaces: Surfaces, price: float) -> CandidateConfig:
    """The settings for a scan in which one surface is seen in several places.

    Args:
        config: as set; `merge_m` grows where two positions must be farther apart to be worth two walls.
        surfaces: sorted evidence, for how much it scatters.
        price: of one parameter, nats.
    """
    return replace(config, merge_m=max(config.merge_m, worth_two_m(surfaces.scatter_m, price)))


def told_apart(config: CandidateConfig, surfaces: Surfaces) -> CandidateConfig:
    """The settings for candidates that may yet turn out to be one wall (`doubles`).

    Args:
        config: as set; `merge_m` grows to where two crowds of points can be told at all: the sum of two alike
            normal densities has two peaks if they are more than two standard deviations apart.
        surfaces: sorted evidence, for how much it scatters.
    """
    return replace(config, merge_m=max(config.merge_m, 2.0 * surfaces.scatter_m))


def candidate_lines(
    surfaces: Surfaces, config: CandidateConfig, oblique: Sequence[ObliqueLine] = ()
) -> tuple[Lines, Lines]:
    """Candidates perpendicular to x, and to y.

    Args:
        surfaces: sorted evidence, Manhattan frame.
        config: see `CandidateConfig`, and `widened`.
        oblique: walls of other directions: where one of them stands in the place of a wall of these, the
            room's box ends where that one ends.
    """
    reach_m = end_reach(surfaces)
    area_m2 = (surfaces.pixel_m / 2.0) ** 2
    seen = [
        _cluster(surfaces.wall_segments[axis], surfaces.walls_m[axis][:, axis], area_m2, config)
        for axis in (0, 1)
    ]
    across_x, across_y = (
        _with_ends(
            seen[axis],
            [
                *(end_m for line in oblique for end_m in line.closing_m(axis, seen[1 - axis][0], reach_m)),
                *coverage_ends(surfaces, axis, config),
                *_wall_ends(surfaces, axis, seen[1 - axis][1], config),
            ],
            reach_m,
        )
        for axis in (0, 1)
    )
    return across_x, across_y


def worth_two_m(scatter_m: float, price: float) -> float:
    """How far apart two positions must be for two walls to be likelier than one that was seen twice.

    The difference of two positions that scatter by s has variance 2 s². One wall for both costs d² / 4 s²
    nats, a second wall the price of its position (Schwarz 1978).
    """
    return 2.0 * scatter_m * float(np.sqrt(price))


def _with_ends(
    seen: tuple[Float[np.ndarray, " lines"], Int[np.ndarray, " n"]], ends_m: list[float], reach_m: float
) -> Lines:
    """Seen walls, and ends that no seen wall explains."""
    offsets_m, surfel_line = seen
    fresh_m = [end for end in ends_m if all(abs(end - offset) > reach_m for offset in offsets_m)]
    walls = Lines(offsets_m, np.ones(len(offsets_m), bool), surfel_line)
    return walls.with_unseen(np.array(distinct(fresh_m, reach_m)))


def closed_where_seen_ends(lines: Lines, surfaces: Surfaces, axis: int) -> Lines:
    """A second line for an axis with one: on its other side, where all that was seen ends.

    A picture of a corner shows no more of the room than that.

    Args:
        lines: the only candidate.
        surfaces: sorted evidence, Manhattan frame.
        axis: 0 or 1.
    """
    level_m = np.concatenate([surfaces.floor_m, surfaces.ceiling_m, *surfaces.walls_m])[:, axis]
    # The outermost hundredth may be noise, or what is seen through an opening.
    low_m, high_m = np.percentile(level_m, [1, 99])
    (only_m,) = lines.offsets_m
    before = only_m - low_m > high_m - only_m
    end_m = min(low_m, only_m - surfaces.pixel_m) if before else max(high_m, only_m + surfaces.pixel_m)
    return lines.with_unseen(np.array([end_m]))


def _cluster(
    labels: Int[np.ndarray, " n"], across_m: Float[np.ndarray, " n"], area_m2: float, config: CandidateConfig
) -> tuple[Float[np.ndarray, " lines"], Int[np.ndarray, " n"]]:
    """Join wall pieces of nearly the same position, largest first, so that slivers never bridge walls."""
    pieces = _pieces(labels, across_m, config.merge_m)
    pieces.sort(key=lambda members: -len(members))
    groups: list[list[Int[np.ndarray, " _"]]] = []
    centres: list[float] = []
    for members in pieces:
        position_m = float(np.median(across_m[members]))
        near = [g for g, c in enumerate(centres) if abs(c - position_m) < config.merge_m]
        if near:
            groups[min(near, key=lambda g: abs(centres[g] - position_m))].append(members)
        else:
            groups.append([members])
            centres.append(position_m)
    surfel_line = np.full(len(labels), -1)
    offsets_m: list[float] = []
    for group, centre in zip(groups, centres, strict=True):
        if sum(len(members) for members in group) * area_m2 >= config.min_area_m2:
            surfel_line[np.concatenate(group)] = len(offsets_m)
            offsets_m.append(centre)
    return np.array(offsets_m), surfel_line


def _pieces(
    labels: Int[np.ndarray, " n"], across_m: Float[np.ndarray, " n"], merge_m: float
) -> list[Int[np.ndarray, " _"]]:
    """The members of each segment; the two sides of a thin wall, grown together, as two pieces."""
    pieces: list[Int[np.ndarray, " _"]] = []
    for segment in np.unique(labels):
        members = np.flatnonzero(labels == segment)
        modes_m = _modes(across_m[members], merge_m)
        nearest = np.argmin(np.abs(across_m[members][:, None] - modes_m), axis=1)
        pieces += [members[nearest == k] for k in range(len(modes_m))]
    return pieces


def _modes(across_m: Float[np.ndarray, " n"], merge_m: float) -> Float[np.ndarray, " modes"]:
    """Positions where the surfels crowd: one, unless a deep valley parts two crowds.

    A second mode needs a valley of less than half its own height, and to stand out of it by more than chance
    (three standard deviations of a count); the flank of a noisy wall has neither. How high the first one is
    says nothing: of the two sides of a partition one may have been seen much more.
    """
    bin_m = merge_m / 3.0
    edges = np.arange(across_m.min() - 1.5 * bin_m, across_m.max() + 2.5 * bin_m, bin_m)
    counts = np.convolve(np.histogram(across_m, edges)[0], [0.25, 0.5, 0.25], mode="same")
    found = [int(np.argmax(counts))]
    for k in np.argsort(-counts, kind="stable"):
        valley = max(counts[min(k, f) : max(k, f) + 1].min() for f in found)
        far = all(abs(k - f) * bin_m >= merge_m for f in found)
        if far and valley < 0.5 * counts[k] and counts[k] - valley > 3.0 * np.sqrt(counts[k]):
            found.append(int(k))
    return edges[found] + 0.5 * bin_m


def end_reach(surfaces: Surfaces) -> float:
    """How far the end of floor or ceiling may lie from the wall that ends it."""
    return 1.5 * surfaces.pixel_m + 3.0 * surfaces.noise_m


def coverage_ends(surfaces: Surfaces, axis: int, config: CandidateConfig) -> list[float]:
    """Positions at which floor or ceiling stops along at least `min_end_m`."""
    ends: list[float] = []
    for points_m in (surfaces.ceiling_m, surfaces.floor_m):
        if len(points_m) == 0:
            continue
        along, across = points_m[:, 1 - axis], points_m[:, axis]
        row = np.floor(along / surfaces.pixel_m).astype(int)
        for sign in (-1.0, 1.0):
            ends += _row_ends(row, sign * across, sign, surfaces.pixel_m, config)
    return ends


def _wall_ends(
    surfaces: Surfaces, axis: int, line: Int[np.ndarray, " n"], config: CandidateConfig
) -> list[float]:
    """Positions at which walls along `axis` stop: at a salient corner the wall round it may be unseen.

    Only the upper half of the walls counts: below, furniture ends them anywhere.
    """
    wall_m = surfaces.walls_m[1 - axis]
    upper = wall_m[:, 2] > 0.5 * (surfaces.floor_height_m + surfaces.ceiling_height_m)
    ends: list[float] = []
    for one in np.unique(line[upper & (line >= 0)]):
        points_m = wall_m[upper & (line == one)]
        row = np.floor(points_m[:, 2] / surfaces.pixel_m).astype(int)
        for sign in (-1.0, 1.0):
            ends += _row_ends(row, sign * points_m[:, axis], sign, surfaces.pixel_m, config)
    return ends


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


def distinct(values: list[float], reach: float) -> list[float]:
    kept: list[float] = []
    for value in values:
        if all(abs(value - other) > reach for other in kept):
            kept.append(value)
    return kept
