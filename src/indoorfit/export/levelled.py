"""The scan's coordinates with z up, for formats in which up is z."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.model import Frame


@dataclass(frozen=True)
class LevelledFrame:
    """The scan frame turned by the smallest angle that brings the rooms' vertical to z.

    For a scan that is level already, such as one in map coordinates, this is the scan frame itself but for
    the fitted tilt; the turn is about the Manhattan frame's origin, so nothing moves by more than
    tilt times distance. ``p_levelled = R_levelled_manhattan @ p_manhattan + origin_m``.
    """

    yaw_rad: float
    """Turn about z from the levelled axes to the Manhattan axes."""
    origin_m: Float[np.ndarray, " 3"]
    """Of the Manhattan frame, the same in scan and levelled coordinates."""
    R_scan_levelled: Float[np.ndarray, "3 3"]
    """``p_scan = R_scan_levelled @ (p_levelled - origin_m) + origin_m``."""

    @property
    def R_levelled_manhattan(self) -> Float[np.ndarray, "3 3"]:
        """The turn about z as a matrix."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def levelled(frame: Frame) -> LevelledFrame:
    """The levelled frame of a model."""
    up = frame.R_manhattan_scan[2]
    turned = _turn_to_z(up) @ frame.R_manhattan_scan.T
    yaw_rad = math.atan2(turned[1, 0], turned[0, 0])
    upright = LevelledFrame(yaw_rad, frame.origin_scan_m, np.eye(3)).R_levelled_manhattan
    return LevelledFrame(yaw_rad, frame.origin_scan_m, frame.R_manhattan_scan.T @ upright.T)


def _turn_to_z(up: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """The smallest rotation that takes a unit vector to z (Rodrigues)."""
    if up[2] < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    x, y, z = np.cross(up, [0.0, 0.0, 1.0])
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + up[2])
