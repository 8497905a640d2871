"""From a scan with sensor positions to lines of sight, few enough to be traced through the plan."""

import numpy as np
from jaxtyping import Float, Int

from indoorfit.model import Frame, Rays, Scan

_END_M = 0.10
"""Of the rays of one frame that end within a cube of this edge one is kept: they cross the same air."""
_MAX_RAYS = 60_000
"""More are thinned further. 100 frames keep 600 rays each, one for every 15 cm of what a frame sees; walls
are told apart at 10 cm, and dozens of frames look through every place."""


def rays_of(scan: Scan, frame: Frame) -> Rays | None:
    """A thinned choice of the lines of sight; None unless the scan tells the sensor's place of every point.

    Args:
        scan: with `frame_ids` and the positions of all those frames.
        frame: of the Manhattan axes.
    """
    sensors = scan.sensors()
    if sensors is None:
        return None
    known, index = sensors
    origins_m = frame.to_manhattan(np.stack([sensor.position_m for sensor in known]))
    return thinned(origins_m, index, frame.to_manhattan(scan.points_m))


def thinned(
    origins_m: Float[np.ndarray, "frames 3"],
    index: Int[np.ndarray, " points"],
    ends_m: Float[np.ndarray, "points 3"],
) -> Rays:
    """One ray per frame and cube of ends, the cubes as small as the number of rays allows.

    The shortest of each cube is kept: no other choice claims less free space, and it depends neither on
    the order of the points nor on that of the frames.

    Args:
        origins_m: of the frames.
        index: the frame of each point.
        ends_m: the points.
    """
    ranges_m = np.linalg.norm(ends_m - origins_m[index], axis=1)
    low_m = ends_m.min(axis=0)
    edge_m = _END_M
    while True:
        kept = _shortest(np.floor((ends_m - low_m) / edge_m).astype(np.int64), index, ranges_m)
        ends_m, index, ranges_m = ends_m[kept], index[kept], ranges_m[kept]
        if len(kept) <= _MAX_RAYS:
            return Rays(origins_m[index], ends_m)
        if np.all(ends_m - low_m < edge_m):
            # One ray of each frame is left, and there are more frames than that.
            some = np.linspace(0, len(kept) - 1, _MAX_RAYS).astype(int)
            return Rays(origins_m[index[some]], ends_m[some])
        # Cubes of twice the edge hold whole ones, so that nothing kept before is missed.
        edge_m *= 2.0


def _shortest(
    cube: Int[np.ndarray, "points 3"],
    index: Int[np.ndarray, " points"],
    ranges_m: Float[np.ndarray, " points"],
) -> Int[np.ndarray, " kept"]:
    """The point of least range of each pair of frame and cube."""
    _, n_y, n_z = (int(n) + 1 for n in cube.max(axis=0))
    key = ((index * (int(cube[:, 0].max()) + 1) + cube[:, 0]) * n_y + cube[:, 1]) * n_z + cube[:, 2]
    order = np.lexsort((ranges_m, key))
    first = np.append(True, key[order][1:] != key[order][:-1])
    return order[first]
