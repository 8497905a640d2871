"""Which points a plane claims, and how robustly a patch summarises them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.fitting import AssociationConfig, associate
from indoorfit.fitting.patches import robust_location
from indoorfit.geometry import MAD_TO_STD, exposures
from indoorfit.simulate import Hole, room_shape
from synthetic import KINDS, virtual

PIXEL_M = 0.15


def patches_of(kind: str, seed: int = 0, **settings):
    scan = virtual(kind, seed, **settings)
    points_m = scan.frame.to_manhattan(scan.scan.points_m)
    return scan, points_m, associate(points_m, scan.shape, AssociationConfig(), PIXEL_M)


@pytest.mark.parametrize("kind", KINDS)
def test_planes_claim_nearly_all_their_points_and_no_others(kind):
    scan, _, patches = patches_of(kind, n_points=40_000)
    own = np.bincount(scan.point_plane, minlength=len(scan.shape.planes))
    # Left out are 5 cm along the edges (or a fifth of a narrow face on either side: 0.6 squared stay).
    assert np.all(patches.plane_points <= own)
    assert np.all(patches.plane_points >= 0.3 * own)
    # The spread about a plane is the noise; a MAD of n points is good to 1.17 / sqrt(n), four times that.
    error = np.abs(patches.plane_rms_m / 0.005 - 1.0)
    assert np.all(error < 4 * 1.17 / np.sqrt(patches.plane_points))


@pytest.mark.parametrize("kind", ["box", "U", "stair"])
def test_patch_locations_scatter_as_their_variances_say(kind):
    scan, _, patches = patches_of(kind, 1, n_points=60_000)
    axes = np.array([plane.axis for plane in scan.shape.planes])[patches.patches.plane]
    residuals = (
        patches.patches.means_m[np.arange(len(axes)), axes] - scan.shape.offsets_m[patches.patches.plane]
    )
    whitened = residuals / np.sqrt(patches.patches.variances_m2)
    # The mean square of n patches is 1 within 4 sqrt(2 / n), and a tenth for patches of few points.
    assert np.mean(whitened**2) == pytest.approx(1.0, abs=4 * np.sqrt(2 / len(whitened)) + 0.1)


def test_patches_lie_on_the_visible_part_of_their_plane():
    scan, _, patches = patches_of("X", 2, n_points=40_000)
    for exposure in exposures(scan.shape):
        means = patches.patches.means_m[patches.patches.plane == exposure.plane]
        assert len(means) > 0
        assert np.all(np.abs(means[:, exposure.axis] - scan.shape.planes[exposure.plane].offset_m) < 0.01)
        assert np.all(exposure.contains(means))


@pytest.mark.parametrize("kind", ["box", "T"])
def test_coverage_is_one_where_all_was_seen_and_less_behind_a_window(kind):
    scan, _, whole = patches_of(kind, 3, n_points=60_000)
    # Edges are left out and half pixels count: 15 %.
    assert whole.coverage.min() > 0.8
    assert whole.coverage.max() <= 1.0
    low, high = (-0.1, 0.5, 0.4), (0.1, 2.0, 2.4)
    plane = next(k for k, p in enumerate(scan.shape.planes) if p.axis == 0 and p.offset_m == 0.0)
    _, _, holed = patches_of(kind, 3, n_points=60_000, holes=(Hole(plane, low, high),))
    lost = 1.5 * 2.0 / exposures(scan.shape)[plane].area_m2
    assert holed.coverage[plane] == pytest.approx(whole.coverage[plane] - lost, abs=0.1)


def test_inferred_planes_claim_nothing():
    scan, points_m, _ = patches_of("box", 4, n_points=20_000)
    planes = list(scan.shape.planes)
    planes[2] = replace(planes[2], status="inferred")
    shape = replace(scan.shape, planes=tuple(planes))
    patches = associate(points_m, shape, AssociationConfig(), PIXEL_M)
    assert patches.plane_points[2] == 0
    assert 2 not in patches.patches.plane


def test_order_of_points_does_not_matter():
    scan, points_m, patches = patches_of("L", 5, n_points=20_000)
    order = np.random.default_rng(0).permutation(len(points_m))
    again = associate(points_m[order], scan.shape, AssociationConfig(), PIXEL_M)
    np.testing.assert_array_equal(again.patches.counts, patches.patches.counts)
    # Rounding: other order of sums.
    np.testing.assert_allclose(again.patches.means_m, patches.patches.means_m, atol=1e-12)
    np.testing.assert_allclose(again.patches.variances_m2, patches.patches.variances_m2, rtol=1e-9)


VALUES = st.lists(st.floats(-0.05, 0.05), min_size=5, max_size=60)


@given(values=VALUES, shift_m=st.floats(-1.0, 1.0))
def test_robust_location_moves_with_the_points_and_mirrors_with_them(values, shift_m):
    values = np.array(values)
    location, variance = robust_location(values)
    moved, moved_variance = robust_location(values + shift_m)
    mirrored, _ = robust_location(-values)
    # Rounding of numbers of order 1, raised by the weights' slope where the spread is the least allowed.
    assert moved - location == pytest.approx(shift_m, abs=1e-9)
    assert mirrored == pytest.approx(-location, abs=1e-9)
    assert values.min() - 1e-12 <= location <= values.max() + 1e-12
    assert variance > 0
    assert moved_variance > 0


def test_robust_location_is_nearly_as_good_as_the_mean_on_a_gaussian():
    draws = np.random.default_rng(6).normal(0, 0.005, (2000, 50))
    found = np.array([robust_location(row) for row in draws])
    # 95 % efficiency; the empirical variance of 2000 draws is known to 3 %.
    assert np.var(found[:, 0]) == pytest.approx(0.005**2 / 50 / 0.95, rel=0.12)
    assert np.mean(found[:, 1]) == pytest.approx(np.var(found[:, 0]), rel=0.15)


def test_robust_location_ignores_a_fifth_of_outliers():
    rng = np.random.default_rng(7)
    values = np.concatenate([rng.normal(0, 0.003, 400), np.full(100, 0.09)])
    location, _ = robust_location(values)
    # A median of 500 with a fifth on one side is off by 0.32 sigma; the biweight must not be worse.
    assert abs(location) < 0.32 * 0.003 + 4 * 0.003 / np.sqrt(400)


def test_scale_factor_of_the_median_deviation_is_that_of_a_gaussian():
    draws = np.random.default_rng(8).normal(size=200_000)
    # Statistical: 1.17 / sqrt(n) relative standard error.
    assert MAD_TO_STD * np.median(np.abs(draws)) == pytest.approx(1.0, abs=0.012)


def test_planes_far_from_everything_claim_nothing():
    shape = room_shape("box")
    patches = associate(np.full((100, 3), 50.0), shape, AssociationConfig(), PIXEL_M)
    assert len(patches.patches.plane) == 0
    np.testing.assert_array_equal(patches.coverage, 0.0)


def test_few_points_that_agree_by_chance_do_not_outweigh_the_plane():
    scan, points_m, _ = patches_of("box", 6, n_points=20_000)
    # Of one patch of the wall only five points are left, and they agree to a micrometre.
    exposure = next(e for e in exposures(scan.shape) if e.axis == 0)
    plane = scan.shape.planes[exposure.plane]
    near = np.abs(points_m[:, 0] - plane.offset_m) < 0.1
    corner = near & (points_m[:, 1] < points_m[:, 1].min() + 0.7) & (points_m[:, 2] < 0.7)
    few = np.flatnonzero(corner & (points_m[:, 1] > points_m[:, 1].min() + 0.1) & (points_m[:, 2] > 0.1))[:5]
    kept = ~corner
    kept[few] = True
    points_m = points_m.copy()
    points_m[few, 0] = plane.offset_m + 1e-6 * np.arange(5)
    found = associate(points_m[kept], scan.shape, AssociationConfig(), PIXEL_M).patches
    own = found.plane == exposure.plane
    spread_m = np.sqrt(found.variances_m2 * found.counts)[own]
    assert found.counts[own].min() < 10
    # Five points count as much as two degrees of freedom of the usual spread: more than a half of it.
    assert spread_m.min() > 0.5 * np.median(spread_m)
