"""Lines of sight: the empty segments between the sensor's places and what it saw."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Rays:
    """Straight segments along which the sensor looked, with nothing between their ends; Manhattan frame."""

    origins_m: Float[np.ndarray, "rays 3"]
    """Where the sensor stood."""
    ends_m: Float[np.ndarray, "rays 3"]
    """What it saw from there."""
