"""The joint fit as a whole: one optimum, the truth within its noise, and honest about not converging."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from indoorfit.errors import InputError
from indoorfit.fitting import AssociationConfig, BeliefConfig, JointConfig, believe, fit_joint, joint
from indoorfit.model import Frame, Scan
from synthetic import KINDS, expected_limit_m, is_rotation, virtual

PIXEL_M = 0.15


def turned(frame: Frame, degrees: float, axis=(1.0, -1.0, 1.0)) -> Frame:
    vector = np.deg2rad(degrees) * np.array(axis) / np.linalg.norm(axis)
    return Frame(Rotation.from_rotvec(vector).as_matrix() @ frame.R_manhattan_scan, frame.origin_scan_m)


@pytest.mark.parametrize("kind", KINDS)
def test_truth_is_found_from_a_perturbed_start(kind):
    scan = virtual(kind, 1, n_points=40_000, yaw_deg=17, tilt_deg=4)
    start = scan.shape.with_offsets(
        scan.shape.offsets_m + np.random.default_rng(1).uniform(-0.03, 0.03, len(scan.shape.planes))
    )
    fit = fit_joint(scan.scan, turned(scan.frame, 0.3), start, JointConfig(), PIXEL_M)
    assert fit.converged
    assert is_rotation(fit.frame.R_manhattan_scan)
    # Offsets are taken about the frame's origin, which lies in a corner 7 m from the far walls: compare
    # differences of parallel planes, which no turn about it changes.
    axes = np.array([plane.axis for plane in scan.shape.planes])
    for axis in range(3):
        error_m = (fit.shape.offsets_m - scan.shape.offsets_m)[axes == axis]
        assert np.ptp(error_m) < expected_limit_m(scan, 0.005)


@pytest.mark.parametrize("kind", ["box", "U", "stair"])
def test_every_start_ends_at_the_same_optimum(kind):
    scan = virtual(kind, 2, n_points=30_000)
    rng = np.random.default_rng(2)
    fits = []
    for degrees in (0.0, 0.2, -0.4):
        shift_m = rng.uniform(-0.03, 0.03, len(scan.shape.planes)) * (degrees != 0.0)
        start = scan.shape.with_offsets(scan.shape.offsets_m + shift_m)
        fits.append(fit_joint(scan.scan, turned(scan.frame, degrees), start, JointConfig(), PIXEL_M))
    assert all(fit.converged for fit in fits)
    for fit in fits[1:]:
        # Patches change their points with the start, and rounds end when nothing moves by `settle` x reach,
        # 1 mm; a step shrinks at least tenfold a round, so what is left is 0.1 mm.
        np.testing.assert_allclose(fit.shape.offsets_m, fits[0].shape.offsets_m, atol=1e-4)


def test_starting_at_the_optimum_stays_there():
    scan = virtual("Z", 3, n_points=30_000)
    first = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
    again = fit_joint(scan.scan, first.frame, first.shape, JointConfig(), PIXEL_M)
    assert again.rounds == 1
    # Points that the last step moved over an edge: a hundredth of a standard error of the narrowest wall.
    np.testing.assert_allclose(again.shape.offsets_m, first.shape.offsets_m, atol=2e-5)
    assert again.cost <= first.cost * 1.01


def test_the_room_may_be_tilted_by_more_than_one_step_corrects():
    scan = virtual("L", 4, n_points=30_000)
    fit = fit_joint(scan.scan, turned(scan.frame, 1.0), scan.shape, JointConfig(), PIXEL_M)
    between = fit.frame.R_manhattan_scan @ scan.frame.R_manhattan_scan.T
    # 30 000 points of 5 mm over 2 m: 0.001 degrees; ten times that.
    assert np.rad2deg(Rotation.from_matrix(between).magnitude()) < 0.01


def test_too_few_rounds_are_admitted():
    scan = virtual("box", 5, n_points=10_000)
    start = scan.shape.with_offsets(scan.shape.offsets_m + 0.04)
    fit = fit_joint(scan.scan, scan.frame, start, JointConfig(max_rounds=1), PIXEL_M)
    assert not fit.converged
    assert fit.rounds == 1


def test_coarse_rounds_do_not_change_the_end():
    scan = virtual("U", 6, n_points=60_000)
    all_points = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
    thinned = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(coarse_points=10_000), PIXEL_M)
    assert thinned.data.plane_points.sum() == pytest.approx(all_points.data.plane_points.sum(), rel=1e-3)
    np.testing.assert_allclose(thinned.shape.offsets_m, all_points.shape.offsets_m, atol=2e-5)


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_outliers_and_furniture_do_not_move_the_walls(share):
    scan = virtual("L", 7, n_points=40_000, outlier_share=share, n_furniture=3)
    fit = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
    axes = np.array([plane.axis for plane in scan.shape.planes])
    for axis in range(3):
        error_m = (fit.shape.offsets_m - scan.shape.offsets_m)[axes == axis]
        # Twice the limit of a clean scan: outliers widen the patches that they lie in.
        assert np.ptp(error_m) < 2 * expected_limit_m(scan, 0.005)


def test_more_points_give_smaller_errors():
    errors = []
    for n in (5_000, 80_000):
        squares = []
        for seed in range(6):
            scan = virtual("box", 10 + seed, n_points=n)
            fit = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
            squares.append(np.mean((fit.shape.offsets_m - scan.shape.offsets_m) ** 2))
        errors.append(np.sqrt(np.mean(squares)))
    # Sixteen times the points: a quarter of the error; 36 squares each make the ratio good to 25 %.
    assert errors[1] / errors[0] == pytest.approx(0.25, rel=0.5)


def test_points_elsewhere_are_refused_with_a_remedy():
    scan = virtual("box", 8, n_points=5_000)
    elsewhere = Scan(scan.scan.points_m + 50.0)
    with pytest.raises(InputError, match="Fix:"):
        fit_joint(elsewhere, scan.frame, scan.shape, JointConfig(), PIXEL_M)


def test_reach_follows_the_noise():
    scan = virtual("box", 9, n_points=40_000, sigma_m=0.04)
    narrow = replace(AssociationConfig(), max_reach_m=0.10)
    wide = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
    cut = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(association=narrow), PIXEL_M)
    # At 4 cm noise 1.2 % of a Gaussian lies beyond 10 cm.
    assert wide.data.plane_points.sum() > 1.005 * cut.data.plane_points.sum()


LAYER_M = 0.06


def two_layers(monkeypatch):
    """A box whose far x wall is there twice, and an association that hands its plane on to the other layer.

    Returns the truth, the scan, the wall's index, and the offsets of the two layers.
    """
    scan = virtual("box", 5, n_points=20_000)
    x_planes = [k for k, plane in enumerate(scan.shape.planes) if plane.axis == 0]
    wall = max(x_planes, key=lambda k: scan.shape.planes[k].offset_m)
    place_m = scan.shape.planes[wall].offset_m
    points_m = scan.frame.to_manhattan(scan.scan.points_m)
    far = np.flatnonzero(scan.point_plane == wall)[::2]
    points_m[far, 0] -= LAYER_M
    honest = joint.associate

    def fickle(points_m, shape, config, pixel_m):
        on_second = shape.planes[wall].offset_m < place_m - 0.5 * LAYER_M
        second = (points_m[:, 0] < place_m - 0.5 * LAYER_M) & (points_m[:, 0] > place_m - 1.5 * LAYER_M)
        first = (points_m[:, 0] > place_m - 0.5 * LAYER_M) & (points_m[:, 0] < place_m + 0.5 * LAYER_M)
        return honest(points_m[~(second if on_second else first)], shape, config, pixel_m)

    monkeypatch.setattr(joint, "associate", fickle)
    return scan, Scan(scan.frame.to_scan(points_m)), wall, (place_m - LAYER_M, place_m)


def test_a_plane_that_two_layers_hand_on_to_each_other_lies_between_them(monkeypatch):
    truth, scan, wall, layers_m = two_layers(monkeypatch)
    fit = fit_joint(scan, truth.frame, truth.shape, JointConfig(), PIXEL_M)
    assert fit.converged
    # A thousand points of 5 mm on each layer, and the frame's turn over 4 m: half a millimetre.
    assert fit.shape.planes[wall].offset_m == pytest.approx(np.mean(layers_m), abs=5e-4)
    assert fit.swing_m[wall] == pytest.approx(0.5 * LAYER_M, abs=5e-4)
    assert not np.delete(fit.swing_m, wall).any()
    # The residuals belong to the place that is reported.
    own = fit.cells.plane == wall
    assert abs(np.median(fit.cells.residuals_m[own])) < 1e-3


def test_the_interval_of_a_plane_with_two_layers_reaches_over_both(monkeypatch):
    truth, scan, wall, layers_m = two_layers(monkeypatch)
    fit = fit_joint(scan, truth.frame, truth.shape, JointConfig(), PIXEL_M)
    rng = np.random.default_rng(0)
    belief = believe(
        fit.cells,
        None,
        fit.shape,
        fit.frame,
        fit.data.plane_rms_m,
        0.1,
        BeliefConfig(),
        rng,
        swing_m=fit.swing_m,
    )
    row = np.zeros((1, 3 + len(fit.shape.planes)))
    row[0, 3 + wall] = 1.0
    low_m, high_m = belief.wall.with_contrasts(row).interval(0.95)
    # Two places alike are half their distance off the middle, which 1.96 standard deviations nearly double.
    assert low_m[0] < layers_m[0] - 0.02
    assert high_m[0] > layers_m[1] + 0.02


def test_a_plane_at_rest_has_no_swing():
    scan = virtual("box", 5, n_points=10_000)
    fit = fit_joint(scan.scan, scan.frame, scan.shape, JointConfig(), PIXEL_M)
    assert fit.converged
    assert not fit.swing_m.any()
