"""The empty raster on a face: where its pixels lie, and which of them are on the polygon."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.model import Face, Frame


@dataclass(frozen=True)
class Canvas:
    """A raster of square pixels that covers a face, seen from inside the room, upper edge first."""

    face: Face
    origin_m: Float[np.ndarray, " 3"]
    """Scan frame: the outer corner of row 0, column 0."""
    right: Float[np.ndarray, " 3"]
    down: Float[np.ndarray, " 3"]
    """Scan frame, unit length; ``right x down`` points out of the room."""
    rings_m: tuple[Float[np.ndarray, "_ 2"], ...]
    """The face's rings along `right` and `down` from the origin."""
    pixel_m: float
    rows: int
    columns: int

    def coordinates_m(
        self, points_m: Float[np.ndarray, "n 3"], base_m: Float[np.ndarray, " 3"]
    ) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
        """Distances to the right of and below the origin, of points relative to `base_m`."""
        offset_m = self.origin_m - base_m
        return points_m @ self.right - offset_m @ self.right, points_m @ self.down - offset_m @ self.down

    def centres_m(self) -> tuple[Float[np.ndarray, " columns"], Float[np.ndarray, " rows"]]:
        """Coordinates of the pixel centres along `right` and along `down`."""
        return (np.arange(self.columns) + 0.5) * self.pixel_m, (np.arange(self.rows) + 0.5) * self.pixel_m

    def positions_m(self, pixels: Bool[np.ndarray, "rows columns"]) -> Float[np.ndarray, "n 3"]:
        """Scan coordinates of the chosen pixels' centres, row by row."""
        row, column = np.nonzero(pixels)
        x_m, y_m = self.centres_m()
        return self.origin_m + x_m[column, None] * self.right + y_m[row, None] * self.down

    def mask(self) -> Bool[np.ndarray, "rows columns"]:
        """The pixels whose centre lies on the face."""
        x_m, y_m = self.centres_m()
        return inside(self.rings_m, np.broadcast_to(x_m, (self.rows, self.columns)), y_m[:, None])


def canvas_of(face: Face, frame: Frame, pixel_m: float, max_side: int) -> Canvas:
    """Lay a raster on a face.

    Walls stand upright; floors are seen as a plan is drawn (y up, x to the right), ceilings with x to the
    right and y downward, as one who lies on the floor with the feet towards y sees them.

    Args:
        face: what to cover.
        frame: its Manhattan frame; tells up.
        pixel_m: wanted side of a pixel.
        max_side: pixels along the longer side at most; the pixels grow where the face needs more.
    """
    _, y, z = frame.R_manhattan_scan
    out = -face.normal
    steep = abs(float(out @ z))
    down = -z if steep < 0.5 else (y if out @ z > 0.0 else -y)
    # An oblique or sloping face: the direction within its plane that is nearest to the wanted one.
    down = down - (down @ out) * out
    down = down / np.linalg.norm(down)
    right = np.cross(down, out)
    first_m = face.rings_m[0][0]
    axes = np.stack([right, down], axis=1)
    flat = [(ring - first_m) @ axes for ring in face.rings_m]
    low, high = flat[0].min(axis=0), flat[0].max(axis=0)
    size_m = high - low
    pixel_m = max(pixel_m, float(size_m.max()) / max_side)
    # A millionth of a pixel forgives the rounding of sizes that are whole numbers of pixels.
    columns, rows = np.maximum(np.ceil(size_m / pixel_m - 1e-6).astype(int), 1).tolist()
    origin_m = first_m + axes @ low
    return Canvas(face, origin_m, right, down, tuple(ring - low for ring in flat), pixel_m, rows, columns)


def inside(
    rings_m: tuple[Float[np.ndarray, "_ 2"], ...],
    x_m: Float[np.ndarray, "..."],
    y_m: Float[np.ndarray, "..."],
) -> Bool[np.ndarray, "..."]:
    """Which places lie in a polygon with holes: an odd number of edges to the right (Jordan)."""
    odd = np.zeros(np.broadcast_shapes(x_m.shape, y_m.shape), bool)
    for ring in rings_m:
        for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            if ay == by:
                continue
            between = (y_m < ay) != (y_m < by)
            odd ^= between & (x_m < ax + (y_m - ay) * ((bx - ax) / (by - ay)))
    return odd
