"""Thinning loses no moment: what is quadratic in the points is the same for the voxels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.model import Scan
from indoorfit.thin import ThinConfig, thin


def cloud_of(n: int, seed: int, offset_m=(0.0, 0.0, 0.0)) -> Scan:
    rng = np.random.default_rng(seed)
    return Scan(rng.uniform(0, (5.0, 4.0, 2.7), (n, 3)) + np.array(offset_m))


@given(n=st.integers(1, 400), seed=st.integers(0, 10_000), voxel_m=st.floats(0.02, 3.0))
def test_moments_of_all_voxels_add_up_to_those_of_the_points(n, seed, voxel_m):
    scan = cloud_of(n, seed)
    voxels = thin(scan, ThinConfig(voxel_m=voxel_m))
    local_m = scan.points_m - voxels.origin_m
    assert voxels.counts.sum() == n
    # Rounding: sums of 400 numbers of order 25.
    np.testing.assert_allclose(voxels.counts @ voxels.means_m, local_m.sum(axis=0), atol=1e-10)
    between = np.einsum("v,vi,vj->ij", voxels.counts, voxels.means_m, voxels.means_m)
    np.testing.assert_allclose(voxels.scatters_m2.sum(axis=0) + between, local_m.T @ local_m, atol=1e-9)


@given(n=st.integers(2, 300), seed=st.integers(0, 10_000), voxel_m=st.floats(0.05, 2.0))
def test_each_voxel_summarises_exactly_its_own_points(n, seed, voxel_m):
    scan = cloud_of(n, seed)
    voxels = thin(scan, ThinConfig(voxel_m=voxel_m))
    local_m = scan.points_m - voxels.origin_m
    for k in range(min(voxels.n_voxels, 20)):
        members = local_m[voxels.point_voxel == k]
        assert len(members) == voxels.counts[k] >= 1
        # No member is farther from another than the voxel is wide.
        assert np.all(np.ptp(members, axis=0) <= voxel_m)
        # Rounding.
        np.testing.assert_allclose(voxels.means_m[k], members.mean(axis=0), atol=1e-12)
        centred = members - members.mean(axis=0)
        np.testing.assert_allclose(voxels.scatters_m2[k], centred.T @ centred, atol=1e-12)


def test_points_of_one_voxel_are_never_split():
    scan = cloud_of(3000, 1)
    voxels = thin(scan, ThinConfig(voxel_m=0.5))
    grid = np.floor((scan.points_m - voxels.origin_m) / 0.5).astype(int)
    pairs = {(*cell, v) for cell, v in zip(map(tuple, grid), voxels.point_voxel, strict=True)}
    assert len(pairs) == voxels.n_voxels == len(np.unique(grid, axis=0))


def test_order_of_the_points_does_not_matter():
    scan = cloud_of(2000, 2)
    order = np.random.default_rng(0).permutation(2000)
    first = thin(scan, ThinConfig(voxel_m=0.3))
    second = thin(Scan(scan.points_m[order]), ThinConfig(voxel_m=0.3))
    np.testing.assert_array_equal(first.counts, second.counts)
    np.testing.assert_array_equal(first.point_voxel[order], second.point_voxel)
    # Rounding: other order of the sums.
    np.testing.assert_allclose(first.means_m, second.means_m, atol=1e-12)


@pytest.mark.parametrize("offset_m", [(0.0, 0.0, 0.0), (3.5e6, 5.8e6, 400.0)], ids=["local", "map"])
def test_default_size_keeps_to_the_target(offset_m):
    voxels = thin(cloud_of(60_000, 3, offset_m), ThinConfig(target_voxels=5_000))
    # The size is judged on a third of the points here, which misses some voxels: 15 % (random filling of
    # a volume; a surface, where voxels hold more points, misses fewer).
    assert 1_000 < voxels.n_voxels < 1.15 * 5_000


def test_sparse_and_dense_grids_give_the_same_voxels():
    """Both ways of numbering voxels, by table and by sorting, mean the same."""
    scan = cloud_of(500, 4)
    near = thin(scan, ThinConfig(voxel_m=0.4))
    # One point 3 km away makes the grid far too large for a table.
    far = thin(Scan(np.vstack([scan.points_m, [3000.0, 3000.0, 3000.0]])), ThinConfig(voxel_m=0.4))
    assert far.counts.sum() == 501
    assert far.counts[far.point_voxel[-1]] == 1
    assert abs(far.n_voxels - near.n_voxels - 1) < 0.2 * near.n_voxels


def test_map_offsets_cost_no_digits():
    offset_m = np.array([3.5e6, 5.8e6, 400.0])
    # Coordinates on a binary grid (2^-20 m), so that adding the offset is exact and only thinning can err.
    points_m = np.round(cloud_of(2000, 5).points_m * 2**20) / 2**20
    near, far = (thin(Scan(points_m + shift), ThinConfig(voxel_m=0.3)) for shift in (0.0, offset_m))
    assert far.n_voxels == near.n_voxels
    # Where the origin lies is free; the voxels' places are not. Coordinates of 5.8e6 m have a step of 1e-9 m.
    there = far.means_m + (far.origin_m - offset_m)
    np.testing.assert_allclose(there, near.means_m + near.origin_m, rtol=0, atol=2e-9)
    np.testing.assert_allclose(far.scatters_m2, near.scatters_m2, rtol=0, atol=1e-9)
