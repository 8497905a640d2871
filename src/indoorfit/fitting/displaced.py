"""Frames that were registered somewhere else: how far, before any plan is looked for.

A frame that is off by more than walls are told apart by builds walls of its own, and no fit of the right walls
sees its points. But other frames have seen some of the same places. What they disagree by is the shift.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy import optimize, sparse


@dataclass(frozen=True)
class DisplacedConfig:
    """When a frame counts as registered somewhere else."""

    min_shift_m: float = 0.10
    """Shift along one axis from which on a frame is put back before the plan is looked for: its points are then
    beyond the reach of their walls (`joint.association.reach_m`). Smaller slips are found by the fit."""
    max_shift_m: float = 0.25
    """Surfaces that lie farther apart are two surfaces, however many frames disagree on them."""
    patch_m: float = 0.5
    """Side of the places at which frames are compared: several of them in one frame's view."""
    min_points: int = 10
    """Fewer points of a frame at a place have no location."""
    hold: float = 1.0
    """What keeps a frame where it is, in places: only two or more that agree can move it."""


def displaced_shifts(
    points_m: Float[np.ndarray, "points 3"],
    axis_of: Int[np.ndarray, " points"],
    frame_index: Int[np.ndarray, " points"],
    centres_m: Float[np.ndarray, "frames 3"],
    config: DisplacedConfig,
) -> Float[np.ndarray, "frames 3"]:
    """How far along each axis frames lie from where the others saw the same places; 0 within the limit.

    Every axis on its own: the location of a surface at a place, seen by frame i, is that of the place plus
    the shift of the frame. Both are fitted with absolute errors, which neither furniture nor a minority of
    frames can pull, and frames have to be held by nothing but their own inertia. The program is convex: a
    block of frames moves as one where that is better, which no frame could begin alone.

    Which of two groups of frames was displaced is decided by their number.

    Args:
        points_m: Manhattan frame, about.
        axis_of: that the surface that each point lies on is perpendicular to, -1 for none.
        frame_index: 0, 1, ... in the order in which the frames were taken.
        centres_m: of each frame the sensor's place, or the middle of what it saw; Manhattan frame.
        config: see `DisplacedConfig`.
    """
    n_frames = int(frame_index.max()) + 1
    shifts_m = np.zeros((n_frames, 3))
    for axis in range(3):
        # The two sides of a partition are two surfaces: each is seen from its own side.
        depth_m = points_m[:, axis] - centres_m[frame_index, axis]
        sides = ((axis_of == axis) & (sign * depth_m > _IN_FRONT_M) for sign in (-1.0, 1.0))
        places = [_places(points_m, side, axis, frame_index, config) for side in sides]
        count = int(places[0][0].max(initial=-1)) + 1
        place = np.concatenate([places[0][0], places[1][0] + count])
        frame, across_m = (np.concatenate([p[k] for p in places]) for k in (1, 2))
        if len(place):
            shifts_m[:, axis] = _least_absolute(place, frame, across_m, n_frames, config.hold)
    return np.where(np.abs(shifts_m) < config.min_shift_m, 0.0, shifts_m)


def _places(
    points_m: Float[np.ndarray, "points 3"],
    chosen: np.ndarray,
    axis: int,
    frame_index: Int[np.ndarray, " points"],
    config: DisplacedConfig,
) -> tuple[Int[np.ndarray, " seen"], Int[np.ndarray, " seen"], Float[np.ndarray, " seen"]]:
    """Place, frame and position across the surface, of everything that two or more frames saw."""
    rows = np.flatnonzero(chosen)
    within = np.delete(points_m[rows], axis, axis=1)
    cell = np.floor((within - within.min(axis=0, initial=np.inf)) / config.patch_m).astype(np.int64)
    key = (cell[:, 0] * (cell[:, 1].max(initial=0) + 1) + cell[:, 1]) * (frame_index.max() + 1)
    key += frame_index[rows]
    across_m = points_m[rows, axis]
    order = np.lexsort((across_m, key))
    key, across_m = key[order], across_m[order]
    # One frame may see two surfaces at one place, one behind the other.
    new = np.append(True, (key[1:] != key[:-1]) | (np.diff(across_m) > _GAP_M)) if len(key) else key > 0
    starts = np.flatnonzero(new)
    counts = np.diff(np.append(starts, len(key)))
    enough = counts >= config.min_points
    middle_m = across_m[starts + counts // 2]
    own, at, seen_m = key[starts][enough] % (frame_index.max() + 1), key[starts][enough], middle_m[enough]
    at //= frame_index.max() + 1
    # Of one place, surfaces that lie far apart are two.
    order = np.lexsort((seen_m, at))
    own, at, seen_m = own[order], at[order], seen_m[order]
    if len(at) == 0:
        return at, own, seen_m
    apart = np.append(True, (at[1:] != at[:-1]) | (np.diff(seen_m) > config.max_shift_m))
    place = np.cumsum(apart) - 1
    shared = np.bincount(place)[place] > 1
    _, place = np.unique(place[shared], return_inverse=True)
    return place, own[shared], seen_m[shared]


_IN_FRONT_M = 0.2
"""A surface nearer to the middle of what a frame saw may be seen from either side."""
_GAP_M = 0.08
"""Of one frame's points on one surface none lie farther apart across it: a Kinect's depths step by 7 cm at 5 m."""


def _least_absolute(
    place: Int[np.ndarray, " seen"],
    frame: Int[np.ndarray, " seen"],
    across_m: Float[np.ndarray, " seen"],
    n_frames: int,
    hold: float,
) -> Float[np.ndarray, " frames"]:
    """Shifts s of the frames that minimise sum |y - m_place - s_frame| + hold sum |s_frame|."""
    n, n_places = len(place), int(place.max()) + 1
    rows = np.arange(n)
    middle_m = float(np.median(across_m))
    ones = np.ones(n)
    model = sparse.coo_matrix(
        (np.tile(ones, 2), (np.tile(rows, 2), np.append(place, n_places + frame))),
        (n, n_places + n_frames),
    )
    size = n_places + n_frames
    errors = sparse.hstack([sparse.eye(n), -sparse.eye(n)])
    held = sparse.hstack(
        [sparse.csr_matrix((n_frames, n_places)), sparse.eye(n_frames), sparse.csr_matrix((n_frames, 2 * n))]
    )
    moved = sparse.hstack([sparse.eye(n_frames), -sparse.eye(n_frames)])
    equal = sparse.bmat(
        [[sparse.hstack([model, errors]), None], [held, moved]], format="csr"
    )
    cost = np.concatenate([np.zeros(size), np.ones(2 * n), np.full(2 * n_frames, hold)])
    bounds = [(None, None)] * size + [(0.0, None)] * (2 * n + 2 * n_frames)
    target = np.concatenate([across_m - middle_m, np.zeros(n_frames)])
    answer = optimize.linprog(cost, A_eq=equal, b_eq=target, bounds=bounds, method="highs")
    return answer.x[n_places:size]
