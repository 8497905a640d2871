"""What a surface looks like, and how far it is from flat."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Surface:
    """Colour, texture and displacement of one surface."""

    colour: tuple[int, int, int] = (200, 200, 200)
    texture: Literal["plain", "stripes", "posters", "grain", "mosaic"] = "plain"
    bow_m: float = 0.0
    tilt_m: tuple[float, float] = (0.0, 0.0)
    axes: tuple[int, int] = (0, 2)
    """The coordinates that the displacement runs along."""
    u_m: tuple[float, float] = (-1.0, 1.0)
    v_m: tuple[float, float] = (-1.0, 1.0)
    """Extent of the whole surface along these axes."""

    @property
    def is_flat(self) -> bool:
        """Whether every point lies on the plane itself."""
        return self.bow_m == 0.0 and self.tilt_m == (0.0, 0.0)


def displacement_m(surface: Surface, points_m: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, " points"]:
    """How far into the room the surface lies from its plane.

    Legendre polynomials over the extent: their mean is zero, so the mean plane of a wall that is seen
    in full is the plane of the truth (DIN 18202 measures between mean planes as well).
    """
    u, v = (
        2.0 * (points_m[:, axis] - low) / (high - low) - 1.0
        for axis, (low, high) in zip(surface.axes, (surface.u_m, surface.v_m), strict=True)
    )
    # P2(u) + P2(v) runs from -1 in the middle to 2 in the corners: a bow of 3.
    bow = surface.bow_m / 3.0 * (1.5 * u**2 + 1.5 * v**2 - 1.0)
    return bow + surface.tilt_m[0] * u + surface.tilt_m[1] * v


def shade(
    surface: Surface, index: int, points_m: Float[np.ndarray, "points 3"]
) -> Float[np.ndarray, "points 3"]:
    """Colours of points of one surface, 0 to 255, without the camera's noise.

    Args:
        surface: its finish.
        index: its number; decides where its posters hang.
        points_m: Manhattan frame.
    """
    base = np.tile(np.array(surface.colour, float), (len(points_m), 1))
    x, y, z = points_m.T
    if surface.texture == "grain":
        return base * (1.0 + 0.12 * np.sin(40.0 * x + 3.0 * np.sin(4.0 * y)) * np.sin(9.0 * z + y))[:, None]
    if surface.texture == "stripes":
        return base * np.where(np.floor((x + y) / 0.15) % 2 == 0, 1.0, 0.82)[:, None]
    if surface.texture == "posters":
        return _posters(base, index, x + y, z)
    if surface.texture == "mosaic":
        return _mosaic(base, index, points_m[:, surface.axes[0]], points_m[:, surface.axes[1]])
    # Plain paint is never quite even.
    return base * (1.0 + 0.015 * np.sin(1.3 * x + 0.7 * y) * np.sin(1.1 * z + index))[:, None]


def _posters(
    base: Float[np.ndarray, "points 3"],
    index: int,
    s: Float[np.ndarray, " points"],
    z: Float[np.ndarray, " points"],
) -> Float[np.ndarray, "points 3"]:
    """A poster of 60 x 80 cm every 1.4 m, each with its own two colours."""
    cell = np.floor(s / 1.4)
    on = (np.abs(s - 1.4 * cell - 0.7) < 0.3) & (np.abs(z - 1.5) < 0.4)
    number = cell + 17.0 * index
    ink = 128.0 + 60.0 * np.sin(number[:, None] * np.array([1.7, 2.9, 4.3]) + np.array([0.0, 2.0, 4.0]))
    picture = ink * (0.75 + 0.25 * np.sign(np.sin(25.0 * s) * np.sin(21.0 * z)))[:, None]
    return np.where(on[:, None], picture, base)


_TILES_M = ((0.31, 0.35), (0.083, 0.25), (0.019, 0.20))
"""Side and contrast of the squares of a mosaic: from a metre's look to finer than any scan's points."""


def _mosaic(
    base: Float[np.ndarray, "points 3"],
    index: int,
    u: Float[np.ndarray, " points"],
    v: Float[np.ndarray, " points"],
) -> Float[np.ndarray, "points 3"]:
    """Squares of three sizes in colours that never repeat: a texture by which images can be compared."""
    factor = np.ones((len(u), 3))
    for side_m, contrast in _TILES_M:
        i, j = np.floor(u / side_m), np.floor(v / side_m)
        phase = 12.9898 * i + 78.233 * j + 37.719 * index
        # The usual hash of shaders: the sine's digits behind the fourth are as good as random.
        number = np.sin(phase[:, None] + np.array([0.0, 1.7, 3.1])) * 43758.5453
        factor += contrast * (2.0 * (number - np.floor(number)) - 1.0)
    return np.clip(0.62 * base * factor, 0.0, 255.0)
