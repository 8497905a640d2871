"""Local planes follow the surfaces, and clouds that are no room are refused."""

import numpy as np
import pytest

from indoorfit.errors import InputError
from indoorfit.model import Scan
from indoorfit.thin import SurfelConfig, ThinConfig, surfels, thin
from synthetic import virtual


def local_planes(points_m: np.ndarray, voxel_m: float | None = None):
    return surfels(thin(Scan(points_m), ThinConfig(voxel_m=voxel_m)), SurfelConfig())


def test_most_normals_of_a_box_are_those_of_its_walls():
    scan = virtual("box", n_points=40_000).scan
    found = local_planes(scan.points_m)
    # Unit length to rounding.
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0, atol=1e-12)
    along = np.abs(found.normals).max(axis=1)
    # 18 surfels 6 cm apart with 2.5 mm noise each: 1 degree; edges are a tenth of the surface.
    assert np.mean(along > np.cos(np.deg2rad(5.0))) > 0.85


def test_roughness_is_the_noise_and_planarity_is_high_on_walls():
    found = local_planes(virtual("box", n_points=40_000, sigma_m=0.008).scan.points_m)
    # The neighbourhood's smallest variance has lost 3 of 18 or more degrees of freedom: 15 %.
    assert np.median(found.roughness_m) == pytest.approx(0.008, rel=0.15)
    assert np.median(found.planarity) > 0.9


def test_surfels_stand_for_the_area_of_the_room():
    found = local_planes(virtual("box", n_points=40_000).scan.points_m)
    true_m2 = 2 * (5.0 * 4.0 + 5.0 * 2.7 + 4.0 * 2.7)
    # The voxel grid cuts walls into one or two layers; the area is an estimate to a third.
    assert len(found.positions_m) * found.area_m2 == pytest.approx(true_m2, rel=0.33)


def test_a_turned_cloud_has_turned_normals():
    points_m = virtual("box", n_points=20_000).scan.points_m
    # Swapping axes keeps the voxel grid, so all is equal but for rounding.
    swap = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    first, second = local_planes(points_m, 0.1), local_planes(points_m @ swap, 0.1)
    turned = first.positions_m @ swap
    a, b = np.lexsort(turned.T.round(9)), np.lexsort(second.positions_m.T.round(9))
    np.testing.assert_allclose(turned[a], second.positions_m[b], atol=1e-9)
    # Where the two smallest variances are nearly equal the normal is not defined.
    flat = first.planarity[a] > 0.5
    cosine = np.abs(np.sum((first.normals @ swap)[a] * second.normals[b], axis=1))[flat]
    assert np.quantile(cosine, 0.01) > 1 - 1e-9


@pytest.mark.parametrize(
    ("points_m", "said"),
    [
        (np.random.default_rng(0).uniform(0, 0.05, (500, 3)), "voxels"),
        (np.random.default_rng(0).uniform(0, 1, (5000, 3)) * (5.0, 4.0, 0.0), "one plane"),
        (np.random.default_rng(0).uniform(0, 1, (5000, 3)) * (5.0, 0.0, 0.0), "one plane"),
    ],
    ids=["speck", "plane", "line"],
)
def test_clouds_that_cannot_be_a_room_are_refused_with_a_remedy(points_m, said):
    with pytest.raises(InputError, match=said) as caught:
        local_planes(points_m, 0.02)
    assert "Fix:" in str(caught.value)
