"""Colours of surfaces: distinct per surface, with a texture mild enough to look painted."""

import colorsys

import numpy as np
from jaxtyping import Float, Int, UInt8

_GOLDEN = 0.6180339887498949
"""Steps of the golden ratio never repeat a hue and keep neighbours apart."""


def palette(n: int) -> Float[np.ndarray, "n 3"]:
    """Light, clearly different colours, red-green-blue from 0 to 255."""
    hsv = [((0.08 + k * _GOLDEN) % 1.0, 0.30 + 0.12 * (k % 3), 0.92 - 0.10 * (k % 2)) for k in range(n)]
    return 255.0 * np.array([colorsys.hsv_to_rgb(*c) for c in hsv]).reshape(n, 3)


def surface_colours(
    surface: Int[np.ndarray, " points"], points_m: Float[np.ndarray, "points 3"], rng: np.random.Generator
) -> UInt8[np.ndarray, "points 3"]:
    """Colours of points by the surface that they lie on.

    Args:
        surface: number of each point's surface, from 0.
        points_m: true positions, metres; the texture is a wave of a few decimetres, the same on all axes.
        rng: grain of single points (3 of 255).
    """
    base = palette(int(surface.max(initial=-1)) + 1)[surface]
    wave = np.sin(points_m @ np.array([9.0, 7.0, 11.0])) * np.sin(points_m @ np.array([-5.0, 13.0, 4.0]))
    shade = 8.0 * wave + rng.normal(0.0, 3.0, len(surface))
    return np.clip(base + shade[:, None], 0.0, 255.0).round().astype(np.uint8)
