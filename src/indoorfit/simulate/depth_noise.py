"""What a sensor makes of the true distances of one frame."""

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from .sensors import Sensor

_EDGE_SHARE = 0.03
"""Neighbours look across an edge if their distances differ by this share more than one surface explains."""


def measured(
    sensor: Sensor,
    distance_m: Float[np.ndarray, "rows columns"],
    incidence_rad: Float[np.ndarray, "rows columns"],
    rng: np.random.Generator,
) -> Float[np.ndarray, "rows columns"]:
    """Depths (or ranges) with all errors of the sensor; NaN where it gives no value. See `measure`."""
    return measure(sensor, distance_m, incidence_rad, rng)[0]


def measure(
    sensor: Sensor,
    distance_m: Float[np.ndarray, "rows columns"],
    incidence_rad: Float[np.ndarray, "rows columns"],
    rng: np.random.Generator,
) -> tuple[Float[np.ndarray, "rows columns"], Bool[np.ndarray, "rows columns"]]:
    """What the sensor gives, and where that lies on no surface at all.

    Args:
        sensor: its laws.
        distance_m: true depth, or range if `sensor.along_ray`; not finite where nothing returns.
        incidence_rad: angle between ray and surface normal.
        rng: draws the same number of values whatever the scene, so that frames stay comparable.

    Returns:
        depths (or ranges) with all errors, NaN where the sensor gives no value; whether each pixel is mixed,
        that is, ends between two surfaces.
    """
    valid = np.isfinite(distance_m) & (incidence_rad <= sensor.max_incidence_rad)
    true_m = np.where(valid, distance_m, 1.0)
    incidence = np.where(valid, incidence_rad, 0.0)
    mixed_m = _mix_edges(sensor, true_m, incidence, valid, rng)
    noise = rng.standard_normal(true_m.shape)
    if sensor.correlation_pixels > 0.0:
        noise = _correlated(noise, sensor.correlation_pixels)
    value_m = mixed_m + noise * _sigma_m(sensor, mixed_m, incidence) + _bowl_m(sensor, true_m.shape)
    if sensor.step_per_m > 0.0:
        value_m = _quantised(value_m, sensor.step_per_m)
    keep = valid & (value_m >= sensor.min_m) & (value_m <= sensor.max_m)
    keep &= rng.random(true_m.shape) >= sensor.dropout_share
    return np.where(keep, value_m, np.nan), mixed_m != true_m


def _sigma_m(
    sensor: Sensor,
    distance_m: Float[np.ndarray, "rows columns"],
    incidence_rad: Float[np.ndarray, "rows columns"],
) -> Float[np.ndarray, "rows columns"]:
    sigma_m = sensor.law_m(distance_m)
    if sensor.step_per_m > 0.0:
        # The published law was measured on quantised depths. Rounding alone gives step / sqrt(12), so
        # only the rest is drawn (Sheppard's correction).
        rounding_m = sensor.step_per_m * distance_m**2 / np.sqrt(12.0)
        sigma_m = np.sqrt(np.maximum(sigma_m**2 - rounding_m**2, 0.0))
    if sensor.incidence_power > 0.0:
        sigma_m = sigma_m / np.cos(np.minimum(incidence_rad, 1.55)) ** sensor.incidence_power
    if sensor.grazing_m > 0.0:
        t = np.minimum(incidence_rad, 1.55)
        sigma_m = sigma_m + sensor.grazing_m / np.sqrt(distance_m) * (t / (0.5 * np.pi - t)) ** 2
    return sigma_m


def _quantised(
    depth_m: Float[np.ndarray, "rows columns"], step_per_m: float
) -> Float[np.ndarray, "rows columns"]:
    """Depth after rounding the disparity, which is 1 / (step * depth) in whole numbers."""
    with np.errstate(divide="ignore", invalid="ignore"):
        disparity = np.round(1.0 / (step_per_m * depth_m))
        return np.where(disparity > 0, 1.0 / (step_per_m * disparity), np.nan)


def _correlated(noise: Float[np.ndarray, "rows columns"], pixels: float) -> Float[np.ndarray, "rows columns"]:
    """White noise smoothed by a Gaussian, scaled back to unit variance."""
    sigma = 0.5 * pixels
    smooth = ndimage.gaussian_filter(noise, sigma, mode="wrap")
    # The variance of a smoothed unit noise is the sum of the squared weights: 1 / (4 pi sigma^2).
    impulse = np.zeros(noise.shape)
    impulse[0, 0] = 1.0
    weights = ndimage.gaussian_filter(impulse, sigma, mode="wrap")
    return smooth / np.sqrt((weights**2).sum())


def _bowl_m(sensor: Sensor, grid: tuple[int, ...]) -> Float[np.ndarray, "rows columns"]:
    """Zero on the ellipse that touches the middles of the image's sides."""
    rows = np.linspace(-1.0, 1.0, grid[0])[:, None]
    columns = np.linspace(-1.0, 1.0, grid[1])[None]
    return sensor.bowl_m * (rows**2 + columns**2 - 1.0)


def _mix_edges(
    sensor: Sensor,
    distance_m: Float[np.ndarray, "rows columns"],
    incidence_rad: Float[np.ndarray, "rows columns"],
    valid: Bool[np.ndarray, "rows columns"],
    rng: np.random.Generator,
) -> Float[np.ndarray, "rows columns"]:
    """Pixels whose beam covers an edge end somewhere between the two surfaces."""
    chance, weight = rng.random(distance_m.shape), rng.random(distance_m.shape)
    if sensor.mixed_share == 0.0:
        return distance_m
    mixed_m = distance_m.copy()
    slope = np.tan(np.minimum(incidence_rad, 1.5))
    for axis, between_rad in ((0, sensor.height_rad / sensor.rows), (1, sensor.width_rad / sensor.columns)):
        neighbour_m = np.roll(distance_m, 1, axis)
        # A surface seen at a grazing angle recedes from pixel to pixel; that is no edge. Twice its slope
        # leaves room for the curvature of a plane in terms of range.
        share = _EDGE_SHARE + 2.0 * between_rad * np.maximum(slope, np.roll(slope, 1, axis))
        edge = np.abs(neighbour_m - distance_m) > share * distance_m
        edge &= valid & np.roll(valid, 1, axis) & (chance < sensor.mixed_share)
        if axis == 0 or sensor.kind == "camera":
            # Only a scanner's azimuths meet again.
            edge[(slice(None),) * axis + (0,)] = False
        mixed_m = np.where(edge, weight * distance_m + (1.0 - weight) * neighbour_m, mixed_m)
    return mixed_m
