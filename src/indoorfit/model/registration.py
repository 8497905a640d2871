"""What a fit found of the registration of the scan's frames."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class FrameMotion:
    """The small rigid motion that takes one frame's slip out.

    A point p of the frame goes to ``rotation @ (p - pivot) + pivot + shift``.
    A part that all frames share (the scan as a whole) shows in no residual and is left out.
    """

    id: int
    """As in `Scan.frame_ids`."""
    pivot_m: Float[np.ndarray, " 3"]
    """The sensor's place where it is known, else the middle of what the frame saw; scan frame."""
    rotation: Float[np.ndarray, "3 3"]
    shift_m: Float[np.ndarray, " 3"]
    """Scan axes."""
    shift_std_m: float
    """Standard uncertainty of the shift, root mean square over the axes."""
    turn_std_rad: float
    """Standard uncertainty of the rotation, root mean square over the axes."""
    displaced: bool
    """Whether the frame stood far from where the others put it."""
