"""Cells per frame as a linear mixed model: theta, one rigid slip per frame, one offset per wall patch.

``y = A theta + B_i u_i + Z g + e`` with u_i = (shift 3, rotation 3) of frame i about its pivot.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import sparse
from scipy.spatial.transform import Rotation

from .cells import ROTATIONS, Cells
from .location import ridge

SLIP = 6
"""Unknowns of a frame: shift in metres, then rotation in radians, Manhattan axes."""


@dataclass(frozen=True)
class PoseLayout:
    """What does not change when the model is linearised anew."""

    cells: Cells
    frame: Int[np.ndarray, " cells"]
    """Frame of each cell, counted 0, 1, ... among the frames that have cells."""
    frame_ids: Int[np.ndarray, " frames"]
    """Their indices in the scan, increasing; distances between them are the random walk's time."""
    pivots_m: Float[np.ndarray, "frames 3"]
    """Sensor centre where known, else the centroid of the frame's cells."""
    patch: Int[np.ndarray, " cells"]
    patches: tuple[Int[np.ndarray, " _"], ...]
    """For every plane the patches on it."""
    patch_distances_m: tuple[Float[np.ndarray, "_ _"], ...]
    shapes: Float[np.ndarray, "cells shapes"]
    """How much each wall's leaning and bowing moves each cell, see `_shapes`."""
    seen: Bool[np.ndarray, " params"]
    precision: Float[np.ndarray, " seen"]

    @property
    def n_patches(self) -> int:
        """Patches over all planes."""
        return sum(len(members) for members in self.patches)


@dataclass(frozen=True)
class PoseLinear:
    """The model at one linearisation point; theta and the slips count in full, not as steps."""

    columns: sparse.csr_matrix
    """cells x (theta, patches, shapes, target)."""
    slip_rows: Float[np.ndarray, "cells 6"]
    """B: d y / d u of the cell's own frame."""
    slip_matrix: sparse.csr_matrix
    """(6 frames) x cells, the same numbers."""


def build_layout(cells: Cells, patch_m: float) -> PoseLayout:
    """Sort out frames, pivots and wall patches."""
    assert cells.frames is not None, "the pose model needs a frame per cell"
    frame_ids, frame = np.unique(cells.frames, return_inverse=True)
    if cells.frame_centres_m is not None:
        pivots = cells.frame_centres_m[frame_ids]
    else:
        share = np.bincount(frame, cells.counts)
        sums = [np.bincount(frame, cells.counts * cells.centroids_m[:, k]) for k in range(3)]
        pivots = np.column_stack(sums) / share[:, None]
    steps = np.floor(cells.centroids_m / patch_m).astype(int)
    steps[np.arange(len(steps)), cells.axes] = 0
    keys, patch = np.unique(np.column_stack([cells.plane, steps]), axis=0, return_inverse=True)
    patch = patch.ravel()
    weight = np.bincount(patch, cells.counts)
    centres = np.column_stack([np.bincount(patch, cells.counts * cells.centroids_m[:, k]) for k in range(3)])
    centres /= weight[:, None]
    patches = tuple(np.flatnonzero(keys[:, 0] == plane) for plane in np.unique(keys[:, 0]))
    distances = tuple(np.linalg.norm(centres[m][:, None] - centres[m][None], axis=2) for m in patches)
    seen = cells.seen
    return PoseLayout(
        cells,
        frame,
        frame_ids,
        pivots,
        patch,
        patches,
        distances,
        _shapes(cells),
        seen,
        ridge(cells.n_params)[seen],
    )


def _shapes(cells: Cells) -> Float[np.ndarray, "cells shapes"]:
    """The largest shapes of every wall: out of plumb, skew and bowed either way; 1 at the ends of the wall.

    At the place of each cell: near the sensor cells are good to a tenth of a millimetre, and a wall that is
    out of plumb by a millimetre is not one height over a patch of a metre. Taken as such it would contradict
    itself, and the likelihood would give most of the leaning to the frames.
    """
    planes, axes = np.unique(cells.plane), cells.axes
    shapes = np.zeros((len(cells.plane), _SHAPES * len(planes)))
    for k, plane in enumerate(planes):
        own = cells.plane == plane
        places = np.delete(cells.centroids_m[own], axes[own][0], axis=1)
        places -= 0.5 * (places.max(axis=0) + places.min(axis=0))
        places /= max(float(np.abs(places).max()), _SHORTEST_LEAN_M)
        # The mean of a square over the wall is zero, so that bows move no mean plane.
        bows = places**2 - places.max(axis=0) ** 2 / 3.0
        shapes[own, _SHAPES * k : _SHAPES * (k + 1)] = np.hstack([places, bows])
    return shapes


_SHAPES = 4
"""Of each wall."""
_SHORTEST_LEAN_M = 1.0
"""Half of a wall's height: a narrow wall leans over its height."""


def linearise(
    layout: PoseLayout, step: Float[np.ndarray, " params"], slips: Float[np.ndarray, "frames 6"]
) -> PoseLinear:
    """The model around the given theta step and slips, by exact rotations.

    Each cell stands for one point, its centroid moved to the plane's residual. With slips of 20 mrad the
    second order is half a millimetre at 3 m, more than the pose model's own standard error.
    """
    cells = layout.cells
    axis, rows = cells.axes, np.arange(len(layout.frame))
    # Normal component from the residual and not from the centroid: the former is the robust location.
    offset = cells.centroids_m[rows, axis] - cells.residuals_m
    pivots = layout.pivots_m[layout.frame]
    slip = slips[layout.frame]
    turn, room = Rotation.from_rotvec(slip[:, SLIP // 2 :]), Rotation.from_rotvec(step[:ROTATIONS])
    arm = turn.inv().apply(cells.centroids_m - pivots - slip[:, : SLIP // 2])
    normals = room.as_matrix()[:, axis].T
    points = room.inv().apply(arm + pivots)
    theta = -cells.design.copy()
    theta[:, :ROTATIONS] = _along_rotation(-np.cross(np.eye(3)[axis], points), step[:ROTATIONS])
    lever = _along_rotation(np.cross(arm, normals), slip[:, SLIP // 2 :])
    slip_rows = np.hstack([turn.apply(normals), lever])
    # y such that y = A theta + B u holds in full at the linearisation point.
    residual = points[rows, axis] - offset
    target = residual + np.sum(slip_rows * slip, axis=1) + theta[:, :ROTATIONS] @ step[:ROTATIONS]
    patches = np.eye(layout.n_patches)[layout.patch]
    dense = np.hstack([theta[:, layout.seen], patches, layout.shapes, target[:, None]])
    index = SLIP * layout.frame[:, None] + np.arange(SLIP)
    shape = (SLIP * len(layout.frame_ids), len(rows))
    slip_matrix = sparse.csr_matrix((slip_rows.ravel(), (index.ravel(), np.repeat(rows, SLIP))), shape=shape)
    return PoseLinear(sparse.csr_matrix(dense), slip_rows, slip_matrix)


def _along_rotation(
    gradient: Float[np.ndarray, "rows 3"], rotvec: Float[np.ndarray, "#rows 3"] | Float[np.ndarray, " 3"]
) -> Float[np.ndarray, "rows 3"]:
    """Derivative by a small turn to derivative by the rotation vector: times the right Jacobian.

    To first order in the vector, ``J_r = I - [v]/2``: the next term is 1e-4 of a gradient at 30 mrad.
    """
    return gradient - 0.5 * np.cross(gradient, rotvec)
