"""Intervals without frame ids: a Gaussian-process field on every wall.

The mean of the error field over a face is exactly confounded with the face's offset, so its size must be
extrapolated from how the field varies within the face. Estimate: Student-t fit. Covariance: the sandwich
``L V L^T`` with V from the field. Hyper-parameters are marginalised, not plugged in.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from indoorfit.geometry import MAD_TO_STD

from .cells import ROTATIONS, Cells, Contrasts
from .field import (
    LOG_ETA,
    LOG_LENGTH,
    LOG_TAU,
    LOG_TILT,
    Block,
    Field,
    FieldFit,
    block_covariance,
    build_field,
    evaluate,
    log_likelihoods,
)
from .laplace import (
    HyperDraws,
    HyperMode,
    draw_student_t,
    find_mode,
    hessian_from_gradients,
    laplace_mode,
    truncated_weights,
)
from .level_field import add_common, common_share, level_blocks
from .location import student_t_precisions, weighted_map
from .predictive import Predictive
from .wall_noise import describe_wall_noise


@dataclass(frozen=True)
class WallFieldConfig:
    """Priors and settings of the wall field."""

    tau_median_m: float = 5e-3
    """Prior median of the field's standard deviation: between laser (1 mm) and hand-held drift (2 cm)."""
    tau_log_std: float = 1.5
    """A factor of 4.5 either way at one sigma: wide, so that clean scans can take tau to a tenth of a mm."""
    eta_median_m: float = 3e-3
    """Prior median of the independent part per cell: plaster, edges, remains of furniture."""
    eta_log_std: float = 1.5
    """As wide as for tau."""
    length_median_m: float = 1.0
    """Prior median of the correlation length: a field of view covers one to three metres of a wall."""
    length_log_std: float = 0.4
    """Informative on purpose: range and variance of a field are not separately identified within one wall."""
    length_max_m: float = 3.0
    """Hard bound: beyond the size of a wall the field runs away into widths of metres."""
    tau_max_m: float = 0.37
    """Hard bound: a wall that wanders by more is no wall."""
    tilt_median_rad: float = 1.7e-3
    """Prior median of how far a face as a whole is turned: registration turns by about 1/3 rad per metre of
    its position error, here that of `tau_median_m`."""
    tilt_log_std: float = 2.0
    """A factor of 7 either way at one sigma: wider than for tau, since a scan without drift turns its walls a
    hundred times less than a hand-held one, and the lever would carry what the prior insists on."""
    tilt_max_rad: float = 0.05
    """Hard bound: 3 degrees, where the axes of the room would be in doubt."""
    lever_m: float = 2.5
    """What turned a wall turned about a place off the wall, which moved it as well: by the tilt over this
    lever, along its normal. A stated prior, for the movement itself leaves no residual; none for floor and
    ceiling. Registration holds what is in view, which a sensor in a room has two to three metres away; the
    same lever relates turns to shifts in the prior of the frames' slips."""
    face_share: float = 0.2
    """Variance of an offset common to a whole wall, as a share of tau^2; none for floor and ceiling. A stated
    prior, not an estimate: a wall passed once hangs on one stretch of the path, whose mean error no residual
    shows. Floor and ceiling are in view all along. What its turn tells of it is counted by `lever_m`. 0 is
    right where every wall was passed twice or more."""
    level_common: float = 0.7
    """Correlation of the errors of floor and ceiling over each other that is expected before looking: a frame
    or station that stands too high puts both too high, but not each frame sees both."""
    level_weight: float = 8.0
    """What that expectation counts for beside the scan's own patches, in patches."""
    wall_dof: float = 4.0
    """Degrees of freedom of the prior that all walls of a room err alike (scaled inverse chi-square about 1);
    infinite takes them as alike. One that hangs on a slipped block of frames does not: its own residuals then
    widen what is said of it, and never narrow it, since a wall seen from one place is smooth because nothing
    contradicts it. So do its turns against the room, which are what shows most of such a block."""
    screen_sigmas: float = 4.5
    """Cells whose left-out residual exceeds this many robust sigmas count as contaminated. Scores have the
    tails of Student's t with 4 degrees of freedom, since walls differ in how badly they are registered:
    beyond 3 are four in a hundred of them, and those tell of misregistration; beyond 4.5 one. Furniture
    and curtains lie beyond ten."""
    screen_sweeps: int = 3
    """Fit and screen in turn; the set stands still after two or three."""
    student_dof: float = 4.0
    """Tail of the estimate's weights: full weight to the bulk, 1/r beyond some sigmas."""
    draws: int = 32
    """Components of the mixture; more change interval ends by 1 to 3 %."""
    draw_dof: float = 6.0
    """Tail of the draws, heavier than the posterior's so that importance weights stay bounded."""


_FLOOR_LOG_M = float(np.log(1e-6))
"""1 um, and 1 urad: below it tau, eta and tilt make no difference to any cell."""


@dataclass(frozen=True)
class WallFieldFit:
    """A field with its screened cells and the mode of its hyper-parameters."""

    field: Field
    inflation_m2: Float[np.ndarray, " cells"]
    mode: HyperMode


def prior_moments(config: WallFieldConfig) -> tuple[Float[np.ndarray, " 4"], Float[np.ndarray, " 4"]]:
    """Mean and standard deviation of phi = log(tau, l, eta, tilt) before truncation."""
    medians = [config.tau_median_m, config.length_median_m, config.eta_median_m, config.tilt_median_rad]
    stds = [config.tau_log_std, config.length_log_std, config.eta_log_std, config.tilt_log_std]
    return np.log(medians), np.array(stds)


def hyper_bounds(config: WallFieldConfig) -> Float[np.ndarray, "4 2"]:
    """Where phi may be."""
    bounds = np.empty((4, 2))
    bounds[LOG_TAU] = _FLOOR_LOG_M, np.log(config.tau_max_m)
    bounds[LOG_LENGTH] = np.log(0.02), np.log(config.length_max_m)
    bounds[LOG_ETA] = _FLOOR_LOG_M, np.log(config.tau_max_m)
    bounds[LOG_TILT] = _FLOOR_LOG_M, np.log(config.tilt_max_rad)
    return bounds


def log_posteriors(
    fit: WallFieldFit, config: WallFieldConfig, phis: Float[np.ndarray, "draws 4"]
) -> Float[np.ndarray, " draws"]:
    """Collapsed log posterior of phi, theta integrated; -inf outside the bounds. Vectorised over draws."""
    means, stds = prior_moments(config)
    bounds = hyper_bounds(config)
    inside = np.all((phis >= bounds[:, 0]) & (phis <= bounds[:, 1]), axis=1)
    values = np.full(len(phis), -np.inf)
    if inside.any():
        likelihood, _, _ = log_likelihoods(fit.field, phis[inside], fit.inflation_m2)
        values[inside] = likelihood - 0.5 * np.sum(((phis[inside] - means) / stds) ** 2, axis=1)
    return values


def fit_wall_field(cells: Cells, config: WallFieldConfig) -> WallFieldFit:
    """Mode of the hyper-parameters, with contaminated cells found on the way."""
    field = build_field(cells)
    means, stds = prior_moments(config)
    bounds = hyper_bounds(config)
    inflation = np.zeros(len(cells.plane))

    def objective(phi: Float[np.ndarray, " 4"]) -> tuple[float, Float[np.ndarray, " 4"]]:
        fit = evaluate(field, phi, inflation)
        pull = (phi - means) / stds
        return fit.log_likelihood - 0.5 * float(pull @ pull), fit.gradient - pull / stds

    spread = max(MAD_TO_STD * float(np.median(np.abs(cells.residuals_m))), 1e-5)
    # A metre off the middle, such a tilt is as large as a third of the spread.
    start = np.array([np.log(spread), means[LOG_LENGTH], np.log(0.5 * spread), np.log(spread / 3.0)])
    point, converged = find_mode(objective, start, bounds)
    for _ in range(config.screen_sweeps):
        screened = _screen(evaluate(field, point, inflation), inflation, config.screen_sigmas)
        blocks = tuple(_turned(block, point, screened, config.wall_dof) for block in field.blocks)
        moved = max(abs(np.log(b.turn / a.turn)) for a, b in zip(field.blocks, blocks, strict=True))
        same = bool(np.array_equal(screened > 0, inflation > 0)) and moved < _STILL_TURN
        inflation, field = screened, replace(field, blocks=blocks)
        if same:
            break
        point, converged = find_mode(objective, point, bounds)
    hessian = hessian_from_gradients(objective, point)
    return WallFieldFit(field, inflation, laplace_mode(point, hessian, stds, converged))


def _screen(
    fit: FieldFit, inflation_m2: Float[np.ndarray, " cells"], sigmas: float
) -> Float[np.ndarray, " cells"]:
    """Mean-shift inflation: the squared left-out residual of every cell that the others contradict."""
    # The left-out variance contains the inflation already given; the test must not.
    clean = np.maximum(fit.left_out_variance_m2 - inflation_m2, 1e-18)
    score = np.abs(fit.left_out_m) / np.sqrt(clean)
    limit = sigmas * MAD_TO_STD * float(np.median(score))
    return np.where(score > limit, fit.left_out_m**2, 0.0)


def _turned(
    block: Block, phi: Float[np.ndarray, " 4"], inflation_m2: Float[np.ndarray, " cells"], dof: float
) -> Block:
    """The block with its wall's own variance of the tilt, as a multiple of what is usual in the room.

    A wall that hangs on one slipped block of frames is turned by more than all others, and that is two
    numbers of its twenty residuals: hardly any unrest. Turns have Student's t with `dof` degrees of freedom;
    the scale is the fixed point of expectation and maximisation (Lange, Little and Taylor 1989), the wall's
    offset taken out.
    """
    if len(block.rows) < _MIN_UNREST_CELLS or np.isinf(dof):
        return block
    usual_m2 = np.exp(2 * phi[LOG_TILT]) * block.lever_m2 / block.turn
    flat_m2 = block_covariance(block, phi, inflation_m2) - block.turn * usual_m2
    scale = block.turn
    for _ in range(_TURN_STEPS):
        inverse = np.linalg.inv(flat_m2 + scale * usual_m2)
        once = inverse.sum(axis=1)
        free = inverse - np.outer(once, once) / once.sum()
        pull = free @ block.target_m
        squares = scale**2 * float(pull @ usual_m2 @ pull)
        left = scale * (_TURNS - scale * float(np.sum(free * usual_m2)))
        scale = (dof + squares + left) / (dof + _TURNS)
    return replace(block, lever_m2=block.lever_m2 * (scale / block.turn), turn=scale)


_TURNS = 2
"""A wall can turn about two axes; about its own normal nothing shows."""
_TURN_STEPS = 12
"""Of the fixed point: a wall turned ten times as far as usual is then right to some per cent."""
_STILL_TURN = 0.2
"""Relative change of a tilt's variance that ends the sweeps: a tenth of an uncertainty."""


def sandwich_predictive(
    cells: Cells, contrasts: Contrasts, fit: WallFieldFit, hyper: HyperDraws, config: WallFieldConfig
) -> Predictive:
    """Student-t estimate with covariance ``L V(phi) L^T`` for every draw of phi, restless walls scaled up."""
    linear = weighted_map(cells, student_t_precisions(cells, config.student_dof))
    covariances = np.zeros((len(hyper.points), cells.n_params, cells.n_params))
    unrest = np.ones((len(hyper.points), cells.n_params - ROTATIONS))
    levels = level_blocks(cells, fit.field.blocks)
    share = common_share(cells, levels, fit.mode.point, config.level_common, config.level_weight)
    for block in fit.field.blocks:
        part, plane = linear[:, block.rows], cells.plane[block.rows[0]]
        for k, phi in enumerate(hyper.points):
            covariance = block_covariance(block, phi, fit.inflation_m2)
            unrest[k, plane] = _unrest(block.target_m, covariance, config.wall_dof)
            covariances[k] += unrest[k, plane] * (part @ covariance @ part.T)
    for k, phi in enumerate(hyper.points):
        scaled = [np.sqrt(unrest[k, cells.plane[b.rows[0]]]) * linear[:, b.rows] for b in levels]
        add_common(covariances[k], cells, levels, scaled, phi, share)
    _add_face_offsets(covariances, cells, fit.field, hyper, config, unrest)
    theta = contrasts.estimate + linear @ cells.residuals_m
    return Predictive(
        weights=hyper.weights,
        means=np.tile(theta, (len(hyper.points), 1)),
        covariances=covariances,
        seen=cells.seen,
        contrasts=contrasts.matrix,
        noise=describe_wall_noise(
            hyper, prior_moments(config)[1], fit.inflation_m2, cells.variances_m2, fit.mode.converged
        ),
        screened=fit.inflation_m2 > 0,
    )


_MIN_UNREST_CELLS = 4
"""Fewer patches say nothing of a wall's own scale."""


def _unrest(
    residuals_m: Float[np.ndarray, " rows"], covariance_m2: Float[np.ndarray, "rows rows"], dof: float
) -> float:
    """By how much one wall's residuals exceed, in variance, what the room's noise model says; at least 1.

    One over the posterior mean of the precision under a scaled inverse chi-square prior about 1; the scale of
    a Student-t process (Shah, Wilson and Ghahramani 2014) with their nu - 2 as `dof`. The wall's offset is
    taken out by generalised least squares.
    """
    n = len(residuals_m)
    if n < _MIN_UNREST_CELLS or np.isinf(dof):
        return 1.0
    both = np.column_stack([residuals_m, np.ones(n)])
    gram = both.T @ np.linalg.solve(covariance_m2, both)
    square = float(gram[0, 0] - gram[0, 1] ** 2 / gram[1, 1])
    return max(1.0, (dof + square) / (dof + n - 1))


def _add_face_offsets(
    covariances: Float[np.ndarray, "draws params params"],
    cells: Cells,
    field: Field,
    hyper: HyperDraws,
    config: WallFieldConfig,
    unrest: Float[np.ndarray, "draws planes"] | None = None,
) -> None:
    """Add the walls' common offsets, in place: a share of tau^2, and the tilt over its lever.

    An offset common to a face is what its parameter is: it drops out of the restricted likelihood and of
    every residual, and passes unchanged into the parameter's variance.
    """
    upright = [block for block in field.blocks if cells.axes[block.rows[0]] != 2]
    walls = np.array([cells.plane[block.rows[0]] for block in upright], int)
    turns = np.array([block.turn for block in upright], float)
    columns = ROTATIONS + walls
    tau_m2, tilt_2 = (np.exp(2 * hyper.points[:, [column]]) for column in (LOG_TAU, LOG_TILT))
    common = config.face_share * tau_m2 * (1.0 if unrest is None else unrest[:, walls])
    moved = config.lever_m**2 * tilt_2 * turns
    covariances[:, columns, columns] += common + moved


def gls_predictive(
    cells: Cells, contrasts: Contrasts, fit: WallFieldFit, hyper: HyperDraws, config: WallFieldConfig
) -> Predictive:
    """Generalised least squares for every draw of phi: theta and covariance of the field model itself.

    Sharper than the sandwich where the field is right, worse where cells are contaminated; used to check
    samplers, since this is the posterior that they sample.
    """
    _, steps, step_covariances = log_likelihoods(fit.field, hyper.points, fit.inflation_m2)
    means = np.tile(contrasts.estimate, (len(hyper.points), 1))
    means[:, cells.seen] += steps
    covariances = np.zeros((len(hyper.points), cells.n_params, cells.n_params))
    where = np.flatnonzero(cells.seen)
    covariances[:, where[:, None], where] = step_covariances
    _add_face_offsets(covariances, cells, fit.field, hyper, config)
    stds = prior_moments(config)[1]
    noise = describe_wall_noise(hyper, stds, fit.inflation_m2, cells.variances_m2, fit.mode.converged)
    return Predictive(hyper.weights, means, covariances, cells.seen, contrasts.matrix, noise)


def laplace_draws(fit: WallFieldFit, config: WallFieldConfig, rng: np.random.Generator) -> HyperDraws:
    """Weighted draws of phi from a Student-t around the mode."""
    points, log_density = draw_student_t(fit.mode, config.draws, config.draw_dof, rng)
    log_target = log_posteriors(fit, config, points)
    if not np.isfinite(log_target).any():
        # Of a cloud without noise all scales lie at the ends of their ranges, and every draw may lie beyond.
        return HyperDraws(fit.mode.point[None], np.ones(1))
    return HyperDraws(points, truncated_weights(log_target - log_density))


def wall_field_predictive(
    cells: Cells, contrasts: Contrasts, config: WallFieldConfig, rng: np.random.Generator
) -> Predictive:
    """Distribution of all dimensions from cells without frame ids.

    Args:
        cells: one per plane and patch of about 0.7 m; frame ids are ignored.
        contrasts: the dimensions and the linearisation point.
        config: priors.
        rng: for the draws of the noise model only; two seeds differ by 1 to 3 % in the interval ends.

    Returns:
        the mixture; `noise` describes tau, l, eta, tilt, the share of screened cells and the prior's role.
    """
    fit = fit_wall_field(cells if cells.frames is None else replace(cells, frames=None), config)
    return sandwich_predictive(cells, contrasts, fit, laplace_draws(fit, config, rng), config)
