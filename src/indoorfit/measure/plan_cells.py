"""A room from above: which floor and which ceiling lies over each cell of its plan."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from indoorfit.errors import InputError
from indoorfit.model import Polygon, Shape

NOT_ENCLOSED = (
    "measure: the walls that were fitted do not enclose a room: two of them have passed each other, as "
    "happens where a step is narrower than the scan is good, where walls are curved, or where oblique "
    "ones do more than cut a corner off. Fix: scan the step more closely, or raise "
    "discover.candidates.min_area_m2 so that it is left out; crop off what is curved or slanting."
)


@dataclass(frozen=True)
class PlanCells:
    """The plan on the grid of all corners of floors and ceilings, Manhattan frame."""

    x_m: Float[np.ndarray, " nx1"]
    y_m: Float[np.ndarray, " ny1"]
    floor: Int[np.ndarray, "nx ny"]
    """Index of the piece that is the floor of each cell, -1 outside the room."""
    ceiling: Int[np.ndarray, "nx ny"]
    """The same of the ceiling."""

    def widest(self, cells: np.ndarray) -> Float[np.ndarray, " 2"]:
        """The middle of the cell, of those in the (nx, ny) mask, whose shorter side is longest."""
        sides_m = np.minimum(np.diff(self.x_m)[:, None], np.diff(self.y_m)[None, :])
        i, j = np.unravel_index(np.argmax(np.where(cells, sides_m, -1.0)), cells.shape)
        return np.array([self.x_m[i] + self.x_m[i + 1], self.y_m[j] + self.y_m[j + 1]]) / 2.0

    def border(self, cells: np.ndarray, others: np.ndarray) -> Float[np.ndarray, " 2"] | None:
        """The middle of the longest cell side between two (nx, ny) masks; None where they do not meet."""
        found = []
        for axis, lines_m, along_m in ((0, self.x_m, self.y_m), (1, self.y_m, self.x_m)):
            a, b = (np.moveaxis(mask, axis, 0) for mask in (cells, others))
            for i, j in np.argwhere((a[1:] & b[:-1]) | (b[1:] & a[:-1])).tolist():
                place = [lines_m[i + 1], 0.5 * (along_m[j] + along_m[j + 1])]
                found.append((along_m[j + 1] - along_m[j], place if axis == 0 else place[::-1]))
        if not found:
            return None
        # The first of several as long.
        return np.array(max(found, key=lambda side: side[0])[1])


def plan_cells(shape: Shape, pieces: Sequence[Polygon]) -> PlanCells:
    """Look down on the level pieces of one room.

    Args:
        shape: the grammar.
        pieces: the polygons of one room.

    Raises:
        InputError: no floor or no ceiling is left of it.
    """
    level = [(k, piece) for k, piece in enumerate(pieces) if shape.planes[piece.plane].axis == 2]
    if {shape.planes[piece.plane].outward for _, piece in level} != {-1, 1}:
        raise InputError(NOT_ENCLOSED)
    corners_m = np.concatenate([ring for _, piece in level for ring in piece.rings_m])
    # Pieces come from one mesh: corners in one place have equal numbers.
    x_m, y_m = np.unique(corners_m[:, 0]), np.unique(corners_m[:, 1])
    maps = {-1: np.full((len(x_m) - 1, len(y_m) - 1), -1), 1: np.full((len(x_m) - 1, len(y_m) - 1), -1)}
    for k, piece in level:
        maps[shape.planes[piece.plane].outward][_covered(piece, x_m, y_m)] = k
    return PlanCells(x_m, y_m, maps[-1], maps[1])


def _covered(piece: Polygon, x_m: Float[np.ndarray, " nx1"], y_m: Float[np.ndarray, " ny1"]) -> np.ndarray:
    """Even-odd rule over all rings, for the middles of the cells."""
    x, y = 0.5 * (x_m[1:] + x_m[:-1]), 0.5 * (y_m[1:] + y_m[:-1])
    inside = np.zeros((len(x), len(y)), bool)
    for ring in piece.rings_m:
        following = np.roll(ring, -1, axis=0)
        for (x0, y0, _), (x1, y1, _) in zip(ring, following, strict=True):
            if y0 != y1:
                low, high = sorted((y0, y1))
                # Where the side is crossed on the way along x; sides along y, nearly all, in one place.
                at = np.full(len(y), x0) if x0 == x1 else x0 + (y - y0) / (y1 - y0) * (x1 - x0)
                inside ^= (x[:, None] < at[None, :]) & ((y > low) & (y < high))[None, :]
    return inside
