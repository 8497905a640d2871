"""Rigid motions of the frames of a scan."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import Rotation

from indoorfit.model import Frame, FrameMotion, Scan, SensorFrame

from .uncertainty import FrameSlips


@dataclass(frozen=True)
class RigidMotions:
    """One motion per frame: p becomes ``rotation @ p + shift``."""

    rotations: Float[np.ndarray, "frames 3 3"]
    shifts_m: Float[np.ndarray, "frames 3"]

    def apply(
        self, points_m: Float[np.ndarray, "points 3"], frame_index: Int[np.ndarray, " points"]
    ) -> Float[np.ndarray, "points 3"]:
        """Move every point with its frame.

        Args:
            points_m: in the axes of the motions.
            frame_index: row of each point's frame.
        """
        moved_m = np.empty_like(points_m)
        # Frame by frame: one matrix per point would cost nine numbers each.
        order = np.argsort(frame_index, kind="stable")
        ends = np.searchsorted(frame_index[order], np.arange(len(self.shifts_m)), side="right")
        start = 0
        for rotation, shift_m, end in zip(self.rotations, self.shifts_m, ends, strict=True):
            rows = order[start:end]
            moved_m[rows] = points_m[rows] @ rotation.T + shift_m
            start = end
        return moved_m


def corrections(slips: FrameSlips, n_frames: int) -> RigidMotions:
    """The motions that take the slips out, in the Manhattan axes of the slips; frames without one stay."""
    rotations, shifts_m = np.tile(np.eye(3), (n_frames, 1, 1)), np.zeros((n_frames, 3))
    back = Rotation.from_rotvec(slips.turns_rad).inv()
    rotations[slips.frames] = back.as_matrix()
    shifts_m[slips.frames] = slips.pivots_m - back.apply(slips.pivots_m + slips.shifts_m)
    return RigidMotions(rotations, shifts_m)


def frame_motions(
    slips: FrameSlips, ids: Int[np.ndarray, " frames"], frame: Frame
) -> tuple[FrameMotion, ...]:
    """The corrections in the scan's coordinates.

    Args:
        slips: of the pose field, Manhattan axes.
        ids: the scan's frame ids in the order of the slips' indices.
        frame: the fit at which the slips were estimated.
    """
    R_scan_manhattan = frame.R_manhattan_scan.T
    back = Rotation.from_rotvec(slips.turns_rad).inv()
    shifts_m = -back.apply(slips.shifts_m)
    rotations = R_scan_manhattan @ back.as_matrix() @ frame.R_manhattan_scan
    variances = np.diagonal(slips.covariances, axis1=1, axis2=2).reshape(-1, 2, 3).mean(axis=2)
    stds = np.sqrt(np.maximum(variances, 0.0))
    return tuple(
        FrameMotion(
            id=int(ids[slips.frames[k]]),
            pivot_m=frame.to_scan(slips.pivots_m[k]),
            rotation=rotations[k],
            shift_m=R_scan_manhattan @ shifts_m[k],
            shift_std_m=float(stds[k, 0]),
            turn_std_rad=float(stds[k, 1]),
            displaced=bool(slips.displaced[k]),
        )
        for k in range(len(slips.frames))
    )


def register(scan: Scan, motions: Sequence[FrameMotion]) -> Scan:
    """The scan with every frame moved to where the fit says it belongs; frames without a motion stay.

    Args:
        scan: with frame ids.
        motions: of a fit of this scan.
    """
    assert scan.frame_ids is not None, "frames can only be moved where points tell theirs"
    known = {motion.id: motion for motion in motions}
    points_m = scan.points_m.copy()
    order = np.argsort(scan.frame_ids, kind="stable")
    ids, starts = np.unique(scan.frame_ids[order], return_index=True)
    for frame_id, rows in zip(ids, np.split(order, starts[1:]), strict=True):
        if int(frame_id) in known:
            points_m[rows] = _moved(known[int(frame_id)], scan.points_m[rows])
    sensors = tuple(_sensor_moved(sensor, known.get(sensor.id)) for sensor in scan.frames)
    return replace(scan, points_m=points_m, frames=sensors)


def _moved(motion: FrameMotion, points_m: Float[np.ndarray, "*points 3"]) -> Float[np.ndarray, "*points 3"]:
    return (points_m - motion.pivot_m) @ motion.rotation.T + motion.pivot_m + motion.shift_m


def _sensor_moved(sensor: SensorFrame, motion: FrameMotion | None) -> SensorFrame:
    if motion is None:
        return sensor
    rotation = None if sensor.rotation is None else motion.rotation @ sensor.rotation
    return SensorFrame(sensor.id, _moved(motion, sensor.position_m), rotation)
