"""The pose field: its algebra against dense matrices, and what it recovers."""

from dataclasses import replace

import numpy as np
import pytest
from cell_rooms import REGIMES, Regime, simulate_cell_room

from indoorfit.fitting.uncertainty import (
    PoseFieldConfig,
    WallFieldConfig,
    pose_field_predictive,
    pose_obstacle,
    wall_field_predictive,
)
from indoorfit.fitting.uncertainty.pose_cells import SLIP, build_layout, linearise
from indoorfit.fitting.uncertainty.pose_field import pose_prior
from indoorfit.fitting.uncertainty.pose_system import (
    WALL_SCALES,
    Robustness,
    evaluate_pose,
    patch_precisions,
    slip_covariances,
)

CONFIG = PoseFieldConfig()


def dense_posterior(layout, linear, robust, phi, kappa):
    """The same model with every matrix written out."""
    sigma = np.repeat(np.exp(phi[:2]), 3)
    rho = 1 / (1 + np.exp(-phi[2]))
    frames = len(layout.frame_ids)
    gap = np.abs(np.subtract.outer(layout.frame_ids, layout.frame_ids))
    prior_slips = np.kron(rho * np.exp(-gap / np.exp(phi[3])) + (1 - rho) * np.eye(frames), np.diag(sigma**2))
    prior_slips += np.diag(robust.slip_inflation.ravel())
    slip_columns = linear.slip_matrix.T.toarray()
    dense = linear.columns.toarray()
    theta = len(layout.precision)
    design, walls, target = dense[:, :theta], dense[:, theta:-1], dense[:, -1]
    prior_walls = np.exp(2 * phi[6]) * np.eye(walls.shape[1])
    for members, inverse in zip(layout.patches, patch_precisions(layout, phi, kappa, robust)[0], strict=True):
        prior_walls[np.ix_(members, members)] = np.linalg.inv(inverse)
    variances = (layout.cells.variances_m2 + np.exp(2 * phi[5])) / robust.weights
    v = np.diag(variances) + slip_columns @ prior_slips @ slip_columns.T + walls @ prior_walls @ walls.T
    inverse = np.linalg.inv(v)
    normal = design.T @ inverse @ design + np.diag(layout.precision)
    step = np.linalg.solve(normal, design.T @ inverse @ target)
    left = target - design @ step
    value = -0.5 * (
        np.linalg.slogdet(v)[1] + np.linalg.slogdet(normal)[1] + target @ inverse @ left
    )  # prior precision included: y^T V^-1 y - h^T M^-1 h
    gain = prior_slips @ slip_columns.T
    slips = gain @ inverse @ left
    influence = np.linalg.solve(normal, design.T @ inverse)
    hat = inverse - inverse @ design @ influence
    covariance = prior_slips - gain @ hat @ gain.T
    return value, step, np.linalg.inv(normal), slips.reshape(-1, SLIP), covariance


def test_banded_elimination_equals_dense_matrices() -> None:
    rng = np.random.default_rng(8)
    cells = simulate_cell_room(4, REGIMES["p20"]).frame_cells
    # Coarse variances: a dense inverse loses digits that the banded factor keeps.
    cells = replace(cells, variances_m2=cells.variances_m2 + 1e-5)
    layout = build_layout(cells, 1.0)
    frames = len(layout.frame_ids)
    inflation = np.zeros((frames, SLIP))
    inflation[3] = 0.01
    robust = Robustness(rng.uniform(0.3, 1.2, len(layout.frame)), np.zeros(layout.n_patches), inflation)
    linear = linearise(layout, np.zeros(cells.n_params), np.zeros((frames, SLIP)))
    values = []
    for phi in (
        np.array([np.log(0.02), np.log(0.006), 0.5, np.log(15.0), np.log(3e-3), np.log(2e-3), np.log(4e-3)]),
        np.array([np.log(0.005), np.log(0.002), -1.0, np.log(3.0), np.log(1e-3), np.log(5e-3), np.log(1e-3)]),
    ):
        state = evaluate_pose(layout, linear, robust, phi, 0.5)
        value, step, covariance, slips, slip_covariance = dense_posterior(layout, linear, robust, phi, 0.5)
        theta = len(layout.precision)
        # The dense inverse has a condition of 1e6: ten digits left.
        np.testing.assert_allclose(state.border[:theta], step, atol=1e-8)
        np.testing.assert_allclose(state.border_covariance[:theta, :theta], covariance, rtol=1e-5, atol=1e-10)
        np.testing.assert_allclose(state.slips, slips, atol=1e-8)
        blocks = slip_covariance.reshape(frames, SLIP, frames, SLIP)
        own = np.array([blocks[i, :, i] for i in range(frames)])
        np.testing.assert_allclose(slip_covariances(state), own, rtol=1e-4, atol=1e-10)
        values.append((state.log_likelihood, value))
    # Both are known up to the same constant: only the difference counts.
    assert values[0][0] - values[1][0] == pytest.approx(values[0][1] - values[1][1], abs=1e-4)


def test_walls_out_of_plumb_are_so_at_every_cell() -> None:
    """Near cells are good to a tenth of a millimetre: to them a patch of a metre is not one height."""
    rng = np.random.default_rng(11)
    cells = simulate_cell_room(4, REGIMES["p20"]).frame_cells
    across = np.arange(len(cells.plane)), cells.axes
    tilts = 1e-3 * rng.standard_normal((cells.plane.max() + 1, 3))
    places_m = cells.centroids_m.copy()
    places_m[across] = 0.0
    residuals_m = np.sum(tilts[cells.plane] * places_m, axis=1)
    centroids_m = cells.centroids_m.copy()
    centroids_m[across] += residuals_m - cells.residuals_m
    cells = replace(cells, residuals_m=residuals_m, centroids_m=centroids_m)
    layout = build_layout(cells, 1.0)
    frames = len(layout.frame_ids)
    linear = linearise(layout, np.zeros(cells.n_params), np.zeros((frames, SLIP)))
    robust = Robustness(np.ones(len(layout.frame)), np.zeros(layout.n_patches), np.zeros((frames, SLIP)))
    # Frames that do not slip, and walls that are flat but for their leaning.
    still = np.array([np.log(1e-6), np.log(1e-7), 0.0, 3.0, np.log(2e-5), np.log(1e-4), np.log(5e-3)])
    state = evaluate_pose(layout, linear, robust, still, 1.0)
    left_m = linear.columns @ np.append(-state.border, 1.0)
    # Of tilts of a millimetre a metre; the prior of 5 mm draws by a thousandth.
    assert np.sqrt(np.mean(residuals_m**2)) > 1e-3
    assert np.sqrt(np.mean(left_m**2)) < 2e-5


def test_linearised_residual_agrees_with_exact_rotation_to_second_order() -> None:
    room = simulate_cell_room(6, REGIMES["p20"])
    layout = build_layout(room.frame_cells, 1.0)
    rng = np.random.default_rng(2)
    frames = len(layout.frame_ids)
    slips = 0.01 * rng.standard_normal((frames, SLIP))
    step = np.zeros(room.frame_cells.n_params)
    step[:3] = 0.01 * rng.standard_normal(3)
    for scale in (1e-3, 1e-4):
        move, turn = scale * rng.standard_normal((frames, SLIP)), np.zeros_like(step)
        turn[:3] = scale * rng.standard_normal(3)
        here, there = linearise(layout, step, slips), linearise(layout, step + turn, slips + move)
        # `target - B u - A theta` is the exact residual; its change must be the derivative's.
        change = exact_residual(layout, there, step + turn, slips + move)
        change -= exact_residual(layout, here, step, slips)
        rows = np.sum(here.slip_rows * move[layout.frame], axis=1)
        theta = here.columns.toarray()[:, :3] @ turn[:3]
        # Levers of 6 m, moves of up to 4 scale: half their square, and 4 cm of slip squared over six.
        bound = 6 * 4 * scale * (4 * scale + 0.04**2)
        np.testing.assert_allclose(change, -rows - theta, atol=bound)


def exact_residual(layout, linear, step, slips):
    dense = linear.columns.toarray()
    rotation = dense[:, :3] @ step[:3]
    return dense[:, -1] - np.sum(linear.slip_rows * slips[layout.frame], axis=1) - rotation


def test_slips_recover_the_frames_true_errors_up_to_a_common_motion() -> None:
    room = simulate_cell_room(3, REGIMES["p20"])
    _, slips = pose_field_predictive(room.frame_cells, room.contrasts, CONFIG, np.random.default_rng(0))
    truth = room.pose_errors[slips.frames, :3]
    error = slips.shifts_m - truth
    error -= error.mean(axis=0)
    before = np.std(truth - truth.mean(axis=0))
    assert np.std(error) < 0.5 * before
    # The stated uncertainty is of the right size: z-scores of a hundred correlated numbers.
    scale = np.sqrt(np.array([c.diagonal()[:3] for c in slips.covariances]))
    assert 0.2 < np.sqrt(np.mean((error / scale) ** 2)) < 2.0


def test_displaced_frames_are_found_and_their_face_put_back() -> None:
    room = simulate_cell_room(105, Regime(0.005, dirty=True, displaced_face=True))
    pose, slips = pose_field_predictive(room.frame_cells, room.contrasts, CONFIG, np.random.default_rng(0))
    wall = wall_field_predictive(room.cells, room.contrasts, WallFieldConfig(), np.random.default_rng(0))
    step = room.kinds.index("step")
    assert abs(wall.mean[step] - room.truth_m[step]) > 0.1  # blind: all that sees the face is displaced
    assert abs(pose.mean[step] - room.truth_m[step]) < 0.01
    truly = np.abs(room.pose_errors[slips.frames, 0]) > 0.1
    assert np.mean(slips.displaced == truly) > 0.9


def test_sensor_centres_are_not_needed() -> None:
    room = simulate_cell_room(9, REGIMES["p5"])
    bare = replace(room.frame_cells, frame_centres_m=None)
    with_centres, _ = pose_field_predictive(
        room.frame_cells, room.contrasts, CONFIG, np.random.default_rng(0)
    )
    without, _ = pose_field_predictive(bare, room.contrasts, CONFIG, np.random.default_rng(0))
    assert np.all(np.abs(with_centres.mean - without.mean) < 3 * np.hypot(with_centres.std, without.std))


def test_walls_that_lean_are_not_taken_for_slips() -> None:
    room = simulate_cell_room(4, REGIMES["p5"])
    cells = room.frame_cells
    rng = np.random.default_rng(3)
    leaning = cells.residuals_m.copy()
    for plane in np.unique(cells.plane[cells.axes != 2]):
        own = cells.plane == plane
        places = np.delete(cells.centroids_m[own], cells.axes[own][0], axis=1)
        places -= 0.5 * (places.max(axis=0) + places.min(axis=0))
        leaning[own] += places / np.abs(places).max() @ (6e-3 * rng.standard_normal(2))
    flat, leant = (
        pose_field_predictive(
            replace(cells, residuals_m=residuals_m), room.contrasts, CONFIG, np.random.default_rng(0)
        )[0]
        for residuals_m in (cells.residuals_m, leaning)
    )
    # 6 mm from a dozen slopes, to a factor of two; the slips keep their size, to a half.
    assert 3e-3 < leant.noise["lean_m"]["median"] < 12e-3
    assert flat.noise["lean_m"]["median"] < 2e-3
    assert leant.noise["turn_rad"]["median"] < 1.5 * flat.noise["turn_rad"]["median"]
    lengths = np.array([kind != "height" for kind in room.kinds])
    assert np.all(leant.std[lengths] > flat.std[lengths])


def test_wall_scales_alone_need_no_new_elimination_of_the_slips() -> None:
    cells = simulate_cell_room(4, REGIMES["p5"]).frame_cells
    layout = build_layout(cells, 1.0)
    frames = len(layout.frame_ids)
    robust = Robustness(np.ones(len(layout.frame)), np.zeros(layout.n_patches), np.zeros((frames, SLIP)))
    linear = linearise(layout, np.zeros(cells.n_params), np.zeros((frames, SLIP)))
    phi = pose_prior(CONFIG)[0]
    here = evaluate_pose(layout, linear, robust, phi, 1.0)
    for scale in WALL_SCALES:
        moved = phi.copy()
        moved[scale] += 0.3
        anew = evaluate_pose(layout, linear, robust, moved, 1.0)
        reused = evaluate_pose(layout, linear, robust, moved, 1.0, here.elimination)
        assert reused.log_likelihood == anew.log_likelihood


def test_obstacles_are_named() -> None:
    room = simulate_cell_room(9, REGIMES["p5"])
    message = pose_obstacle(room.cells, CONFIG)
    assert message is not None
    assert "frame ids" in message
    few = replace(room.frame_cells, frames=np.minimum(room.frame_cells.frames, 3))
    message = pose_obstacle(few, CONFIG)
    assert message is not None
    assert "4 frames" in message
    assert pose_obstacle(room.frame_cells, CONFIG) is None
