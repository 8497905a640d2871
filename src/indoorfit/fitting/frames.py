"""Cells per frame, for scans that keep the frame of every point."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from indoorfit.model import Frame, Scan, Shape

from .association import AssociationConfig, associate_frames
from .motions import RigidMotions, corrections
from .patches import Patches
from .residuals import build_cells
from .sight import sight_of
from .uncertainty import Cells, PoseFieldConfig, pose_obstacle, rough_slips


def cells_by_frame(
    scan: Scan,
    frame: Frame,
    shape: Shape,
    config: AssociationConfig,
    pixel_m: float,
    pose: PoseFieldConfig,
) -> Cells | None:
    """Residuals per frame, plane and patch; None where the scan has no frame ids or no cell is large enough.

    Twice: a frame that is off by centimetres brings points of one wall to the place of another, and takes
    others out of its wall's reach. So the slips of a first fit are taken out before points choose their
    planes, and a plane then reaches no farther than it must: a window's pane is a few centimetres behind the
    wall, and in a scan that is off by as much only the frames' slips tell the two apart. What is summarised
    are the points as they were measured.

    Args:
        scan: with `frame_ids`, in the order in which the frames were taken.
        frame: fitted.
        shape: fitted.
        config: see `AssociationConfig`.
        pixel_m: resolution at which coverage is counted.
        pose: priors of the slips.
    """
    if scan.frame_ids is None:
        return None
    ids, index = np.unique(scan.frame_ids, return_inverse=True)
    sight = sight_of(scan, frame)
    centres_m = None if sight is None else sight.centres_m
    points_m = frame.to_manhattan(scan.points_m)
    data = associate_frames(points_m, index, shape, config, pixel_m, sight)
    patches = _square(data.patches, shape)
    if len(patches.plane) == 0:
        return None
    cells = build_cells(patches, shape, centres_m)
    if pose_obstacle(cells, pose) is not None:
        return cells
    try:
        slips, step = rough_slips(cells, pose)
    except np.linalg.LinAlgError:
        return cells  # `believe` meets the same equations and says so
    motions = corrections(slips, len(ids))
    # The planes' normals turned by the step, so in their own axes the points turn back.
    room = Rotation.from_rotvec(step[:3]).inv().as_matrix()
    motions = RigidMotions(room @ motions.rotations, motions.shifts_m @ room.T)
    data = associate_frames(
        motions.apply(points_m, index),
        index,
        shape.with_parameters(shape.parameters + step[3:]),
        replace(config, reach_m=config.frame_reach_m),
        pixel_m,
        None if sight is None else sight.moved(motions),
        points_m,
    )
    return build_cells(_square(data.patches, shape), shape, centres_m)


def _square(patches: Patches, shape: Shape) -> Patches:
    """Without the patches of oblique planes: the frames' slips are told by those of the three axes.

    What is known of the oblique planes stays what the cloud as a whole says.
    """
    kept = ~np.isin(patches.plane, shape.oblique)
    return Patches(
        plane=patches.plane[kept],
        means_m=patches.means_m[kept],
        variances_m2=patches.variances_m2[kept],
        counts=patches.counts[kept],
        frames=None if patches.frames is None else patches.frames[kept],
    )
