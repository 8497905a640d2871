"""A local plane for every voxel, from the merged moments of its neighbourhood (thesis 3.2.2)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import KDTree

from indoorfit.errors import InputError
from indoorfit.model import Surfels, VoxelCloud


@dataclass(frozen=True)
class SurfelConfig:
    """How local planes are estimated."""

    neighbours: int = 24
    """Voxels merged into one plane. The thesis takes 7 points; voxels are a grid, where two full rings
    around the centre are 24, which keeps the normal of a 2.5 cm thick wall to some 3 degrees."""


_MIN_VOXELS = 60
"""Six faces need ten surfels each before a neighbourhood can tell a face from an edge."""


def surfels(cloud: VoxelCloud, config: SurfelConfig) -> Surfels:
    """Local planes of all voxels.

    Args:
        cloud: thinned scan.
        config: see `SurfelConfig`.

    Returns:
        positions in scan axes relative to the cloud's origin, normals of arbitrary sign.

    Raises:
        InputError: too few voxels, or all of them on one plane or line.
    """
    if cloud.n_voxels < _MIN_VOXELS:
        raise InputError(
            f"thin: the cloud fills {cloud.n_voxels} voxels of {100 * cloud.voxel_m:.1f} cm; "
            f"a room needs at least {_MIN_VOXELS}. Fix: scan more of the room, or check --unit."
        )
    _refuse_flat(cloud)
    k = min(config.neighbours, cloud.n_voxels)
    distances_m, nearest = KDTree(cloud.means_m).query(cloud.means_m, k=k)
    neighbours = np.asarray(nearest)
    variances_m2, normals = _merged_planes(cloud, neighbours)
    # Middle minus smallest spread, against the middle one: 1 on a plane, 0 on a line or in a ball.
    planarity = 1.0 - variances_m2[:, 0] / np.maximum(variances_m2[:, 1], 1e-12)
    spacing_m = float(np.median(distances_m[:, 1]))
    # k surfels fill a disc as large as the farthest of them is away.
    area_m2 = float(np.median(np.pi * distances_m[:, -1] ** 2 / k))
    roughness_m = np.sqrt(np.maximum(variances_m2[:, 0], 0.0))
    return Surfels(cloud.means_m, normals, roughness_m, planarity, neighbours, spacing_m, area_m2)


def _refuse_flat(cloud: VoxelCloud) -> None:
    spread_m = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(cloud.means_m.T)), 0.0))
    if spread_m[0] < 0.02 * spread_m[2]:
        raise InputError(
            f"thin: the points lie on one plane (they spread {spread_m[2]:.2f} x {spread_m[1]:.2f} x "
            f"{spread_m[0]:.3f} m); a room needs walls, floor and ceiling. Fix: scan more than one surface."
        )


def _merged_planes(
    cloud: VoxelCloud, neighbours: Int[np.ndarray, "voxels k"]
) -> tuple[Float[np.ndarray, "voxels 3"], Float[np.ndarray, "voxels 3"]]:
    """Eigenvalues (ascending, m²) and smallest eigenvector of each neighbourhood's covariance."""
    weights = cloud.counts[neighbours].astype(float)
    total = weights.sum(axis=1)
    members_m = cloud.means_m[neighbours]
    centres_m = np.einsum("nk,nkd->nd", weights, members_m) / total[:, None]
    offsets_m = members_m - centres_m[:, None]
    between = np.matmul((offsets_m * weights[:, :, None]).transpose(0, 2, 1), offsets_m)
    rows, cols = np.triu_indices(3)
    within = np.empty_like(between)
    for a, b in zip(rows, cols, strict=True):
        within[:, a, b] = within[:, b, a] = cloud.scatters_m2[:, a, b][neighbours].sum(axis=1)
    variances_m2, axes = np.linalg.eigh((between + within) / total[:, None, None])
    return variances_m2, axes[:, :, 0]
