"""The pose of a scan: how far off level and off the axes the coordinates of the file are."""

import numpy as np
from jaxtyping import Float

from indoorfit.model import Frame


def rotation_about(axis: Float[np.ndarray, " 3"], angle_rad: float) -> Float[np.ndarray, "3 3"]:
    """Rotation by an angle about a unit axis (Rodrigues), counter-clockwise seen against the axis."""
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle_rad) * k + (1.0 - np.cos(angle_rad)) * (k @ k)


def scan_frame(
    yaw_rad: float,
    tilt_rad: float,
    tilt_azimuth_rad: float,
    translation_m: tuple[float, float, float],
) -> Frame:
    """The frame of a room that is turned by yaw about z, then tilted about a horizontal axis.

    Args:
        yaw_rad: turn about the vertical.
        tilt_rad: angle between the room's vertical and the scan's z axis.
        tilt_azimuth_rad: direction of the horizontal tilt axis, from the scan's x axis.
        translation_m: scan coordinates of the Manhattan origin.
    """
    tilt_axis = np.array([np.cos(tilt_azimuth_rad), np.sin(tilt_azimuth_rad), 0.0])
    R_scan_manhattan = rotation_about(tilt_axis, tilt_rad) @ rotation_about(
        np.array([0.0, 0.0, 1.0]), yaw_rad
    )
    return Frame(R_scan_manhattan.T, np.array(translation_m, float))
