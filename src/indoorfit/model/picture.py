"""Pictures that a user brings along for the textures."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8


@dataclass(frozen=True)
class Camera:
    """A pinhole camera without distortion; lengths in pixels, pixel centres at whole numbers."""

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int


@dataclass(frozen=True)
class CameraImage:
    """A colour image whose pose in the scan is known."""

    name: str
    """For messages."""
    camera: Camera
    position_m: Float[np.ndarray, " 3"]
    """Scan frame, metres."""
    R_scan_camera: Float[np.ndarray, "3 3"]
    """Camera axes: x right, y down, z forward."""
    load: Callable[[], UInt8[np.ndarray, "height width 3"]]
    """Reads the pixels (sRGB). A walk through a house has more images than fit into memory."""


@dataclass(frozen=True)
class Photo:
    """An ordinary photo and where the corners of a face are on it."""

    face: str
    """Id of the face."""
    name: str
    """For messages."""
    rgb: UInt8[np.ndarray, "height width 3"]
    """Upright, as a viewer shows it."""
    corners: Float[np.ndarray, "4 2"]
    """Column and row of the face's upper left, upper right, lower right and lower left corner as seen from
    inside, in pixels from the photo's upper left corner. They may lie outside the photo."""


@dataclass(frozen=True)
class Pictures:
    """Everything that may go onto the faces besides the points' own colours."""

    images: tuple[CameraImage, ...] = ()
    photos: tuple[Photo, ...] = ()
