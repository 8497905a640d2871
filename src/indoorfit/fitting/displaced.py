"""Frames that were registered somewhere else: how far, before any plan is looked for.

A frame that is off by more than what tells walls apart builds walls of its own, and no fit of the right ones
sees its points. But other frames have seen some of the same places. What they disagree by is the shift.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import optimize, sparse
from scipy.sparse import csgraph

from indoorfit.geometry import MAD_TO_STD

from .uncertainty import Cells


@dataclass(frozen=True)
class DisplacedConfig:
    """When a frame counts as registered somewhere else."""

    min_shift_m: float = 0.10
    """Shift along one axis from which on a frame is put back before the plan is looked for: its points are
    then beyond the reach of their walls (`joint.association.reach_m`). The fit finds smaller slips."""
    min_sigmas: float = 5.0
    """And in robust standard deviations of what frames scatter about the places: where all of them drift,
    none is displaced against the others, and the fit takes slips out better, turns and all."""
    max_shift_m: float = 0.25
    """Surfaces that lie farther apart are two surfaces, however many frames disagree on them."""
    patch_m: float = 0.5
    """Side of the places at which frames are compared: several of them in one frame's view."""
    min_points: int = 10
    """Fewer points of a frame at a place have no location."""
    hold: float = 1.0
    """What keeps a frame where it is, in places: only two or more that agree can move it."""
    min_block: int = 2
    """Frames that must be off the same way: what one frame alone sees of a thing before a wall looks like a
    shift, and one frame more or less changes no plan."""
    doubt: float = 3.0
    """Where the places are seen as they are by moving other frames instead, but for this many of them, it is
    open which of the frames were displaced: fewer than may lie on one thing that stands before a wall."""


@dataclass(frozen=True)
class Displacements:
    """How far frames lie from where the others saw the same places."""

    shifts_m: Float[np.ndarray, "frames 3"]
    """Along the Manhattan axes; 0 within the limit."""
    others_m: Float[np.ndarray, "doubts frames 3"]
    """For each axis along which it may as well be other frames: what would have to be added to the shifts."""


@dataclass(frozen=True)
class _Seen:
    """What frames saw of places along one axis."""

    place: Int[np.ndarray, " seen"]
    frame: Int[np.ndarray, " seen"]
    across_m: Float[np.ndarray, " seen"]

    @property
    def n_places(self) -> int:
        """Places that two or more frames saw."""
        return int(self.place.max(initial=-1)) + 1

    @property
    def scatter_m(self) -> float:
        """Robust standard deviation of what is seen about the median of its place."""
        order = np.lexsort((self.across_m, self.place))
        counts = np.bincount(self.place)
        middle = np.cumsum(counts) - counts + counts // 2
        away_m = self.across_m - self.across_m[order][middle][self.place]
        return MAD_TO_STD * float(np.median(np.abs(away_m)))


def displaced_shifts(
    points_m: Float[np.ndarray, "points 3"],
    axis_of: Int[np.ndarray, " points"],
    frame_index: Int[np.ndarray, " points"],
    centres_m: Float[np.ndarray, "frames 3"],
    config: DisplacedConfig,
) -> Displacements:
    """Find frames that were registered somewhere else.

    Every axis on its own: the location of a surface at a place, seen by frame i, is that of the place plus
    the shift of the frame. Both are fitted with absolute errors, which neither furniture nor a minority of
    frames can pull, and a frame is held by nothing but its own inertia. The program is convex: a
    block of frames moves as one where that is better, which no frame could begin alone.

    Two groups of frames that disagree may both be right; the smaller one is moved. Where moving the other one
    explains the places nearly as well, `others_m` says so.

    Args:
        points_m: Manhattan frame, about.
        axis_of: that the surface that each point lies on is perpendicular to, -1 for none.
        frame_index: 0, 1, ... in the order in which the frames were taken.
        centres_m: of each frame the sensor's place, or the middle of what it saw; Manhattan frame.
        config: see `DisplacedConfig`.
    """
    n_frames = len(centres_m)
    shifts_m, others = np.zeros((n_frames, 3)), []
    for axis in range(3):
        # The two sides of a partition are two surfaces: each is seen from its own side.
        depth_m = points_m[:, axis] - centres_m[frame_index, axis]
        sides = ((axis_of == axis) & (sign * depth_m > _IN_FRONT_M) for sign in (-1.0, 1.0))
        seen = _joined([_places(points_m, side, axis, frame_index, config) for side in sides])
        if len(seen.place) == 0:
            continue
        found_m, misfit_m = _least_absolute(seen, n_frames, config.hold)
        least_m = max(config.min_shift_m, config.min_sigmas * seen.scatter_m)
        moved = np.zeros(n_frames, bool)
        for same_way in (found_m >= least_m, found_m <= -least_m):
            moved |= same_way & (same_way.sum() >= config.min_block)
        if not moved.any():
            continue
        shifts_m[moved, axis] = found_m[moved]
        others += [
            other_m[:, None] * (np.arange(3) == axis)
            for other_m in _other_ways(seen, found_m, misfit_m, moved, config)
        ]
    return Displacements(shifts_m, np.array(others).reshape(-1, n_frames, 3))


def _other_ways(
    seen: _Seen,
    found_m: Float[np.ndarray, " frames"],
    misfit_m: float,
    moved: Bool[np.ndarray, " frames"],
    config: DisplacedConfig,
) -> list[Float[np.ndarray, " frames"]]:
    """What to add to the shifts to leave frames where they are and move others; only what fits as well.

    One way for every set of frames that share places: whether one set is moved says nothing of another.
    """
    n = len(moved)
    links = sparse.csr_matrix(
        (np.ones(len(seen.place)), (n + seen.place, seen.frame)), (n + seen.n_places,) * 2
    )
    _, part = csgraph.connected_components(links, directed=False)
    ways = []
    for one in np.unique(part[:n][moved]):
        chosen = moved & (part[:n] == one)
        kept = np.where(chosen, 0.25 * config.min_shift_m, np.inf)
        other_m, other_misfit_m = _least_absolute(seen, n, config.hold, kept)
        change_m = other_m - found_m
        shift_m = float(np.median(np.abs(found_m[chosen])))
        # If all frames go along, the scan is shifted as a whole, which moves nothing against anything.
        apart = np.ptp(change_m[np.unique(seen.frame)]) > 0.5 * config.min_shift_m
        if apart and other_misfit_m - misfit_m < config.doubt * shift_m:
            ways.append(change_m)
    return ways


def doubt_covariance(
    cells: Cells, displacements: Displacements, n_planes: int
) -> Float[np.ndarray, "planes planes"]:
    """How far planes would be off together if it was the other frames that were displaced, m^2.

    Second moments about the values of a law that has each of the two answers in half of the cases: the sides
    of a room move as a whole, so that lengths within a side are as certain as before.

    Args:
        cells: per frame and plane, at the shifts that were chosen.
        displacements: with frames as in the cells.
        n_planes: of the shape.
    """
    total = np.zeros((n_planes, n_planes))
    assert cells.frames is not None, "the cells of single frames are needed"
    normals = np.eye(3)[cells.axes] if cells.normals is None else cells.normals
    for other_m in displacements.others_m:
        per_cell_m = -np.sum(other_m[cells.frames] * normals, axis=1)
        moved_m = np.zeros(n_planes)
        for plane in np.unique(cells.plane):
            own = cells.plane == plane
            moved_m[plane] = _weighted_median(per_cell_m[own], np.asarray(cells.counts, float)[own])
        total += 0.5 * np.outer(moved_m, moved_m)
    return total


def _weighted_median(values: Float[np.ndarray, " n"], weights: Float[np.ndarray, " n"]) -> float:
    order = np.argsort(values)
    return float(values[order][np.searchsorted(np.cumsum(weights[order]), 0.5 * weights.sum())])


def _joined(parts: list[_Seen]) -> _Seen:
    first, second = parts
    return _Seen(
        np.concatenate([first.place, second.place + first.n_places]),
        np.concatenate([first.frame, second.frame]),
        np.concatenate([first.across_m, second.across_m]),
    )


def _places(
    points_m: Float[np.ndarray, "points 3"],
    chosen: np.ndarray,
    axis: int,
    frame_index: Int[np.ndarray, " points"],
    config: DisplacedConfig,
) -> _Seen:
    """Everything that two or more frames saw."""
    rows = np.flatnonzero(chosen)
    if len(rows) == 0:
        return _Seen(rows, rows, np.zeros(0))
    within = np.delete(points_m[rows], axis, axis=1)
    cell = np.floor((within - within.min(axis=0)) / config.patch_m).astype(np.int64)
    n_frames = int(frame_index.max()) + 1
    key = (cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1]) * n_frames + frame_index[rows]
    across_m = points_m[rows, axis]
    order = np.lexsort((across_m, key))
    key, across_m = key[order], across_m[order]
    # One frame may see two surfaces at one place, one behind the other.
    starts = np.flatnonzero(np.append(True, (np.diff(key) != 0) | (np.diff(across_m) > _GAP_M)))
    counts = np.diff(np.append(starts, len(key)))
    enough = counts >= config.min_points
    seen_m = across_m[starts + counts // 2][enough]
    at, own = np.divmod(key[starts][enough], n_frames)
    # Of one place, surfaces that lie far apart are two.
    order = np.lexsort((seen_m, at))
    at, own, seen_m = at[order], own[order], seen_m[order]
    apart = (np.diff(at, prepend=-1) != 0) | (np.diff(seen_m, prepend=0.0) > config.max_shift_m)
    place = np.cumsum(apart) - 1
    shared = np.bincount(place)[place] > 1
    _, place = np.unique(place[shared], return_inverse=True)
    return _Seen(place, own[shared], seen_m[shared])


_IN_FRONT_M = 0.2
"""A surface nearer to the middle of what a frame saw may be seen from either side."""
_GAP_M = 0.08
"""One frame's points on one surface lie no farther apart across it: a Kinect's depths step by 7 cm at 5 m."""


def _least_absolute(
    seen: _Seen, n_frames: int, hold: float, limits_m: Float[np.ndarray, " frames"] | None = None
) -> tuple[Float[np.ndarray, " frames"], float]:
    """Shifts s that minimise sum |y - m_place - s_frame| + hold sum |s_frame|, and the first sum there.

    As a linear program, errors and shifts in two parts that are not negative each.

    Args:
        seen: y by place and frame, metres.
        n_frames: all frames.
        hold: without unit.
        limits_m: of |s|.
    """
    n, n_places = len(seen.place), seen.n_places
    rows, ones = np.arange(n), np.ones(n)
    place = sparse.csr_matrix((ones, (rows, seen.place)), (n, n_places))
    frame = sparse.csr_matrix((ones, (rows, seen.frame)), (n, n_frames))
    equations = sparse.hstack([place, frame, -frame, sparse.eye(n), -sparse.eye(n)], format="csr")
    cost = np.concatenate([np.zeros(n_places), np.full(2 * n_frames, hold), np.ones(2 * n)])
    low, high = np.zeros(len(cost)), np.full(len(cost), np.inf)
    low[:n_places] = -np.inf
    if limits_m is not None:
        high[n_places : n_places + 2 * n_frames] = np.tile(limits_m, 2)
    # About their middle: map coordinates would cost the solver its digits.
    target_m = seen.across_m - np.median(seen.across_m)
    answer = optimize.linprog(
        cost, A_eq=equations, b_eq=target_m, bounds=np.column_stack([low, high]), method="highs"
    )
    shifts = answer.x[n_places : n_places + 2 * n_frames].reshape(2, n_frames)
    return shifts[0] - shifts[1], float(np.sum(answer.x[n_places + 2 * n_frames :]))
