"""Residuals of patches and their derivatives with respect to rotation and plane offsets."""

import numpy as np
from jaxtyping import Float

from indoorfit.model import Shape

from .patches import Patches
from .uncertainty import Cells


def build_cells(
    patches: Patches, shape: Shape, frame_centres_m: Float[np.ndarray, "frames 3"] | None = None
) -> Cells:
    """Patches as residuals and their derivatives at the shape's present planes.

    Args:
        patches: Manhattan frame.
        shape: with the planes' present offsets.
        frame_centres_m: sensor positions, Manhattan frame, where known.
    """
    axes = np.array([plane.axis for plane in shape.planes])[patches.plane]
    n = len(patches.plane)
    design = np.zeros((n, 3 + len(shape.planes)))
    design[:, :3] = np.cross(np.eye(3)[axes], patches.means_m)
    design[np.arange(n), 3 + patches.plane] = -1.0
    return Cells(
        plane=patches.plane,
        design=design,
        centroids_m=patches.means_m,
        residuals_m=patches.means_m[np.arange(n), axes] - shape.offsets_m[patches.plane],
        variances_m2=patches.variances_m2,
        counts=patches.counts,
        frames=patches.frames,
        frame_centres_m=frame_centres_m,
    )


def with_inferred(cells: Cells, shape: Shape, inferred_std_m: float) -> Cells:
    """Add one cell for every plane that no point fixed: what discovery knows of it, and how well.

    An inferred wall stands where floor and ceiling end; that is one observation of its position.

    Args:
        cells: of the observed planes.
        shape: with the planes' status.
        inferred_std_m: standard uncertainty of an inferred position, metres.
    """
    silent = np.setdiff1d(np.arange(len(shape.planes)), cells.plane)
    n = len(silent)
    design = np.zeros((n, cells.n_params))
    design[np.arange(n), 3 + silent] = -1.0
    return Cells(
        plane=np.concatenate([cells.plane, silent]),
        design=np.concatenate([cells.design, design]),
        centroids_m=np.concatenate([cells.centroids_m, np.zeros((n, 3))]),
        residuals_m=np.concatenate([cells.residuals_m, np.zeros(n)]),
        variances_m2=np.concatenate([cells.variances_m2, np.full(n, inferred_std_m**2)]),
        counts=np.concatenate([cells.counts, np.ones(n, int)]),
    )
