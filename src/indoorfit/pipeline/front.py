"""The stages before any decision on the plan: from points to classified surfaces."""

import logging
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Int

from indoorfit.classify import classify
from indoorfit.config import RunConfig
from indoorfit.model import FaceClass, Frame, Note, Scan, Segments, Surfels
from indoorfit.orient import orient
from indoorfit.segment import grow_surfaces
from indoorfit.thin import surfels, thin

from .provenance import Stopwatch

log = logging.getLogger("indoorfit")


@dataclass(frozen=True)
class FrontEnd:
    """Classified surfaces of a scan."""

    frame: Frame
    surfels: Surfels
    """Manhattan frame."""
    point_surfel: Int[np.ndarray, " points"]
    """The surfel of each point of the scan."""
    segments: Segments
    classes: tuple[FaceClass | None, ...]
    """Of the segments."""
    notes: tuple[Note, ...]


def front_end(scan: Scan, config: RunConfig, rng: np.random.Generator, watch: Stopwatch) -> FrontEnd:
    """Thin, orient, segment and classify.

    Args:
        scan: without the points that are to be ignored.
        config: settings of the four stages.
        rng: for orientation.
        watch: gets the seconds of each stage.

    Raises:
        InputError: the cloud cannot be a room.
    """
    with watch.stage("thin"):
        voxels = thin(scan, config.thin)
        local = surfels(voxels, config.surfels)
    log.info("thin: %d points in %d voxels of %.1f cm", scan.n_points, voxels.n_voxels, 100 * voxels.voxel_m)
    with watch.stage("orient"):
        yaw_deg = config.overrides.yaw_deg
        yaw_rad = None if yaw_deg is None else float(np.deg2rad(yaw_deg))
        frame, notes = orient(local, voxels.origin_m, config.orient, rng, yaw_rad)
        local = _turned(local, frame)
    with watch.stage("segment"):
        segments = grow_surfaces(local, config.segment)
        classes = classify(segments, config.classify)
    log.info("segment: %d surfaces", segments.n_segments)
    return FrontEnd(frame, local, voxels.point_voxel, segments, classes, notes)


def _turned(local: Surfels, frame: Frame) -> Surfels:
    """Surfels from the scan's axes to the Manhattan frame."""
    rotation = frame.R_manhattan_scan.T
    return replace(local, positions_m=local.positions_m @ rotation, normals=local.normals @ rotation)
