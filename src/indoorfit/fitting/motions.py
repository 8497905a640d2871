"""Rigid motions of the frames of a scan."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import Rotation

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
