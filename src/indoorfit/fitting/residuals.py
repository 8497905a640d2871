"""Residuals of patches and their derivatives with respect to rotation and plane offsets."""

import numpy as np
from jaxtyping import Float

from indoorfit.model import Shape

from .patches import Patches
from .uncertainty import Cells
from .yaws import tells_yaw


def build_cells(
    patches: Patches, shape: Shape, frame_centres_m: Float[np.ndarray, "frames 3"] | None = None
) -> Cells:
    """Patches as residuals and their derivatives at the shape's present planes.

    Args:
        patches: Manhattan frame.
        shape: with the planes' present offsets.
        frame_centres_m: sensor positions, Manhattan frame, where known.
    """
    normals = np.array([plane.normal for plane in shape.planes])[patches.plane]
    n = len(patches.plane)
    design = np.zeros((n, 3 + len(shape.parameters)))
    design[:, :3] = np.cross(normals, patches.means_m)
    design[np.arange(n), 3 + patches.plane] = -1.0
    for k in shape.oblique:
        own = np.flatnonzero(patches.plane == k)
        along_m = patches.means_m[own] @ shape.planes[k].turn_normal
        if tells_yaw(along_m):
            design[own, 3 + shape.yaw_parameter(k)] = along_m
    return Cells(
        plane=patches.plane,
        design=design,
        centroids_m=patches.means_m,
        residuals_m=np.sum(normals * patches.means_m, axis=1) - shape.offsets_m[patches.plane],
        variances_m2=patches.variances_m2,
        counts=patches.counts,
        frames=patches.frames,
        frame_centres_m=frame_centres_m,
        normals=normals if shape.oblique else None,
    )


_GUESSED_YAW_RAD = 0.2
"""Standard uncertainty of a yaw that the patches do not tell: some 10 degrees, as discovery needs to tell an
oblique wall from the others."""


def with_inferred(cells: Cells, shape: Shape, inferred_std_m: float) -> Cells:
    """Add one cell for every parameter that no point fixed: what discovery knows of it, and how well.

    An inferred wall stands where floor and ceiling end, or in the middle of a shadow, in which case it has a
    doubt of its own; that is one observation of its position.

    Args:
        cells: of the observed planes.
        shape: with the planes' status.
        inferred_std_m: standard uncertainty of an inferred position, metres.
    """
    silent = np.setdiff1d(np.arange(len(shape.planes)), cells.plane)
    turns = np.array([k for k in shape.oblique if not cells.seen[3 + shape.yaw_parameter(k)]], int)
    n = len(silent) + len(turns)
    design = np.zeros((n, cells.n_params))
    design[np.arange(len(silent)), 3 + silent] = -1.0
    for row, k in enumerate(turns.tolist(), start=len(silent)):
        design[row, 3 + shape.yaw_parameter(k)] = inferred_std_m / _GUESSED_YAW_RAD
    std_m = np.hypot(inferred_std_m, [shape.planes[k].doubt_m for k in silent] + [0.0] * len(turns))
    silent = np.concatenate([silent, turns])
    normals = np.array([plane.normal for plane in shape.planes])
    return Cells(
        plane=np.concatenate([cells.plane, silent]),
        design=np.concatenate([cells.design, design]),
        centroids_m=np.concatenate([cells.centroids_m, np.zeros((n, 3))]),
        residuals_m=np.concatenate([cells.residuals_m, np.zeros(n)]),
        variances_m2=np.concatenate([cells.variances_m2, std_m**2]),
        counts=np.concatenate([cells.counts, np.ones(n, int)]),
        normals=None if cells.normals is None else np.concatenate([cells.normals, normals[silent]]),
    )
