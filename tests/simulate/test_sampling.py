"""Drawn points lie where the truth says, as many and as noisy as asked."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.errors import ConfigError
from indoorfit.geometry import exposures
from indoorfit.simulate import Box, Hole, SamplingSettings, random_room, room_shape, sample_surface

TURNED = SamplingSettings(
    n_points=20_000, yaw_rad=0.4, tilt_rad=0.1, tilt_azimuth_rad=1.2, translation_m=(4.5e5, 5.3e6, 120.0)
)


def plane_distances_m(virtual, planes):
    """Signed distance, outward, of each point from its plane, Manhattan frame."""
    points_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    axes = np.array([p.axis for p in virtual.shape.planes])[planes]
    return points_m[np.arange(len(planes)), axes] - virtual.shape.offsets_m[planes]


@pytest.mark.parametrize("seed", range(3))
def test_points_lie_on_their_exposed_plane_without_noise(seed):
    shape = random_room(np.random.default_rng(seed), 12)
    virtual = sample_surface(shape, replace(TURNED, sigma_m=0.0), np.random.default_rng(seed))
    assert (virtual.point_plane >= 0).all()
    # 1e-8 m: map coordinates of 5e6 m carry 1e-9 m in float64.
    np.testing.assert_allclose(plane_distances_m(virtual, virtual.point_plane), 0.0, atol=1e-8)
    points_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    for exposure in exposures(shape):
        # A micrometre is room for the rounding of points drawn on the very edge.
        assert exposure.contains(points_m[virtual.point_plane == exposure.plane], -1e-6).all()


def test_points_are_shared_out_by_area():
    shape = room_shape("X")
    n = 100_000
    virtual = sample_surface(shape, SamplingSettings(n_points=n), np.random.default_rng(0))
    areas_m2 = np.array([e.area_m2 for e in exposures(shape)])
    expected = n * areas_m2 / areas_m2.sum()
    counts = np.bincount(virtual.point_plane, minlength=len(areas_m2))
    # Multinomial counts: five standard errors over 14 planes.
    assert (np.abs(counts - expected) < 5.0 * np.sqrt(expected)).all()


@pytest.mark.parametrize("noise", ["normal", "isotropic"])
def test_noise_has_the_sigma_asked_for(noise):
    settings = SamplingSettings(n_points=50_000, sigma_m=0.005, noise=noise)
    virtual = sample_surface(room_shape("L"), settings, np.random.default_rng(1))
    residuals_m = plane_distances_m(virtual, virtual.point_plane)
    # Standard error of a standard deviation: sigma / sqrt(2 n); five of them.
    assert residuals_m.std() == pytest.approx(0.005, rel=5.0 / np.sqrt(2 * 50_000))


def test_kinect_noise_grows_with_the_square_of_the_distance():
    shape = room_shape("box", length_m=8.0, width_m=8.0)
    sensor_m = (4.0, 4.0, 1.3)
    settings = SamplingSettings(n_points=200_000, noise="kinect", sensor_m=sensor_m)
    noisy, exact = (
        sample_surface(shape, s, np.random.default_rng(2)).scan.points_m
        for s in (settings, replace(settings, noise="normal", sigma_m=0.0))
    )
    # The `normal` noise draws as many numbers, so that the same points come in another order only by noise.
    shift_m = np.linalg.norm(noisy - exact, axis=1)
    distance_m = np.linalg.norm(exact - sensor_m, axis=1)
    for at_m in (2.0, 3.0, 4.0, 5.0):
        near = np.abs(distance_m - at_m) < 0.05
        rms_m = np.sqrt(np.mean(shift_m[near] ** 2))
        # 5 %: a band of 10 cm changes the law by 2.5 % at 2 m, some thousand points give 2 %.
        assert rms_m == pytest.approx(0.04 * (at_m / 5.0) ** 2, rel=0.05)


def test_same_seed_gives_the_same_bytes():
    settings = replace(TURNED, n_furniture=3, n_windows=1, outlier_share=0.02)
    first, second = (sample_surface(room_shape("U"), settings, np.random.default_rng(7)) for _ in range(2))
    assert first.scan.points_m.tobytes() == second.scan.points_m.tobytes()
    assert first.scan.colours.tobytes() == second.scan.colours.tobytes()
    assert first.point_plane.tobytes() == second.point_plane.tobytes()


def test_holes_and_missing_planes_have_no_points():
    shape = room_shape("box")
    hole = Hole(0, (0.0, 1.0, 0.8), (0.0, 2.0, 1.9))
    wall = next(k for k, p in enumerate(shape.planes) if p.axis == 0)
    hole = replace(hole, plane=wall)
    gone = next(k for k, p in enumerate(shape.planes) if p.axis == 1)
    settings = SamplingSettings(n_points=20_000, sigma_m=0.0, holes=(hole,), missing_planes=(gone,))
    virtual = sample_surface(shape, settings, np.random.default_rng(0))
    assert virtual.scan.n_points == 20_000
    assert not (virtual.point_plane == gone).any()
    on_wall = virtual.frame.to_manhattan(virtual.scan.points_m)[virtual.point_plane == wall]
    in_hole = ((on_wall > hole.low_m) & (on_wall < hole.high_m))[:, 1:].all(axis=1)
    assert len(on_wall) > 0
    assert not in_hole.any()


def test_hidden_furniture_leaves_a_gap_and_its_back_is_not_seen():
    shape = room_shape("box")
    shelf = Box((0.0, 1.0, 0.0), (0.4, 3.0, 2.0))
    settings = SamplingSettings(n_points=20_000, sigma_m=0.0, furniture=(shelf,), furniture_hides=True)
    virtual = sample_surface(shape, settings, np.random.default_rng(0))
    points_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    on_back = (points_m[:, 0] < 0.2) & shelf.contains(points_m, -0.01)
    assert not on_back.any()
    on_shelf = virtual.point_plane == -1
    assert on_shelf.sum() > 1000
    assert shelf.contains(points_m[on_shelf], 1e-9).all()
    # Neither the side at the wall nor the one on the floor is surface.
    assert points_m[on_shelf, 0].min() > 0.0
    assert points_m[on_shelf, 2].min() > 0.0


def test_random_furniture_stands_inside_the_room_on_the_floor():
    for seed in range(10):
        shape = random_room(np.random.default_rng(seed), 8)
        settings = SamplingSettings(n_points=5_000, sigma_m=0.0, n_furniture=3)
        virtual = sample_surface(shape, settings, np.random.default_rng(seed))
        on_box = virtual.scan.points_m[virtual.point_plane == -1]
        low_m, high_m = shape.bounds_m()["cube-0"]
        assert ((on_box >= low_m - 1e-9) & (on_box <= high_m + 1e-9)).all()


def test_outliers_have_the_share_asked_for_and_no_plane():
    settings = SamplingSettings(n_points=10_000, outlier_share=0.02)
    virtual = sample_surface(room_shape("L"), settings, np.random.default_rng(0))
    assert (virtual.point_plane == -1).sum() == 200


def test_tilt_is_the_angle_between_the_verticals():
    virtual = sample_surface(room_shape("box"), TURNED, np.random.default_rng(0))
    up_scan = virtual.frame.directions_to_scan(np.array([0.0, 0.0, 1.0]))
    assert np.arccos(up_scan[2]) == pytest.approx(TURNED.tilt_rad, abs=1e-9)
    R = virtual.frame.R_manhattan_scan
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    "bad",
    [
        {"n_points": 0},
        {"sigma_m": -1.0},
        {"outlier_share": 1.0},
        {"missing_planes": (99,)},
        {"missing_planes": (0, 1, 2, 3, 4, 5)},
    ],
    ids=["no-points", "negative-noise", "all-outliers", "no-such-plane", "nothing-left"],
)
def test_impossible_settings_are_refused_with_a_remedy(bad):
    with pytest.raises(ConfigError, match="Fix:"):
        sample_surface(room_shape("box"), SamplingSettings(**bad), np.random.default_rng(0))
