"""Squares of the plan, finer than the pixels that evidence is counted in."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from .surfaces import Surfaces


@dataclass(frozen=True)
class Raster:
    """Squares over a rectangle of the plan, Manhattan frame."""

    low_m: Float[np.ndarray, " 2"]
    """Its lower corner."""
    shape: tuple[int, int]
    """Number of squares along x, along y."""
    side_m: float

    @property
    def size(self) -> int:
        """Number of squares."""
        return self.shape[0] * self.shape[1]

    def of(self, xy_m: Float[np.ndarray, "points 2"]) -> Int[np.ndarray, " points"]:
        """The square that each point is in; `size` for those in none."""
        i, j = np.floor((xy_m - self.low_m) / self.side_m).astype(np.int64).T
        outside = (i < 0) | (j < 0) | (i >= self.shape[0]) | (j >= self.shape[1])
        return np.where(outside, self.size, i * self.shape[1] + j)

    def centres_m(self, chosen: Bool[np.ndarray, " squares"]) -> Float[np.ndarray, "chosen 2"]:
        """Middles of some squares."""
        i, j = np.divmod(np.flatnonzero(chosen), self.shape[1])
        return self.low_m + self.side_m * (np.stack([i, j], axis=1) + 0.5)


def raster_over(surfaces: Surfaces) -> Raster:
    """Four squares to a pixel, over all that lies between the outermost walls, floors and ceilings."""
    xy_m = np.concatenate([*surfaces.walls_m, surfaces.floor_m, surfaces.ceiling_m])[:, :2]
    low_m, side_m = xy_m.min(axis=0), 0.5 * surfaces.pixel_m
    n_x, n_y = (int(n) + 1 for n in (xy_m.max(axis=0) - low_m) / side_m)
    return Raster(low_m, (n_x, n_y), side_m)
