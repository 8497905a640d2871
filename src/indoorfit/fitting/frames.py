"""Cells per frame, for scans that keep the frame of every point."""

import numpy as np
from jaxtyping import Float

from indoorfit.model import Frame, Scan, Shape

from .association import AssociationConfig, associate_frames
from .residuals import build_cells
from .uncertainty import Cells


def cells_by_frame(
    scan: Scan, frame: Frame, shape: Shape, config: AssociationConfig, pixel_m: float
) -> Cells | None:
    """Residuals per frame, plane and patch; None where the scan has no frame ids or no cell is large enough.

    Args:
        scan: with `frame_ids`, in the order in which the frames were taken.
        frame: fitted.
        shape: fitted.
        config: see `AssociationConfig`.
        pixel_m: resolution at which coverage is counted.
    """
    if scan.frame_ids is None:
        return None
    ids, index = np.unique(scan.frame_ids, return_inverse=True)
    data = associate_frames(frame.to_manhattan(scan.points_m), index, shape, config, pixel_m)
    if len(data.patches.plane) == 0:
        return None
    return build_cells(data.patches, shape, _centres(scan, frame, ids))


def _centres(scan: Scan, frame: Frame, ids: np.ndarray) -> Float[np.ndarray, "frames 3"] | None:
    """Sensor positions in the order of the ids; None unless all are known."""
    known = {sensor.id: sensor.position_m for sensor in scan.frames}
    if not all(int(k) in known for k in ids):
        return None
    return frame.to_manhattan(np.stack([known[int(k)] for k in ids]))
