"""Quantities with their uncertainty, and the same result at another level of confidence."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from indoorfit.errors import ConfigError
from indoorfit.model import (
    STANDARD_LEVELS,
    Budget,
    FitResult,
    Interval,
    LoaClass,
    Prediction,
    Quantity,
    Room,
    Spread,
)

_LOA_LIMITS_M: tuple[tuple[float, LoaClass], ...] = (
    (0.001, "LOA50"),
    (0.005, "LOA40"),
    (0.015, "LOA30"),
    (0.050, "LOA20"),
)
_LOA_LEVEL = 0.95


class ExactPrediction:
    """What is known of exact values: a `model.Prediction` whose intervals have no width."""

    def __init__(self, values: Float[np.ndarray, " measurands"]) -> None:
        self._values = values

    def at(self, level: float) -> Spread:
        """The values themselves as both ends."""
        none = np.zeros_like(self._values)
        return Spread(level, self._values, self._values, none, none, none, none, none + np.inf)


def loa_classes(values: Float[np.ndarray, " n"], prediction: Prediction) -> tuple[LoaClass, ...]:
    """Level of Accuracy of the first measurands, which are lengths in metres.

    Source: U.S. Institute of Building Documentation, C120, Level of Accuracy specification: bands of the
    uncertainty at 95 %. An interval that is not symmetric counts with its longer side.
    """
    spread = prediction.at(_LOA_LEVEL)
    n = len(values)
    halves_m = np.maximum(values - spread.low[:n], spread.high[:n] - values)
    return tuple(_loa_class(float(half_m)) for half_m in halves_m)


def _loa_class(half_m: float) -> LoaClass:
    for limit_m, name in _LOA_LIMITS_M:
        if half_m <= limit_m:
            return name
    return "LOA10"


def quantities(
    values: Float[np.ndarray, " measurands"], prediction: Prediction, level: float
) -> tuple[Quantity, ...]:
    """Every measurand with its interval at one level, its budget, and the standard levels."""
    wanted = prediction.at(level)
    standard = [_intervals(values, prediction.at(each)) for each in STANDARD_LEVELS]
    budgets = zip(wanted.data_std, wanted.scale_std, wanted.definition_std, wanted.effective_dof, strict=True)
    return tuple(
        Quantity(float(value), float(std), interval, Budget(*map(float, budget)), tuple(others))
        for value, std, interval, budget, *others in zip(
            values, wanted.std, _intervals(values, wanted), budgets, *standard, strict=True
        )
    )


def _intervals(values: Float[np.ndarray, " measurands"], spread: Spread) -> tuple[Interval, ...]:
    """The spread's intervals; those of lengths, areas and volumes end at 0, below which nothing is built.

    Plane offsets are given as 0, and may be anything.
    """
    lows = np.where(values > 0.0, np.maximum(spread.low, 0.0), spread.low)
    return tuple(
        Interval(spread.level, float(low), float(high)) for low, high in zip(lows, spread.high, strict=True)
    )


def at_level(result: FitResult, level: float) -> FitResult:
    """The same result with all its intervals at another level; nothing is fitted again.

    Args:
        result: of a fit, or read from a file, which holds the standard levels and its own.
        level: nominal coverage, between 0 and 1.

    Raises:
        ConfigError: the level is impossible, or not among those that a file holds.
    """
    if not 0.0 < level < 1.0:
        raise ConfigError(f"level: got {level}; needed between 0 and 1. Fix: write 0.95 for 95 %.")
    n_dimensions = len(result.dimensions)
    old = [d.quantity for d in result.dimensions]
    old += [q for room in result.rooms for q in (room.floor_area, room.volume, room.perimeter)]
    if result.prediction is None:
        new = [replace(quantity, interval=_stored(quantity, level)) for quantity in old]
    else:
        spread = result.prediction.at(level)
        # After these come the plane offsets, whose standard uncertainty has no level.
        values = np.zeros_like(spread.low)
        values[: len(old)] = [quantity.value for quantity in old]
        found = _intervals(values, spread)[: len(old)]
        new = [replace(quantity, interval=interval) for quantity, interval in zip(old, found, strict=True)]
    rooms = [new[k : k + 3] for k in range(n_dimensions, len(new), 3)]
    return replace(
        result,
        level=level,
        dimensions=tuple(
            replace(dimension, quantity=quantity)
            for dimension, quantity in zip(result.dimensions, new[:n_dimensions], strict=True)
        ),
        rooms=tuple(map(_room, result.rooms, rooms)),
    )


def _room(room: Room, quantities: Sequence[Quantity]) -> Room:
    floor_area, volume, perimeter = quantities
    return replace(room, floor_area=floor_area, volume=volume, perimeter=perimeter)


def _stored(quantity: Quantity, level: float) -> Interval:
    held = (quantity.interval, *quantity.intervals)
    for interval in held:
        if interval.level == level:
            return interval
    levels = ", ".join(f"{each:g}" for each in sorted({interval.level for interval in held}))
    raise ConfigError(
        f"level: got {level:g}; a model read from a file has {levels} only. "
        "Fix: choose one of these, or fit the scan again."
    )
