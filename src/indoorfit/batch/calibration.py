"""How far intervals are over- or under-confident, learnt from lengths whose references are known."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize_scalar
from scipy.special import ndtri
from scipy.stats import t as student

from indoorfit.errors import InputError

MIN_ROOMS = 5
"""Below it the uncertainty of the factor (a t distribution with rooms - 1 degrees of freedom) is a factor of
two either way: readings of so few rooms can test intervals, not calibrate them."""

LIKELY_DOFS = (3.0, 5.0, 10.0, 30.0, 300.0)
"""Tails that are tried: 3 is a room with gross errors, 300 is a normal distribution."""

_NARROWEST_M = 1e-6
"""An interval without width would make any error impossible; a micrometre is below all of them."""
_LARGEST = math.log(100.0)
"""An interval that must be a hundred times wider or narrower is not a matter of calibration."""


@dataclass(frozen=True)
class JudgedLength:
    """One length with a reference, as a batch's table holds it."""

    room: str
    error_m: float
    """Model minus reference."""
    half_m: float
    """Half of the model's interval, on the side of the reference."""
    level: float
    reference_std_m: float
    """Of the reference; 0 for an exact truth."""
    value_m: float = 0.0
    """The length itself."""
    data_share: float = 1.0
    """Share of the standard uncertainty that the scan's residuals account for; the rest, in quadrature, was
    added for the sensor's scale and the wall (`type_b`)."""
    sensor: str = ""
    kind: str = ""


@dataclass(frozen=True)
class Calibration:
    """The factor that intervals need, and how well it does in rooms that it was not learnt from."""

    factor: float
    """Maximum likelihood: intervals must be so many times as wide; below 1 they are too wide."""
    factor_low: float
    factor_high: float
    """95 % interval of the factor, rooms as independent witnesses."""
    dof: float
    """Degrees of freedom of the t distribution that fits the errors best; few mean gross errors."""
    n_lengths: int
    n_rooms: int
    level: float
    """Nominal coverage of the intervals."""
    held_before: float
    """Share of the references that the intervals hold, the reference's own uncertainty added to them."""
    held_after: float
    """The same with the factor, each room with the factor learnt from all others."""
    conformal: float | None
    """Factor with a guarantee: in a new room that is exchangeable with these, the interval of a length picked
    at random holds its reference with at least `level`. None with too few rooms."""
    conformal_rooms: int
    """Rooms that the guarantee needs at this level."""

    @property
    def says(self) -> str:
        """The verdict in one sentence."""
        if self.factor_low > 1.0:
            return "The intervals are too narrow."
        if self.factor_high < 1.0:
            return "The intervals are too wide."
        return "Nothing says that the intervals are wrong."


def calibrate(lengths: Sequence[JudgedLength], seed: int = 0) -> Calibration:
    """Estimate the factor on interval widths.

    An error is taken as t distributed with the scale sqrt((k U / q)² + u²): U the half width, q the quantile
    of that t distribution for the interval's level, u the reference's uncertainty, k the factor. Every room
    has one vote, whatever its number of lengths, for these share walls. The uncertainty is the jackknife's
    over rooms, which needs no independence within them.

    Args:
        lengths: of one configuration and one level.
        seed: decides which length of each room stands for it in the conformal factor.

    Raises:
        InputError: fewer than `MIN_ROOMS` rooms, or several levels.

    Source: K. L. Lange et al., Robust statistical modeling using the t distribution, J. Am. Stat. Assoc. 84
    (1989); B. Efron & C. Stein, The jackknife estimate of variance, Ann. Stat. 9 (1981).
    """
    rooms = sorted({length.room for length in lengths})
    if len(rooms) < MIN_ROOMS:
        raise InputError(
            f"calibrate: {len(lengths)} length(s) with a reference in {len(rooms)} room(s); at least "
            f"{MIN_ROOMS} rooms are needed. Fix: measure more; E_n and chi² of those there are test the "
            "intervals already."
        )
    levels = {length.level for length in lengths}
    if len(levels) > 1:
        found = ", ".join(f"{level:g}" for level in sorted(levels))
        raise InputError(f"calibrate: intervals of the levels {found}; one is needed. Fix: give --config.")
    data = JudgedData.of(lengths)
    log_factor, dof = _best(data, np.ones(len(rooms)))
    # Every room left out once: for the uncertainty, and for factors that their room had no part in.
    held_out = np.eye(len(rooms)) == 0.0
    without = np.array([log_factor_of(data, keep.astype(float), dof) for keep in held_out])
    n = len(rooms)
    std = math.sqrt((n - 1) / n * float(np.sum((without - without.mean()) ** 2)))
    reach = float(student.ppf(0.975, n - 1)) * std
    conformal, needed = conformal_factor(lengths, seed)
    return Calibration(
        factor=math.exp(log_factor),
        factor_low=math.exp(log_factor - reach),
        factor_high=math.exp(log_factor + reach),
        dof=dof,
        n_lengths=len(lengths),
        n_rooms=n,
        level=data.level,
        held_before=float(np.mean(held_by(data, data.half_m))),
        held_after=float(np.mean(held_by(data, np.exp(without)[data.room] * data.half_m))),
        conformal=conformal,
        conformal_rooms=needed,
    )


def calibrate_groups(
    lengths: Sequence[JudgedLength], by: Literal["sensor", "kind"], seed: int = 0
) -> dict[str, Calibration]:
    """`calibrate` for every sensor or every kind of length that has rooms enough, by name."""
    found = {}
    for name in sorted({getattr(length, by) for length in lengths}):
        own = [length for length in lengths if getattr(length, by) == name]
        if len({length.room for length in own}) >= MIN_ROOMS:
            found[name] = calibrate(own, seed)
    return found


@dataclass(frozen=True)
class JudgedData:
    """The lengths of one level as arrays."""

    error_m: Float[np.ndarray, " lengths"]
    half_m: Float[np.ndarray, " lengths"]
    reference_std_m: Float[np.ndarray, " lengths"]
    room: np.ndarray
    """Index of each length's room."""
    share: Float[np.ndarray, " lengths"]
    """One over the number of lengths in the room."""
    level: float
    value_m: Float[np.ndarray, " lengths"]
    data_half_m: Float[np.ndarray, " lengths"]
    """What the scan's residuals alone account for of `half_m`."""
    rooms: tuple[str, ...]

    @classmethod
    def of(cls, lengths: Sequence[JudgedLength]) -> "JudgedData":
        """Rooms in the order of their names."""
        rooms = sorted({length.room for length in lengths})
        room = np.array([rooms.index(length.room) for length in lengths])
        half_m = np.maximum([length.half_m for length in lengths], _NARROWEST_M)
        return cls(
            np.array([length.error_m for length in lengths]),
            half_m,
            np.array([length.reference_std_m for length in lengths]),
            room,
            1.0 / np.bincount(room)[room],
            lengths[0].level,
            np.array([length.value_m for length in lengths]),
            half_m * np.array([length.data_share for length in lengths]),
            tuple(rooms),
        )


def _best(data: JudgedData, votes: Float[np.ndarray, " rooms"]) -> tuple[float, float]:
    """Logarithm of the factor, and the tails, of the largest likelihood."""
    found = [(log_factor_of(data, votes, dof), dof) for dof in LIKELY_DOFS]
    return min(found, key=lambda pair: _loss(pair[0], data, votes, pair[1]))


def log_factor_of(data: JudgedData, votes: Float[np.ndarray, " rooms"], dof: float) -> float:
    """Logarithm of the factor of the largest likelihood, each room with its votes."""
    solved = minimize_scalar(
        _loss,
        bounds=(-_LARGEST, _LARGEST),
        args=(data, votes, dof),
        method="bounded",
        options={"xatol": 1e-6},
    )
    return float(solved.x)  # pyright: ignore[reportAttributeAccessIssue]


def _loss(log_factor: float, data: JudgedData, votes: Float[np.ndarray, " rooms"], dof: float) -> float:
    quantile = float(student.ppf(0.5 + 0.5 * data.level, dof))
    scale_m = np.hypot(math.exp(log_factor) * data.half_m / quantile, data.reference_std_m)
    weights = votes[data.room] * data.share
    return -float(weights @ (student.logpdf(data.error_m / scale_m, dof) - np.log(scale_m)))


def held_by(data: JudgedData, half_m: Float[np.ndarray, " lengths"]) -> np.ndarray:
    """Whether intervals of these half widths hold their references, whose uncertainty is added."""
    reference_m = float(ndtri(0.5 + 0.5 * data.level)) * data.reference_std_m
    return np.abs(data.error_m) <= np.hypot(half_m, reference_m)


def conformal_factor(lengths: Sequence[JudgedLength], seed: int) -> tuple[float | None, int]:
    """Split conformal factor from one length per room, and the number of rooms that it needs.

    One length stands for each room, so that the scores are exchangeable if the rooms are. The references'
    uncertainty is not taken out, which errs on the wide side.

    Args:
        lengths: of one level, at least one.
        seed: decides which length stands for its room.

    Source: V. Vovk, A. Gammerman & G. Shafer, Algorithmic Learning in a Random World (2005), 4; R. Dunn,
    L. Wasserman & A. Ramdas, Distribution-free prediction sets for two-layer hierarchical models, J. Am.
    Stat. Assoc. 118 (2023), subsampling once.
    """
    level = lengths[0].level
    # The smallest n with ceil((n + 1) level) <= n; the rounding guards against 0.95 / 0.05 = 18.999...
    needed = math.ceil(round(level / (1.0 - level), 9))
    rooms: dict[str, list[float]] = {}
    for length in sorted(lengths, key=lambda length: length.room):
        score = abs(length.error_m) / max(length.half_m, _NARROWEST_M)
        rooms.setdefault(length.room, []).append(score)
    if len(rooms) < needed:
        return None, needed
    rng = np.random.default_rng(seed)
    chosen = sorted(float(rng.choice(scores)) for scores in rooms.values())
    return chosen[math.ceil(round((len(rooms) + 1) * level, 9)) - 1], needed
