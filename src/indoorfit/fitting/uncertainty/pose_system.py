"""Restricted likelihood of the pose model, with theta, slips and the walls' shapes integrated analytically.

The slips follow an Ornstein-Uhlenbeck process plus white noise over the frame index. The white part is
eliminated frame by frame (6 x 6); the rest is a Markov chain, so its precision has seven diagonals; theta,
patches and shapes form the border. One evaluation costs milliseconds where the dense matrix would cost tens.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import sparse
from scipy.linalg import get_lapack_funcs

from .pose_cells import SLIP, PoseLayout, PoseLinear

LOG_SHIFT, LOG_TURN, LOGIT_RHO, LOG_TIME, LOG_WALL, LOG_ETA, LOG_LEAN = range(7)
WALL_SCALES = (LOG_WALL, LOG_LEAN)
"""Of these the slips know nothing."""
MATERN_LENGTH_M = 1.5
"""Range of the wall's own shape."""
PATCH_NUGGET = 0.1
"""Share of a patch's variance that its neighbours know nothing about."""

_PBTRF, _PBTRS, _TBTRS, _POTRI = get_lapack_funcs(("pbtrf", "pbtrs", "tbtrs", "potri"), dtype=np.float64)

_ROUNDING = 1e-12
"""Of sums of some thousand terms, relative, with a margin of ten."""


@dataclass(frozen=True)
class Robustness:
    """What the last sweep thought of single cells and patches."""

    weights: Float[np.ndarray, " cells"]
    """Student-t weights, about 1 in the bulk."""
    inflation_m2: Float[np.ndarray, " patches"]
    """Extra variance of patches that the rest of the wall contradicts."""
    slip_inflation: Float[np.ndarray, "frames 6"]
    """Extra variance of the slips of displaced frames, m^2 and rad^2."""


def patch_precisions(
    layout: PoseLayout, phi: Float[np.ndarray, " 7"], kappa: float, robust: Robustness
) -> tuple[tuple[Float[np.ndarray, "_ _"], ...], float]:
    """Inverse prior covariance of the patches, plane by plane, and the log determinant of the covariance."""
    variance, lean = np.exp(2 * phi[[LOG_WALL, LOG_LEAN]])
    inverses, log_det = [], 0.0
    for members, distance in zip(layout.patches, layout.patch_distances_m, strict=True):
        scaled = np.sqrt(3) * distance / MATERN_LENGTH_M
        covariance = variance * (1 + scaled) * np.exp(-scaled) + kappa * (variance + lean)
        covariance.flat[:: len(members) + 1] += variance * PATCH_NUGGET + robust.inflation_m2[members]
        inverses.append(np.linalg.inv(covariance))
        log_det += float(np.linalg.slogdet(covariance)[1])
    return tuple(inverses), log_det


@dataclass(frozen=True)
class Elimination:
    """The slips taken out of the normal equations, and what it takes to get them back."""

    normal: Float[np.ndarray, "bordered bordered"]
    """Of (theta, patches, shapes, target) given the data alone, slips integrated; no prior on walls yet."""
    log_det: float
    gain: Float[np.ndarray, "frames 6 6"]
    """Covariance of the white part given everything else: K."""
    information: Float[np.ndarray, "frames 6 6"]
    """B^T D^-1 B: Lambda."""
    band: Float[np.ndarray, "7 unknowns"]
    """Cholesky factor of the chain, LAPACK lower band storage."""
    chain_scale: Float[np.ndarray, " 6"]
    cross: Float[np.ndarray, "frames 6 bordered"]
    """B^T D^-1 (A, Z, y)."""
    chain_cross: Float[np.ndarray, "unknowns bordered"]
    """The same for the chain in its own units, white part eliminated."""


@dataclass(frozen=True)
class PoseState:
    """One evaluation, with what is needed to read off the posterior."""

    log_likelihood: float
    border: Float[np.ndarray, " border"]
    """Posterior mean of (theta, patches, shapes)."""
    border_covariance: Float[np.ndarray, "border border"]
    slips: Float[np.ndarray, "frames 6"]
    """Posterior mean of every frame's slip."""
    variances_m2: Float[np.ndarray, " cells"]
    patch_precisions: tuple[Float[np.ndarray, "_ _"], ...]
    elimination: Elimination


def evaluate_pose(
    layout: PoseLayout,
    linear: PoseLinear,
    robust: Robustness,
    phi: Float[np.ndarray, " 7"],
    kappa: float,
    slips: Elimination | None = None,
) -> PoseState:
    """Log restricted likelihood up to a constant, and the posterior given phi.

    Args:
        layout, linear: the model.
        robust: weights of cells and patches, held fixed.
        phi: log sigma shift (m), log sigma turn (rad), logit rho, log T (frames), log wall (m), log eta (m),
            log lean (m).
        kappa: variance of an offset common to a face, as a share of the walls' own.
        slips: of an evaluation whose phi differs in nothing but the walls (`WALL_SCALES`): most of the work.
    """
    variances = (layout.cells.variances_m2 + np.exp(2 * phi[LOG_ETA])) / robust.weights
    if slips is None:
        slips = _eliminate_slips(layout, linear, variances, robust.slip_inflation, phi)
    precisions, patch_log_det = patch_precisions(layout, phi, kappa, robust)
    theta, size = len(layout.precision), len(slips.normal)
    shapes, n_shapes = theta + layout.n_patches, layout.shapes.shape[1]
    system = slips.normal[:-1, :-1].copy()
    system.flat[: theta * size : size] += layout.precision
    system.flat[shapes * size :: size] += np.exp(-2 * phi[LOG_LEAN])
    for members, precision in zip(layout.patches, precisions, strict=True):
        system[np.ix_(theta + members, theta + members)] += precision
    factor = np.linalg.cholesky(system)
    inverse, _ = _POTRI(factor, lower=1)
    covariance = np.tril(inverse) + np.tril(inverse, -1).T
    mean = covariance @ slips.normal[:-1, -1]
    quadratic = float(slips.normal[-1, -1] - slips.normal[:-1, -1] @ mean)
    log_det = slips.log_det + float(np.sum(np.log(variances))) + patch_log_det
    log_det += 2.0 * n_shapes * float(phi[LOG_LEAN])
    log_det += 2.0 * float(np.sum(np.log(np.diagonal(factor))))
    value = -0.5 * (log_det + quadratic)
    return PoseState(value, mean, covariance, _slip_means(slips, mean), variances, precisions, slips)


def _eliminate_slips(
    layout: PoseLayout,
    linear: PoseLinear,
    variances_m2: Float[np.ndarray, " cells"],
    slip_inflation: Float[np.ndarray, "frames 6"],
    phi: Float[np.ndarray, " 7"],
) -> Elimination:
    """White part frame by frame, then the chain."""
    frames = len(layout.frame_ids)
    sigma = np.repeat(np.exp(phi[[LOG_SHIFT, LOG_TURN]]), SLIP // 2)
    rho = 1.0 / (1.0 + np.exp(-phi[LOGIT_RHO]))
    scale = 1.0 / np.sqrt(variances_m2)
    columns = sparse.csr_matrix(sparse.diags(scale) @ linear.columns)
    normal = sparse.csr_matrix(columns.T @ columns).toarray()
    slip_matrix = sparse.csr_matrix(linear.slip_matrix @ sparse.diags(scale))
    cross = sparse.csr_matrix(slip_matrix @ columns).toarray().reshape(frames, SLIP, -1)
    information = _frame_information(layout, linear, variances_m2)

    # White part: K = S^1/2 (I + S^1/2 Lambda S^1/2)^-1 S^1/2, regular also where S vanishes.
    white = np.sqrt((1 - rho) * sigma**2 + slip_inflation)
    factor = np.linalg.cholesky(np.eye(SLIP) + white[:, :, None] * information * white[:, None, :])
    log_det = 2.0 * float(np.sum(np.log(np.diagonal(factor, axis1=1, axis2=2))))
    half = np.linalg.solve(factor, white[:, :, None] * np.eye(SLIP))
    gain = np.swapaxes(half, 1, 2) @ half
    keep = np.eye(SLIP) - information @ gain

    chain_scale = np.sqrt(rho) * sigma
    chain_cross = (chain_scale[:, None] * (keep @ cross)).reshape(SLIP * frames, -1)
    blocks = chain_scale[:, None] * (keep @ information) * chain_scale
    band, chain_log_det = _factor_chain(layout, float(np.exp(phi[LOG_TIME])), blocks)
    whitened, _ = _TBTRS(band, chain_cross, uplo="L")
    stacked = np.vstack([(half @ cross).reshape(SLIP * frames, -1), whitened])
    # The difference cancels to what the slips leave of the information; keep it above its own rounding.
    rounding = _ROUNDING * normal.diagonal()
    normal -= stacked.T @ stacked
    normal.flat[:: len(normal) + 1] += rounding
    return Elimination(
        normal, log_det + chain_log_det, gain, information, band, chain_scale, cross, chain_cross
    )


def _slip_means(slips: Elimination, border: Float[np.ndarray, " border"]) -> Float[np.ndarray, "frames 6"]:
    """Posterior mean of every slip, given the posterior mean of the border."""
    free = np.append(-border, 1.0)
    chain, _ = _PBTRS(slips.band, (slips.chain_cross @ free)[:, None], lower=1)
    drift = chain.reshape(-1, SLIP) * slips.chain_scale
    pull = slips.cross @ free - np.einsum("fab,fb->fa", slips.information, drift)
    return drift + np.einsum("fab,fb->fa", slips.gain, pull)


def _frame_information(
    layout: PoseLayout, linear: PoseLinear, variances_m2: Float[np.ndarray, " cells"]
) -> Float[np.ndarray, "frames 6 6"]:
    """Lambda_i = sum over the frame's cells of B^T B / D."""
    rows = linear.slip_rows
    products = rows[:, :, None] * (rows / variances_m2[:, None])[:, None, :]
    total = np.zeros((len(layout.frame_ids), SLIP, SLIP))
    np.add.at(total, layout.frame, products)
    return total


def _factor_chain(
    layout: PoseLayout, time_frames: float, blocks: Float[np.ndarray, "frames 6 6"]
) -> tuple[Float[np.ndarray, "7 unknowns"], float]:
    """Banded Cholesky of prior + data for the unit chain; log det of it times the prior's covariance."""
    decay = np.exp(-np.diff(layout.frame_ids) / time_frames)
    loss = -np.expm1(-2 * np.diff(layout.frame_ids) / time_frames)
    diagonal = np.ones(len(blocks))
    diagonal[:-1] += decay**2 / loss
    diagonal[1:] += decay**2 / loss
    full = blocks + diagonal[:, None, None] * np.eye(SLIP)
    size = SLIP * len(blocks)
    band = np.zeros((SLIP + 1, size))
    for below in range(SLIP):
        lanes = np.arange(SLIP - below)
        band[below].reshape(-1, SLIP)[:, lanes] = full[:, lanes + below, lanes]
    band[SLIP, : size - SLIP] = np.repeat(-decay / loss, SLIP)
    factor, info = _PBTRF(band, lower=1)
    if info != 0:
        # A precision plus information is positive definite; rounding can still win on noise-free scans.
        raise np.linalg.LinAlgError("the frames' normal equations are too stiff for double precision")
    return factor, 2.0 * float(np.sum(np.log(factor[0]))) + SLIP * float(np.sum(np.log(loss)))


def slip_covariances(state: PoseState) -> Float[np.ndarray, "frames 6 6"]:
    """Posterior covariance of every frame's slip, the uncertainty of theta and patches included."""
    slips, scale = state.elimination, state.elimination.chain_scale
    border_response, _ = _PBTRS(slips.band, slips.chain_cross[:, :-1], lower=1)
    result = np.empty_like(slips.gain)
    for i, gain in enumerate(slips.gain):
        rows = slice(SLIP * i, SLIP * (i + 1))
        unit = np.zeros((slips.band.shape[1], SLIP))
        unit[rows] = np.eye(SLIP)
        column, _ = _PBTRS(slips.band, unit, lower=1)
        # u = keep drift - K E z + const, and drift = scale (chain - response z).
        keep = (np.eye(SLIP) - gain @ slips.information[i]) * scale
        response = -keep @ border_response[rows] - gain @ slips.cross[i, :, :-1]
        drift = keep @ column[rows] @ keep.T
        result[i] = gain + drift + response @ state.border_covariance @ response.T
    return result
