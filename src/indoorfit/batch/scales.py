"""The three noise scales of a sensor, learnt from lengths whose references are known."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize
from scipy.special import ndtri
from scipy.stats import chi2
from scipy.stats import t as student

from indoorfit.evaluate import interval_score

from .calibration import LIKELY_DOFS, JudgedData, JudgedLength, calibrate, held_by, log_factor_of

_LOWEST = (math.log(0.01), math.log(1e-6), math.log(1e-6))
_HIGHEST = (math.log(100.0), math.log(0.1), math.log(0.1))
"""Of the logarithms of factor, relative scale and definition in metres: beyond them a scan is broken, and a
micrometre, or one part in a million, is nothing."""
_NOTHING = 1e-5
"""A scale or a definition below ten micrometres (a metre) changes no interval that is ever read."""
_BELIEVED = math.log(3.0)
"""Standard deviation of what is believed of the factor's logarithm before any room is seen: where the other
two drown what the residuals show, the lengths say nothing of it, and it stays near 1."""
_HALVINGS = 11
"""Of the range in which the end of an interval is sought: to 1 % of the figure."""


@dataclass(frozen=True)
class Learnt:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class NoiseScales:
    """What the noise of a sensor is made of, and how well it does in rooms that it was not learnt from."""

    factor: Learnt
    """On what the scan's residuals show (`belief.inflation`)."""
    scale_std: Learnt
    """Relative standard uncertainty of all lengths (`type_b.scale_std`)."""
    definition_std_m: Learnt
    """Where the wall is (`type_b.definition_std_m`)."""
    dof: float
    """Degrees of freedom of the t distribution that fits the errors best."""
    n_rooms: int
    held: float
    """Share of references held, each room with the scales of the others, the references' own uncertainty
    added."""
    score_before_m: float
    """Mean interval score of the batch's intervals; smaller is better."""
    score_factor_m: float
    """The same with one factor on everything, each room with the factor of the others."""
    score_m: float
    """The same with these scales, each room with those of the others."""


def learn_scales(lengths: Sequence[JudgedLength]) -> NoiseScales:
    """Estimate the factor on the residuals' part, the relative scale error and the wall's definition.

    Half an interval is sqrt((k U)² + z² ((s L)² + c²)): U the half width that the residuals account for, L
    the length, z the normal quantile of the level. An error is taken as t distributed with the scale
    sqrt((half / q)² + u²): q that t distribution's quantile, u the reference's uncertainty. Maximum
    likelihood of k, s and c; each room has one vote. What the batch's own `type_b` had added is left out of
    U and so learnt anew. Rooms of much the same size cannot tell s from c; their intervals then say so.
    Those are by profile likelihood, in which a room counts as one error however many lengths it has.

    Args:
        lengths: of one configuration and one level.

    Raises:
        InputError: too few rooms, or several levels.

    Source: as for `calibrate`; the interval score is Gneiting and Raftery's (2007).
    """
    whole = calibrate(lengths)
    data = JudgedData.of(lengths)
    rooms = len(data.rooms)
    start = np.array([math.log(whole.factor), math.log(1e-3), math.log(1e-3)])
    fits = [(_best(data, np.ones(rooms), dof, start), dof) for dof in LIKELY_DOFS]
    best, dof = min(fits, key=lambda fit: _loss(fit[0], data, np.ones(rooms), fit[1]))
    held_out = np.eye(rooms) == 0.0
    without = np.array([_best(data, keep.astype(float), dof, best) for keep in held_out])
    factors = np.array([log_factor_of(data, keep.astype(float), whole.dof) for keep in held_out])
    half_m = _half_m(without[data.room], data)
    return NoiseScales(
        *(_learnt(which, best, data, dof) for which in range(3)),
        dof=dof,
        n_rooms=rooms,
        held=float(np.mean(held_by(data, half_m))),
        score_before_m=_score_m(data, data.half_m),
        score_factor_m=_score_m(data, np.exp(factors)[data.room] * data.half_m),
        score_m=_score_m(data, half_m),
    )


def _learnt(which: int, best: Float[np.ndarray, " 3"], data: JudgedData, dof: float) -> Learnt:
    """One of the three with the ends of its profile likelihood; 0 for what nothing speaks for."""
    votes = np.ones(len(data.rooms))
    limit = _loss(best, data, votes, dof) + 0.5 * float(chi2.ppf(0.95, 1))
    ends = []
    for beyond in (_LOWEST[which], _HIGHEST[which]):
        within, others = float(best[which]), best
        for k in range(_HALVINGS):
            if within == beyond:
                break
            # First whether the whole range is within; then halves of what is not known.
            value = beyond if k == 0 else 0.5 * (within + beyond)
            there = _best(data, votes, dof, others, (which, value))
            if _loss(there, data, votes, dof) > limit:
                beyond = value
            else:
                within, others = value, there
        ends.append(math.exp(0.5 * (within + beyond)))
    value, low, high = (0.0 if x < _NOTHING else x for x in (math.exp(best[which]), *ends))
    return Learnt(value, low, high)


def _best(
    data: JudgedData,
    votes: Float[np.ndarray, " rooms"],
    dof: float,
    start: Float[np.ndarray, " 3"],
    fixed: tuple[int, float] | None = None,
) -> Float[np.ndarray, " 3"]:
    """Logarithms of the largest likelihood; one of them may be held at a value."""
    bounds = list(zip(_LOWEST, _HIGHEST, strict=True))
    if fixed is not None:
        bounds[fixed[0]] = (fixed[1], fixed[1])
        start = start.copy()
        start[fixed[0]] = fixed[1]
    solved = minimize(_loss, start, args=(data, votes, dof), method="L-BFGS-B", bounds=bounds)
    return np.asarray(solved.x, float)


def _loss(
    logs: Float[np.ndarray, " 3"], data: JudgedData, votes: Float[np.ndarray, " rooms"], dof: float
) -> float:
    quantile = float(student.ppf(0.5 + 0.5 * data.level, dof))
    half_m = _half_m(np.tile(logs, (len(data.room), 1)), data)
    scale_m = np.hypot(half_m / quantile, data.reference_std_m)
    weights = votes[data.room] * data.share
    likely = float(weights @ (student.logpdf(data.error_m / scale_m, dof) - np.log(scale_m)))
    return 0.5 * (float(logs[0]) / _BELIEVED) ** 2 - likely


def _half_m(logs: Float[np.ndarray, "lengths 3"], data: JudgedData) -> Float[np.ndarray, " lengths"]:
    """Half widths with these scales, as the fit makes them of its settings."""
    factor, scale, definition_m = np.exp(logs).T
    added_m = np.hypot(scale * data.value_m, definition_m)
    return np.hypot(factor * data.data_half_m, float(ndtri(0.5 + 0.5 * data.level)) * added_m)


def _score_m(data: JudgedData, half_m: Float[np.ndarray, " lengths"]) -> float:
    score_m = interval_score(data.error_m - half_m, data.error_m + half_m, np.zeros(len(half_m)), data.level)
    return float(np.mean(score_m))
