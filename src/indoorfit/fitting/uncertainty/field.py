"""Restricted likelihood of a Gaussian-process field on every plane, with theta integrated analytically.

    y = A theta + g + e,   g ~ tau^2 exp(-h / l) + tilt^2 q . q' within a plane,
    e_j ~ N(0, eta^2 + s_j^2 + x_j)

q is the place on the plane, from the middle of its cells: the second part is a rotation of the plane as a
whole, as of a wall that was seen from one badly registered place. Hyper-parameters are
phi = log(tau, l, eta, tilt), metres and radians. V is block-diagonal over the planes, so one evaluation is
a loop over small blocks. Source: Patterson and Thompson 1971 (REML).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.linalg import get_lapack_funcs

from .cells import Cells
from .location import ridge

LOG_TAU, LOG_LENGTH, LOG_ETA, LOG_TILT = 0, 1, 2, 3

# LAPACK directly: numpy's checks cost more than the factorisation of a wall's block.
_POTRF, _POTRI = get_lapack_funcs(("potrf", "potri"), dtype=np.float64)


@dataclass(frozen=True)
class Block:
    """The cells of one plane."""

    rows: Int[np.ndarray, " rows"]
    """Where they are among all cells."""
    columns: Int[np.ndarray, " columns"]
    """The parameters that these cells depend on, among the seen ones."""
    design: Float[np.ndarray, "rows columns"]
    """A = -d residual / d theta."""
    target_m: Float[np.ndarray, " rows"]
    distance_m: Float[np.ndarray, "rows rows"]
    lever_m2: Float[np.ndarray, "rows rows"]
    """Products of the places on the plane, counted from the middle of the cells, times `turn`."""
    variance_m2: Float[np.ndarray, " rows"]
    """s_j^2, what the points alone leave."""
    turn: float = 1.0
    """This plane's variance of the tilt over what is usual in the room."""


@dataclass(frozen=True)
class Field:
    """All blocks of a room."""

    blocks: tuple[Block, ...]
    seen: Bool[np.ndarray, " params"]
    precision: Float[np.ndarray, " seen"]
    """Prior precision of each seen parameter (the rotation's, tiny)."""
    n_cells: int


@dataclass(frozen=True)
class FieldFit:
    """One evaluation at one phi."""

    log_likelihood: float
    gradient: Float[np.ndarray, " 4"]
    step: Float[np.ndarray, " seen"]
    """Generalised least squares estimate of theta minus the linearisation point."""
    left_out_m: Float[np.ndarray, " cells"]
    """Leave-one-out residual: what is left of each cell after prediction from all others."""
    left_out_variance_m2: Float[np.ndarray, " cells"]
    """Its variance."""


def build_field(cells: Cells) -> Field:
    """Sort cells into blocks and precompute the distances."""
    seen = cells.seen
    design = -cells.design[:, seen]
    blocks = []
    for plane in np.unique(cells.plane):
        rows = np.flatnonzero(cells.plane == plane)
        columns = np.flatnonzero(np.any(design[rows] != 0.0, axis=0))
        centroids = cells.centroids_m[rows]
        within = cells.along_wall(rows)
        blocks.append(
            Block(
                rows,
                columns,
                design[np.ix_(rows, columns)],
                cells.residuals_m[rows],
                np.linalg.norm(centroids[:, None] - centroids[None], axis=2),
                within @ within.T,
                cells.variances_m2[rows],
            )
        )
    return Field(tuple(blocks), seen, ridge(cells.n_params)[seen], len(cells.plane))


def block_covariance(
    block: Block, phi: Float[np.ndarray, " 4"], inflation_m2: Float[np.ndarray, " cells"]
) -> Float[np.ndarray, "rows rows"]:
    """V of one plane, m^2."""
    scales = np.exp(phi)
    return _covariance(block, scales, _correlation(block, scales), inflation_m2)


def _correlation(block: Block, scales: Float[np.ndarray, "4 ..."]) -> Float[np.ndarray, "*draws rows rows"]:
    """The wandering part over its variance."""
    return np.exp(block.distance_m / -scales[LOG_LENGTH, ..., None, None])


def _covariance(
    block: Block,
    scales: Float[np.ndarray, "4 ..."],
    correlation: Float[np.ndarray, "*draws rows rows"],
    inflation_m2: Float[np.ndarray, " cells"],
) -> Float[np.ndarray, "*draws rows rows"]:
    """V of one plane, m^2, for one exp(phi) or many."""
    tau, _, eta, tilt = scales[..., None, None]
    covariance = tau**2 * correlation + tilt**2 * block.lever_m2
    # A view of the diagonals.
    np.einsum("...ii->...i", covariance)[...] += eta[..., 0] ** 2 + (
        block.variance_m2 + inflation_m2[block.rows]
    )
    return covariance


def _inverse(covariance: Float[np.ndarray, "rows rows"]) -> tuple[Float[np.ndarray, "rows rows"], float]:
    """Inverse and log determinant of a positive definite matrix."""
    factor, info = _POTRF(covariance, lower=1)
    if info != 0:
        # The bounds on phi keep the condition below 1e12; what remains is rounding: a relative ridge.
        jitter = 1e-10 * np.trace(covariance) * np.eye(len(covariance))
        factor, _ = _POTRF(covariance + jitter, lower=1)
    inverse, _ = _POTRI(factor, lower=1)
    lower = np.tril(inverse, -1)
    return lower + lower.T + np.diag(inverse.diagonal()), 2.0 * float(np.sum(np.log(factor.diagonal())))


def evaluate(
    field: Field, phi: Float[np.ndarray, " 4"], inflation_m2: Float[np.ndarray, " cells"]
) -> FieldFit:
    """Log restricted likelihood (up to a constant), its exact gradient, and the left-out residuals.

    Args:
        field: blocks of a room.
        phi: log of tau, l, eta in metres and tilt in radians.
        inflation_m2: x_j, extra variance of cells that the rest of the wall contradicts.
    """
    size = len(field.precision)
    normal, right = np.diag(field.precision), np.zeros(size)
    log_det = 0.0
    parts = []
    tau, length, eta, tilt = scales = np.exp(phi)
    for block in field.blocks:
        shape = _correlation(block, scales)
        inverse, block_log_det = _inverse(_covariance(block, scales, shape, inflation_m2))
        log_det += block_log_det
        weighted = inverse @ block.design
        target = inverse @ block.target_m
        normal[np.ix_(block.columns, block.columns)] += block.design.T @ weighted
        right[block.columns] += block.design.T @ target
        parts.append((shape, inverse, weighted, target))
    step_covariance, normal_log_det = _inverse(normal)
    step = step_covariance @ right

    quadratic = 0.0
    gradient = np.zeros(4)
    left_out, left_out_variance = np.empty(field.n_cells), np.empty(field.n_cells)
    for block, (shape, inverse, weighted, target) in zip(field.blocks, parts, strict=True):
        alpha = target - weighted @ step[block.columns]
        quadratic += float(block.target_m @ alpha)
        inner = step_covariance[np.ix_(block.columns, block.columns)]
        # d l / d phi = -1/2 tr[(P - alpha alpha^T) dV] with P = V^-1 - V^-1 A M^-1 A^T V^-1.
        sensitivity = inverse - weighted @ inner @ weighted.T - np.outer(alpha, alpha)
        product = sensitivity * shape
        gradient[LOG_TAU] -= tau**2 * product.sum()
        gradient[LOG_LENGTH] -= 0.5 * tau**2 / length * np.vdot(product, block.distance_m)
        gradient[LOG_ETA] -= eta**2 * np.trace(sensitivity)
        gradient[LOG_TILT] -= tilt**2 * np.vdot(sensitivity, block.lever_m2)
        left_out_variance[block.rows] = 1.0 / inverse.diagonal()
        left_out[block.rows] = alpha * left_out_variance[block.rows]
    value = -0.5 * (log_det + normal_log_det + quadratic)
    return FieldFit(value, gradient, step, left_out, left_out_variance)


def log_likelihoods(
    field: Field, phis: Float[np.ndarray, "draws 4"], inflation_m2: Float[np.ndarray, " cells"]
) -> tuple[
    Float[np.ndarray, " draws"], Float[np.ndarray, "draws seen"], Float[np.ndarray, "draws seen seen"]
]:
    """The same likelihood at many phi at once, with the estimate of theta and its covariance for each.

    Returns:
        log likelihoods, GLS steps, and their covariances (M^-1).
    """
    draws, size = len(phis), len(field.precision)
    normal = np.tile(np.diag(field.precision), (draws, 1, 1))
    right, log_det, quadratic = np.zeros((draws, size)), np.zeros(draws), np.zeros(draws)
    scales = np.exp(phis).T
    for block in field.blocks:
        factor = np.linalg.cholesky(_covariance(block, scales, _correlation(block, scales), inflation_m2))
        log_det += 2.0 * np.sum(np.log(np.diagonal(factor, axis1=1, axis2=2)), axis=1)
        stacked = np.column_stack([block.design, block.target_m])
        whitened = np.linalg.solve(factor, np.broadcast_to(stacked, (draws, *stacked.shape)))
        gram = np.swapaxes(whitened, 1, 2) @ whitened
        normal[:, block.columns[:, None], block.columns] += gram[:, :-1, :-1]
        right[:, block.columns] += gram[:, :-1, -1]
        quadratic += gram[:, -1, -1]
    step = np.linalg.solve(normal, right[..., None])[..., 0]
    quadratic -= np.sum(right * step, axis=1)
    values = -0.5 * (log_det + np.linalg.slogdet(normal)[1] + quadratic)
    return values, step, np.linalg.inv(normal)
