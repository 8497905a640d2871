"""Point clouds as they are read and as they are thinned."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int, UInt8

from .notes import Note


@dataclass(frozen=True)
class SensorFrame:
    """Where the sensor stood when it took one frame (or station) of the scan."""

    id: int
    position_m: Float[np.ndarray, " 3"]
    """Scan frame, metres."""
    rotation: Float[np.ndarray, "3 3"] | None = None
    """R_scan_sensor, or None where only the position is known."""


@dataclass(frozen=True)
class Scan:
    """A coloured point cloud in metres, in the coordinates of the input file.

    Coordinates are never shifted: float64 holds map coordinates of 1e6 m to 1e-10 m.
    """

    points_m: Float[np.ndarray, "points 3"]
    """Scan frame, metres, all finite."""
    colours: UInt8[np.ndarray, "points 3"] | None = None
    """Red, green, blue, 0 to 255; None where the file has none."""
    frame_ids: Int[np.ndarray, " points"] | None = None
    """The frame (station) that saw each point, or None."""
    frames: tuple[SensorFrame, ...] = ()
    """Known sensor poses, from a sidecar file or an E57 header."""
    name: str = "array"
    """Name of the source, for messages and provenance; never its full path."""
    sha256: str | None = None
    """Digest of the source file's bytes; None for arrays."""
    notes: tuple[Note, ...] = field(default=())
    """What the reader had to say: dropped points, missing colours, implausible units."""
    unit: str = "m"
    """Unit of the source's coordinates, from which the points were converted to metres."""

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.points_m)

    def sensors(self) -> tuple[tuple[SensorFrame, ...], Int[np.ndarray, " points"]] | None:
        """The sensor poses in the order of their ids, and which of them saw each point.

        None unless the scan tells the sensor's place of every point.
        """
        if self.frame_ids is None or self.n_points == 0:
            return None
        known = {sensor.id: sensor for sensor in self.frames}
        ids, index = np.unique(self.frame_ids, return_inverse=True)
        if not all(int(k) in known for k in ids):
            return None
        return tuple(known[int(k)] for k in ids), index


@dataclass(frozen=True)
class VoxelCloud:
    """The same cloud as centred second moments per voxel; exact for anything quadratic in the points.

    Coordinates are relative to `origin_m`, so that map offsets cost no digits.
    """

    origin_m: Float[np.ndarray, " 3"]
    """Scan frame: the cloud's centroid (thesis 4.2.2)."""
    voxel_m: float
    """Edge of a voxel."""
    counts: Int[np.ndarray, " voxels"]
    """Points per voxel, at least 1."""
    means_m: Float[np.ndarray, "voxels 3"]
    """Mean of the voxel's points, scan axes, relative to `origin_m`."""
    scatters_m2: Float[np.ndarray, "voxels 3 3"]
    """Sum over the voxel's points of (p - mean)(p - mean)^T."""
    point_voxel: Int[np.ndarray, " points"]
    """The voxel of each point of the scan: frame ids and colours stay reachable through it."""

    @property
    def n_voxels(self) -> int:
        """Number of occupied voxels."""
        return len(self.counts)
