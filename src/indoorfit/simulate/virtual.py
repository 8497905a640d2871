"""What every simulator hands over: the scan as a user would have it, and what it was made from."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from indoorfit.model import Frame, Scan, SensorFrame, Shape

from .scene import Scene


@dataclass(frozen=True)
class VirtualScan:
    """A simulated scan with its exact truth."""

    scan: Scan
    """Points, colours, frame ids and sensor poses in the scan frame: all that a fitter may see."""
    shape: Shape
    """The true planes and cubes, Manhattan frame."""
    frame: Frame
    """The true pose of the Manhattan frame in the scan."""
    point_plane: Int[np.ndarray, " points"]
    """Index in `shape.planes` of the plane that each point was taken on; -1 for furniture, outliers,
    jambs of doors, everything outside, and pixels that end between two surfaces."""
    true_frames: tuple[SensorFrame, ...] = ()
    """Where the sensor really was; `scan.frames` holds what the registration believed."""
    scene: Scene | None = None
    """What was scanned; None where points were only drawn from `shape`."""
    scale_error: float = 0.0
    """The scan is larger than `shape` by this share."""
