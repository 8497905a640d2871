"""Frames of a finished scan put somewhere else, as by a registration that went wrong for them alone."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from .virtual import VirtualScan


def displaced(
    virtual: VirtualScan, frames: Int[np.ndarray, " _"], shift_m: Float[np.ndarray, " 3"]
) -> VirtualScan:
    """The scan with some frames shifted: their points, and where the registration believes the sensor was.

    Args:
        virtual: with frame ids.
        frames: ids of those frames.
        shift_m: along the true Manhattan axes.
    """
    scan = virtual.scan
    assert scan.frame_ids is not None, "frames can only be moved where points tell theirs"
    shift_m = virtual.frame.directions_to_scan(shift_m)
    points_m = scan.points_m + np.isin(scan.frame_ids, frames)[:, None] * shift_m
    sensors = tuple(
        replace(sensor, position_m=sensor.position_m + shift_m) if sensor.id in frames else sensor
        for sensor in scan.frames
    )
    return replace(virtual, scan=replace(scan, points_m=points_m, frames=sensors))
