"""Cells, the unit of all noise modelling, and contrasts, the dimensions as rows of a matrix.

A cell is a patch of one plane, or one frame's part of it, reduced to a robust location of its residuals.
Points inside a cell share their registration error, so only the spread *between* cells says anything about
how far a plane may be off.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

ROTATIONS = 3
"""Leading columns of a design: the shared rotation, before one column per plane offset."""


@dataclass(frozen=True)
class Cells:
    """Residuals of a fitted model, patch by patch, with their derivatives.

    The model is linear around the fit: ``r(theta0 + delta) = residuals_m + design @ delta``.
    """

    plane: Int[np.ndarray, " cells"]
    """Index of the plane that the cell lies on; planes have independent fields."""
    design: Float[np.ndarray, "cells params"]
    """d residual / d theta, theta = (rotation 3, offset per plane): m/rad, then -1 at the own offset."""
    centroids_m: Float[np.ndarray, "cells 3"]
    """Manhattan frame, metres."""
    residuals_m: Float[np.ndarray, " cells"]
    """Robust location of the point residuals ``e_axis . q - offset``, metres, at the linearisation point."""
    variances_m2: Float[np.ndarray, " cells"]
    """Variance of that location from the points alone: v / n."""
    counts: Int[np.ndarray, " cells"] | Float[np.ndarray, " cells"]
    """Points in the cell, at least 1."""
    frames: Int[np.ndarray, " cells"] | None = None
    """Index of the frame, in the order in which the frames were taken; None where cells mix frames."""
    frame_centres_m: Float[np.ndarray, "frames 3"] | None = None
    """Sensor centres, Manhattan frame; None where they are unknown."""
    normals: Float[np.ndarray, "cells 3"] | None = None
    """Unit vectors across the planes, Manhattan frame, where some are oblique; else `axes` tells them."""

    def __post_init__(self) -> None:
        assert self.design.shape[1] > ROTATIONS, "a design has three rotation columns and the plane offsets"
        assert bool(np.all(self.counts > 0)), "an empty cell is no cell"

    @property
    def n_params(self) -> int:
        """Length of theta."""
        return self.design.shape[1]

    @property
    def seen(self) -> Bool[np.ndarray, " params"]:
        """Which parameters the cells say anything about: a plane without cells has none."""
        return np.any(self.design != 0.0, axis=0)

    @property
    def axes(self) -> Int[np.ndarray, " cells"]:
        """Axis 0, 1 or 2 that each cell's plane is perpendicular to; of oblique walls the nearer of x and y.

        Without normals read from the design: the rotation column is ``e_axis x q``, zero along `axis`.
        """
        if self.normals is not None:
            return np.argmax(np.abs(self.normals), axis=1)
        largest = np.zeros((int(self.plane.max(initial=0)) + 1, ROTATIONS))
        np.maximum.at(largest, self.plane, np.abs(self.design[:, :ROTATIONS]))
        return np.argmin(largest, axis=1)[self.plane]

    def along_wall(self, rows: Int[np.ndarray, " rows"]) -> Float[np.ndarray, "rows dims"]:
        """Places of one plane's cells about their middle, without what they are off across the wall."""
        places_m = self.centroids_m[rows] - self.centroids_m[rows].mean(axis=0)
        if self.normals is None:
            return np.delete(places_m, self.axes[rows[0]], axis=1)
        normal = self.normals[rows[0]]
        return places_m - np.outer(places_m @ normal, normal)


@dataclass(frozen=True)
class Contrasts:
    """Linear functions of theta: every dimension is the difference of two plane offsets."""

    matrix: Float[np.ndarray, "dims params"]
    """One row per dimension; offsets have no unit here, rotations count in metres per radian."""
    estimate: Float[np.ndarray, " params"]
    """theta at which the cells were linearised: rotation 0, plane offsets in metres."""

    @property
    def values_m(self) -> Float[np.ndarray, " dims"]:
        """The dimensions at the linearisation point, metres."""
        return self.matrix @ self.estimate
