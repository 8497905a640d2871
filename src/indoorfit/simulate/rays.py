"""The rays of one frame: where each pixel looks, in the sensor's own axes."""

import numpy as np
from jaxtyping import Float, Int

from .raycast import BUNDLE
from .sensors import Sensor


def pixel_grid(sensor: Sensor) -> Float[np.ndarray, "rows columns 2"]:
    """Column and row coordinates of the pixel centres."""
    rows, columns = np.mgrid[0.5 : sensor.rows, 0.5 : sensor.columns]
    return np.stack([columns, rows], axis=-1)


def directions(sensor: Sensor, pixels: Float[np.ndarray, "... 2"]) -> Float[np.ndarray, "... 3"]:
    """Viewing directions of pixel coordinates.

    Returns:
        sensor axes. For a camera x right, y down, z forward with z = 1: a multiple of it is a depth. For
        a scanner unit vectors with z up: a multiple is a range.
    """
    column, row = pixels[..., 0], pixels[..., 1]
    if sensor.kind == "camera":
        fx, fy = sensor.focal_pixels
        x, y = (column - 0.5 * sensor.columns) / fx, (row - 0.5 * sensor.rows) / fy
        return np.stack([x, y, np.ones_like(x)], axis=-1)
    azimuth = column / sensor.columns * sensor.width_rad
    elevation = 0.5 * np.pi - row / sensor.rows * sensor.height_rad
    c = np.cos(elevation)
    return np.stack([c * np.cos(azimuth), c * np.sin(azimuth), np.sin(elevation)], axis=-1)


def bundle_order(sensor: Sensor) -> Int[np.ndarray, " rays"]:
    """Pixels (row-major indices) in an order that keeps neighbours together for the ray caster."""
    side = round(BUNDLE**0.5)
    row, column = np.divmod(np.arange(sensor.n_rays), sensor.columns)
    return np.lexsort((column, row, column // side, row // side))
