"""A model against readings of a tape or laser meter.

Source of E_n and its limit: ISO/IEC 17043; of the combination: JCGM 100:2008 (GUM), 5.1.2 and 5.2.2.
"""

import math
from collections.abc import Sequence
from statistics import NormalDist

import numpy as np
from jaxtyping import Float
from scipy.special import chdtrc

from indoorfit.model import (
    Dimension,
    FitResult,
    Note,
    RefusedRow,
    TapeCheck,
    TapeReading,
    TapeTable,
    TapeVerdict,
)

from .tape_matching import find_dimension

CONTRADICTION_P = 0.01
"""Below this probability the readings contradict the intervals: one sound room in a hundred is accused."""
_LEVEL = 0.95
_Z95 = NormalDist().inv_cdf(0.5 + 0.5 * _LEVEL)
_SHOWN = 3


def check_tape(result: FitResult, table: TapeTable, scan: str | None = None) -> TapeVerdict:
    """Compare every reading with the dimension that it is of.

    Args:
        result: the model.
        table: readings; rows of other scans are passed over (a batch has one table for all).
        scan: the name by which the table knows this scan; by default the name in the provenance, with or
            without its suffix. Rows that name no scan are always taken.

    Returns:
        one check for each dimension with readings, and every row that fits nothing, with the reason.
    """
    names = {scan} if scan is not None else _own_names(result)
    by_dimension: dict[str, list[TapeReading]] = {}
    refused = list(table.refused)
    for reading in table.readings:
        if reading.scan is not None and reading.scan not in names:
            if scan is None:
                told = " or ".join(sorted(names)) or "without a name"
                refused.append(
                    RefusedRow(reading.line, f"is for the scan {reading.scan[:80]!r}; this is {told}")
                )
            continue
        found = find_dimension(result, reading)
        if isinstance(found, str):
            refused.append(RefusedRow(reading.line, found))
        else:
            by_dimension.setdefault(found.id, []).append(reading)
    measured = [d for d in result.dimensions if d.id in by_dimension]
    checks = tuple(_check(d, by_dimension[d.id]) for d in measured)
    chi2, p_value = _together(result, measured, checks)
    refused.sort(key=lambda row: row.line)
    return TapeVerdict(table.name, table.sha256, checks, tuple(refused), chi2, p_value)


def _own_names(result: FitResult) -> set[str]:
    source = result.provenance.get("input")
    name = source.get("name") if isinstance(source, dict) else None
    return {name, name.rpartition(".")[0] or name} if isinstance(name, str) and name else set()


def combine(readings: Sequence[TapeReading]) -> tuple[float, float]:
    """One value and its standard uncertainty from all readings of a length, metres.

    Readings with the same instrument share its error, so their mean is no more certain than one of them, and
    less so where they scatter more than their uncertainty says. Instruments err independently: their means
    are weighted by 1/u².
    """
    values, stds = [], []
    for instrument in sorted({reading.instrument for reading in readings}):
        own = [reading for reading in readings if reading.instrument == instrument]
        lengths = np.array([reading.value_m for reading in own])
        scatter = float(np.std(lengths, ddof=1)) if len(own) > 1 else 0.0
        values.append(float(lengths.mean()))
        stds.append(max(scatter, *(reading.std_m for reading in own)))
    weights = 1.0 / np.square(stds)
    return float(weights @ np.array(values) / weights.sum()), float(1.0 / math.sqrt(weights.sum()))


def expanded_m(dimension: Dimension, towards_m: float) -> float:
    """Half of the dimension's interval at 95 %, metres, on the side where another value lies.

    Where only an interval of another level is known, it is scaled as a normal one would be.
    """
    quantity = dimension.quantity
    known = (interval for interval in quantity.intervals if interval.level == _LEVEL)
    interval = next(known, quantity.interval)
    half_m = interval.high - quantity.value if towards_m > quantity.value else quantity.value - interval.low
    return max(half_m, 0.0) * _Z95 / NormalDist().inv_cdf(0.5 + 0.5 * interval.level)


def _check(dimension: Dimension, readings: Sequence[TapeReading]) -> TapeCheck:
    value_m, std_m = combine(readings)
    deviation_m = dimension.quantity.value - value_m
    interval = dimension.quantity.interval
    return TapeCheck(
        dimension=dimension.id,
        lines=tuple(reading.line for reading in readings),
        value_m=value_m,
        std_m=std_m,
        deviation_m=deviation_m,
        e_n=abs(deviation_m) / math.hypot(expanded_m(dimension, value_m), _Z95 * std_m),
        holds=interval.low <= value_m <= interval.high,
    )


def _together(
    result: FitResult, measured: Sequence[Dimension], checks: Sequence[TapeCheck]
) -> tuple[float, float]:
    """Chi squared of all deviations at once, and its probability.

    Lengths that share a wall err together. Standard deviations are those of the intervals (half width at 95 %
    over 1.96), which are wider than `std` where the distribution has heavy tails.
    """
    if not checks:
        return 0.0, 1.0
    rows = np.zeros((len(measured), len(result.shape.planes)))
    for row, dimension in zip(rows, measured, strict=True):
        first, second = (result.face(face).plane for face in dimension.faces)
        row[first], row[second] = -1.0, 1.0
    covariance = rows @ _plane_covariance(result) @ rows.T
    own = np.sqrt(np.maximum(np.diag(covariance), 1e-24))
    stds = np.array([expanded_m(d, c.value_m) / _Z95 for d, c in zip(measured, checks, strict=True)])
    total = covariance * np.outer(stds / own, stds / own) + np.diag([check.std_m**2 for check in checks])
    deviations = np.array([check.deviation_m for check in checks])
    chi2 = float(deviations @ np.linalg.solve(total, deviations))
    return chi2, float(chdtrc(len(checks), chi2))


def _plane_covariance(result: FitResult) -> Float[np.ndarray, "planes planes"]:
    """As the fit left it; a model from elsewhere has independent planes."""
    if result.plane_covariance_m2 is not None:
        return result.plane_covariance_m2
    stds = np.zeros(len(result.shape.planes))
    for face in result.faces:
        stds[face.plane] = face.offset_std_m
    return np.diag(np.square(stds))


def tape_notes(verdict: TapeVerdict) -> tuple[Note, ...]:
    """What the reader of the numbers must know of the comparison."""
    notes = []
    if verdict.p_value < CONTRADICTION_P:
        worst = max(verdict.checks, key=lambda check: check.e_n)
        notes.append(
            Note(
                "TAPE_CONTRADICTS",
                f"The readings in {verdict.source} contradict the intervals: chi² {verdict.chi2:.1f} for "
                f"{len(verdict.checks)} length(s), probability {verdict.p_value:.1g}. Farthest off is "
                f"{worst.dimension}: model - tape {1e3 * worst.deviation_m:+.0f} mm, E_n {worst.e_n:.1f}. "
                "Measure it again; if the reading stands, do not rely on the intervals of this scan.",
            )
        )
    if verdict.refused:
        said = "; ".join(f"line {row.line} {row.reason}" for row in verdict.refused[:_SHOWN])
        more = len(verdict.refused) - _SHOWN
        rest = f"; and {more} more, all in model.json under tape" if more > 0 else ""
        notes.append(
            Note(
                "TAPE_ROWS_REFUSED",
                f"{len(verdict.refused)} row(s) of {verdict.source} were not used: {said}{rest}.",
            )
        )
    return tuple(notes)
