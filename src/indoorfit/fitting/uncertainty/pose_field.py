"""Intervals with frame ids: every frame has slipped rigidly, and the slips are marginalised.

One frame sees several faces, so its slip shows against the Manhattan model: this is a plane adjustment with a
prior. It finds a face that hangs on displaced frames, to which no residual on the face itself gives a clue.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.geometry import MAD_TO_STD

from .cells import Cells, Contrasts
from .laplace import (
    HyperDraws,
    HyperMode,
    Objective,
    draw_student_t,
    find_mode,
    hessian_from_values,
    laplace_mode,
    truncated_weights,
)
from .location import student_t_precisions, weighted_map
from .pose_cells import SLIP, PoseLayout, PoseLinear, build_layout, linearise
from .pose_noise import describe_pose_noise
from .pose_system import WALL_SCALES, PoseState, Robustness, evaluate_pose, slip_covariances
from .predictive import Predictive


@dataclass(frozen=True)
class PoseFieldConfig:
    """Priors and settings of the pose model."""

    shift_median_m: float = 5e-3
    """Prior median of a frame's shift per axis."""
    turn_median_rad: float = 2e-3
    """Prior median of a frame's rotation per axis: the shift over a lever of 2.5 m."""
    time_median_frames: float = 20.0
    """Prior median of the drift's memory: a field of view takes ten to thirty frames to cross."""
    wall_median_m: float = 3e-3
    """Prior median of a wall's own unevenness from patch to patch, and of errors that all frames share (lens,
    incidence)."""
    lean_median_m: float = 3e-3
    """Prior median of how far walls are out of plumb, skew or bowed at their ends; DIN 18202 lets a wall of a
    room's height be off by three times that. On its own, since a wall that leans may be as smooth as glass:
    a field with one scale for both takes its size from the patches, and gives the lean to the frames."""
    eta_median_m: float = 2e-3
    """Prior median of what is left per cell."""
    scale_log_std: float = 1.5
    """Of the six scales above: a factor of 4.5 either way."""
    rho_logit_std: float = 1.5
    """Drift against jitter, 9 to 91 % at one sigma and a half."""
    kappa: float = 1.0
    """Variance of an offset common to a whole face over that of its shape (lens, incidence, plaster). Not in
    the data: a prior. It costs nothing where walls are flat, since it scales with the walls' own shapes."""
    patch_m: float = 1.0
    """Edge of the wall patches."""
    student_dof: float = 4.0
    """Tail of the cell weights."""
    screen_sigmas: float = 4.5
    """Patches whose mean shift exceeds this many robust sigmas count as contaminated, as in the wall field.
    At 3 every round took some of the patches that show how uneven walls are, until walls seemed smooth."""
    displaced_sigmas: float = 5.0
    """Frames whose slip lies this many robust sigmas from the median frame's were put there by hand or by a
    wrong match: they keep their slip, but not as evidence of how far ordinary frames are off."""
    max_displaced: float = 0.25
    """Largest share of frames that can be displaced: the median frame must stand for the rest, and where
    more seem to be, what they call the rest may be the displaced ones."""
    sweeps: int = 3
    """Mode, weights, screening and relinearisation in turn."""
    draws: int = 24
    """Components of the mixture."""
    draw_dof: float = 6.0
    """Tail of the draws."""
    min_frames: int = 8
    """Fewer frames say nothing about their own scatter."""
    min_views: int = 2
    """A face that one frame alone has seen moves with that frame."""


@dataclass(frozen=True)
class FrameSlips:
    """How far each frame was off: its point p belongs at ``R(turn)^-1 (p - pivot - shift) + pivot``."""

    frames: Int[np.ndarray, " frames"]
    """Frame indices as in the cells."""
    pivots_m: Float[np.ndarray, "frames 3"]
    """Manhattan frame."""
    shifts_m: Float[np.ndarray, "frames 3"]
    turns_rad: Float[np.ndarray, "frames 3"]
    """Rotation vector, Manhattan axes."""
    covariances: Float[np.ndarray, "frames 6 6"]
    """Of (shift, turn): m^2, m rad, rad^2."""
    displaced: Bool[np.ndarray, " frames"]
    """Frames far from where the others say they were."""


@dataclass(frozen=True)
class PoseFieldFit:
    """The model at its last linearisation, with the mode of its hyper-parameters."""

    layout: PoseLayout
    linear: PoseLinear
    robust: Robustness
    mode: HyperMode


_REFUSED = -1e6
"""Log posterior that no scan reaches: one of 10 000 cells has some 100 000 at most."""

# Cells are not believed to better than 0.1 mm each: with less, slips of centimetres make the normal equations
# of a noise-free scan so stiff that rounding decides them. For the same reason patches are not taken as
# smooth to better than 0.02 mm: a wall that leans by centimetres leaves nothing else of their covariance.
_LOW = np.array([np.log(1e-6), np.log(1e-7), -5.0, np.log(0.5), np.log(2e-5), np.log(1e-4), np.log(1e-6)])
_HIGH = np.array([np.log(0.4), np.log(0.2), 5.0, np.log(1e3), np.log(0.37), np.log(0.37), np.log(0.1)])


def pose_prior(config: PoseFieldConfig) -> tuple[Float[np.ndarray, " 7"], Float[np.ndarray, " 7"]]:
    """Mean and standard deviation of phi, see `pose_system.evaluate_pose`."""
    medians = [
        config.shift_median_m,
        config.turn_median_rad,
        1.0,
        config.time_median_frames,
        config.wall_median_m,
        config.eta_median_m,
        config.lean_median_m,
    ]
    stds = np.full(len(medians), config.scale_log_std)
    stds[2] = config.rho_logit_std
    stds[3] = 1.0  # the memory's order of magnitude is known better than a scale's
    return np.log(medians), stds


def pose_obstacle(cells: Cells, config: PoseFieldConfig) -> str | None:
    """Why the pose model cannot be used on these cells, or None."""
    if cells.frames is None:
        return "The points carry no frame ids."
    frames = len(np.unique(cells.frames))
    if frames < config.min_frames:
        return f"{frames} frames; the pose model needs at least {config.min_frames}."
    views = np.unique(np.column_stack([cells.plane, cells.frames]), axis=0)[:, 0]
    planes, seen_by = np.unique(views, return_counts=True)
    alone = int(np.sum(seen_by < config.min_views))
    if alone:
        return (
            f"{alone} of {len(planes)} faces are seen by fewer than {config.min_views} frames; what a "
            "frame's slip does to such a face does not show."
        )
    return None


def pose_log_posterior(
    parts: tuple[PoseLayout, PoseLinear, Robustness], config: PoseFieldConfig, phi: Float[np.ndarray, " 7"]
) -> float:
    """Collapsed log posterior of phi inside its bounds."""
    return evaluate_pose(*parts, phi, config.kappa).log_likelihood + _log_prior(config, phi)


def _log_prior(config: PoseFieldConfig, phi: Float[np.ndarray, " 7"]) -> float:
    means, stds = pose_prior(config)
    return -0.5 * float(np.sum(((phi - means) / stds) ** 2))


def fit_pose_field(cells: Cells, config: PoseFieldConfig) -> PoseFieldFit:
    """Mode of the hyper-parameters; weights, screening and the linearisation point follow it in sweeps."""
    layout = build_layout(cells, config.patch_m)
    step = weighted_map(cells, student_t_precisions(cells, config.student_dof)) @ cells.residuals_m
    linear = linearise(layout, step, np.zeros((len(layout.frame_ids), SLIP)))
    frames = len(layout.frame_ids)
    robust = Robustness(np.ones(len(layout.frame)), np.zeros(layout.n_patches), np.zeros((frames, SLIP)))
    means, stds = pose_prior(config)
    bounds = np.column_stack([_LOW, _HIGH])
    point = means.copy()
    for _ in range(config.sweeps):
        parts = (layout, linear, robust)
        # The weights move anyway: a loose peak is enough until the last search.
        point, _ = find_mode(_differences(parts, config), point, bounds, 1e-5, 30)
        state = evaluate_pose(*parts, point, config.kappa)
        robust = _reweight(parts, state, config)
        step = np.zeros(cells.n_params)
        step[layout.seen] = state.border[: len(layout.precision)]
        linear = linearise(layout, step, state.slips)
    parts = (layout, linear, robust)
    point, converged = find_mode(_differences(parts, config), point, bounds, 1e-6, 30)

    def log_posterior(phi: Float[np.ndarray, " 7"]) -> float:
        return pose_log_posterior(parts, config, np.clip(phi, _LOW, _HIGH))

    hessian = hessian_from_values(log_posterior, point)
    return PoseFieldFit(layout, linear, robust, laplace_mode(point, hessian, stds, converged))


def _differences(parts: tuple[PoseLayout, PoseLinear, Robustness], config: PoseFieldConfig) -> Objective:
    """The log posterior with its gradient by forward differences: eight evaluations of some milliseconds."""
    width = 1e-4

    def objective(phi: Float[np.ndarray, " 7"]) -> tuple[float, Float[np.ndarray, " 7"]]:
        inside = np.clip(phi, _LOW, _HIGH - width)
        try:
            state = evaluate_pose(*parts, inside, config.kappa)
            moved = []
            for k, move in enumerate(width * np.eye(len(phi))):
                slips = state.elimination if k in WALL_SCALES else None
                there = evaluate_pose(*parts, inside + move, config.kappa, slips)
                moved.append(there.log_likelihood + _log_prior(config, inside + move))
        except np.linalg.LinAlgError:
            # The search tries a corner of its box first, where rounding wins: step back.
            return _REFUSED, np.zeros(len(phi))
        value = state.log_likelihood + _log_prior(config, inside)
        return value, (np.array(moved) - value) / width

    return objective


def _reweight(
    parts: tuple[PoseLayout, PoseLinear, Robustness], state: PoseState, config: PoseFieldConfig
) -> Robustness:
    """Student-t weights of the cells and mean-shift inflation of contradicted patches."""
    layout, linear, robust = parts
    fitted = linear.columns @ np.append(-state.border, 1.0)
    remaining = fitted - np.sum(linear.slip_rows * state.slips[layout.frame], axis=1)
    scaled = remaining**2 / (state.variances_m2 * robust.weights)
    weights = (config.student_dof + 1) / (config.student_dof + scaled)

    theta = len(layout.precision)
    shift, variance = np.empty(layout.n_patches), np.empty(layout.n_patches)
    for members, precision in zip(layout.patches, state.patch_precisions, strict=True):
        where = theta + members
        effect = precision @ state.border[where]
        # Z^T P Z = G^-1 - G^-1 C G^-1: precision of a mean shift of one patch, left out of the rest.
        left = precision - precision @ state.border_covariance[np.ix_(where, where)] @ precision
        known = np.maximum(left.diagonal(), 1e-9 * precision.diagonal())
        shift[members], variance[members] = effect / known, 1.0 / known
    score = np.abs(shift) / np.sqrt(np.maximum(variance - robust.inflation_m2, 1e-18))
    limit = config.screen_sigmas * MAD_TO_STD * float(np.median(score))
    inflation = np.where(score > limit, shift**2, 0.0)
    return Robustness(weights, inflation, _displacements(state.slips, config))


def _displacements(
    slips: Float[np.ndarray, "frames 6"], config: PoseFieldConfig
) -> Float[np.ndarray, "frames 6"]:
    """Mean squared distance from the median slip for frames beyond the limit, else 0.

    A Gaussian prior would split the difference between a displaced block and the rest, and so shift the
    walls that each of them sees. A frame that was put somewhere by hand is off in all its six coordinates,
    whichever of them gave it away.
    """
    away = (slips - np.median(slips, axis=0)).reshape(len(slips), 2, SLIP // 2)
    # One scale for the three axes: drift and jitter have no preferred one, and frames are few.
    scale = MAD_TO_STD * np.median(np.abs(away), axis=(0, 2))
    beyond = np.any(np.abs(away) > config.displaced_sigmas * scale[:, None], axis=(1, 2))
    if np.mean(beyond) > config.max_displaced:
        return np.zeros_like(slips)
    variance = np.repeat(np.mean(away**2, axis=2), SLIP // 2, axis=1)
    return np.where(beyond[:, None], variance, 0.0)


def pose_field_predictive(
    cells: Cells, contrasts: Contrasts, config: PoseFieldConfig, rng: np.random.Generator
) -> tuple[Predictive, FrameSlips]:
    """Distribution of all dimensions from cells with frame ids, and every frame's estimated slip.

    Args:
        cells: one per frame, plane and patch of about 1 m; `pose_obstacle` must have nothing against them.
        contrasts: the dimensions and the linearisation point.
        config: priors.
        rng: for the draws of the noise model only.
    """
    fit = fit_pose_field(cells, config)
    parts = (fit.layout, fit.linear, fit.robust)
    points, log_density = draw_student_t(fit.mode, config.draws, config.draw_dof, rng)
    points = np.clip(points, _LOW, _HIGH)
    states = [evaluate_pose(*parts, point, config.kappa) for point in points]
    prior = np.array([_log_prior(config, point) for point in points])
    log_target = np.array([state.log_likelihood for state in states]) + prior
    hyper = HyperDraws(points, truncated_weights(log_target - log_density))
    where, theta = np.flatnonzero(cells.seen), len(fit.layout.precision)
    means = np.tile(contrasts.estimate, (len(states), 1))
    covariances = np.zeros((len(states), cells.n_params, cells.n_params))
    for k, state in enumerate(states):
        means[k, where] += state.border[:theta]
        covariances[k][np.ix_(where, where)] = state.border_covariance[:theta, :theta]
    noise = describe_pose_noise(hyper, pose_prior(config)[1], fit.robust, fit.mode.converged)
    predictive = Predictive(hyper.weights, means, covariances, cells.seen, contrasts.matrix, noise)
    return predictive, _slips(fit, config)


def rough_slips(cells: Cells, config: PoseFieldConfig) -> tuple[FrameSlips, Float[np.ndarray, " params"]]:
    """Slips and the step of theta from the linearisation point at the mode of the hyper-parameters alone."""
    fit = fit_pose_field(cells, replace(config, sweeps=2))
    state = evaluate_pose(fit.layout, fit.linear, fit.robust, fit.mode.point, config.kappa)
    step = np.zeros(cells.n_params)
    step[fit.layout.seen] = state.border[: len(fit.layout.precision)]
    return _slips(fit, config), step


def _slips(fit: PoseFieldFit, config: PoseFieldConfig) -> FrameSlips:
    state = evaluate_pose(fit.layout, fit.linear, fit.robust, fit.mode.point, config.kappa)
    shifts, turns = np.split(state.slips, 2, axis=1)
    displaced = np.any(fit.robust.slip_inflation > 0, axis=1)
    covariances = slip_covariances(state)
    return FrameSlips(fit.layout.frame_ids, fit.layout.pivots_m, shifts, turns, covariances, displaced)
