"""Frames that were registered somewhere else are put back before the plan is looked for."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from indoorfit.config import RunConfig
from indoorfit.fitting import Displacements, displaced_shifts
from indoorfit.model import FitResult, Note, Scan

from .front import FrontEnd, front_end
from .provenance import Stopwatch

Moves = Mapping[int, Float[np.ndarray, " 3"]]
"""What was added to the points of a frame, by its id; scan axes, metres."""


@dataclass(frozen=True)
class PutBack:
    """A scan whose displaced frames stand where the others say they belong."""

    scan: Scan
    moves: Moves
    found: Displacements | None
    """Of the frames in the order of their ids; None where none was looked for or none is off."""
    notes: tuple[Note, ...]


def righted_front(
    scan: Scan, config: RunConfig, rng: np.random.Generator, watch: Stopwatch
) -> tuple[FrontEnd, PutBack]:
    """The front end of the scan with displaced frames put back, and what was moved.

    Args:
        scan: without the points that are to be ignored.
        config: settings of the front end and of the frames.
        rng: for orientation.
        watch: gets the seconds of each stage.

    Raises:
        InputError: the cloud cannot be a room.
    """
    front = front_end(scan, config, rng, watch)
    with watch.stage("frames"):
        righted = put_back(scan, front, config)
    return (front_end(righted.scan, config, rng, watch) if righted.moves else front), righted


def put_back(scan: Scan, front: FrontEnd, config: RunConfig) -> PutBack:
    """Move displaced frames; the scan itself where there is none, or frames are not to be used.

    Args:
        scan: that `front` was made of.
        front: axes, and which surface each point lies on.
        config: `belief.use_frames` and `belief.displaced`.
    """
    unchanged = PutBack(scan, {}, None, ())
    if scan.frame_ids is None or not config.belief.use_frames or config.method != "joint":
        return unchanged
    ids, index = np.unique(scan.frame_ids, return_inverse=True)
    if len(ids) < config.belief.pose_field.min_frames:
        return unchanged
    normals = np.abs(front.segments.normals)
    axis_of_segment = np.append(np.argmax(normals, axis=1), -1)
    # The last entry serves the label of no segment, -1.
    axis_of_segment[np.flatnonzero([face_class is None for face_class in front.classes])] = -1
    points_m = front.frame.to_manhattan(scan.points_m)
    found = displaced_shifts(
        points_m,
        axis_of_segment[front.segments.labels][front.point_surfel],
        index,
        _centres_m(scan, front, points_m, index),
        config.belief.displaced,
    )
    shifts_m = found.shifts_m
    moved = np.flatnonzero(np.any(shifts_m != 0.0, axis=1))
    if len(moved) == 0:
        return unchanged
    back_m = -front.frame.directions_to_scan(shifts_m)
    moves = {int(ids[k]): back_m[k] for k in moved}
    sensors = tuple(
        replace(sensor, position_m=sensor.position_m + moves[sensor.id]) if sensor.id in moves else sensor
        for sensor in scan.frames
    )
    righted = replace(scan, points_m=scan.points_m + back_m[index], frames=sensors)
    return PutBack(righted, moves, found, (_note(moves, len(ids), len(found.others_m) > 0),))


def _centres_m(
    scan: Scan, front: FrontEnd, points_m: Float[np.ndarray, "points 3"], index: np.ndarray
) -> Float[np.ndarray, "frames 3"]:
    """The sensor's place where it is known, else the middle of what it saw; Manhattan frame."""
    assert scan.frame_ids is not None, "asked for frames only"
    count = np.bincount(index)
    centres_m = np.column_stack([np.bincount(index, points_m[:, k]) for k in range(3)]) / count[:, None]
    known = {sensor.id: sensor.position_m for sensor in scan.frames}
    for k, frame_id in enumerate(np.unique(scan.frame_ids)):
        if int(frame_id) in known:
            centres_m[k] = front.frame.to_manhattan(known[int(frame_id)])
    return centres_m


def _note(moves: Moves, n_frames: int, open_: bool) -> Note:
    far_m = max(float(np.linalg.norm(move_m)) for move_m in moves.values())
    first, last = min(moves), max(moves)
    doubt = (
        "It may as well be the others that are displaced: then a whole side of the room is off by as much, "
        "and the intervals of lengths across the room reach that far. "
    )
    return Note(
        "FRAMES_DISPLACED",
        f"{len(moves)} of {n_frames} frames (from {first} to {last}) lie up to {100 * far_m:.0f} cm from "
        "where the others saw the same surfaces; they were put back before the fit. "
        f"{doubt if open_ else ''}"
        "Register the scan again, or measure one length across the room by hand.",
    )


def with_moves(result: FitResult, moves: Moves) -> FitResult:
    """The result with motions that start from the scan as it was: the move, then the slip that was found."""
    motions = tuple(
        replace(
            motion,
            pivot_m=motion.pivot_m - moves[motion.id],
            shift_m=motion.shift_m + moves[motion.id],
            displaced=True,
        )
        if motion.id in moves
        else motion
        for motion in result.registration
    )
    return replace(result, registration=motions)
