"""One row of a table of readings, checked."""

import math
from typing import Any, get_args

from ..errors import ConfigError
from ..model import Instrument, TapeReading
from .units import metres_per_unit

COLUMNS = (
    "scan", "dimension", "face_1", "face_2", "x1_m", "y1_m", "z1_m", "x2_m", "y2_m", "z2_m",
    "value", "unit", "std_mm", "instrument", "reading", "remark",
)  # fmt: skip

DEFAULT_STD_M: dict[Instrument, float] = {"tape": 0.005, "laser": 0.0015}
"""Standard uncertainty of one reading. Tape: sag, hook and finding the two ends of a room's length with one
hand; the tape itself (class II: 1 mm over 3 m) is a small part. Laser meter: a data sheet's 1.5 mm."""

LONGEST_M = 1000.0
"""No laser meter reaches further; beyond it the unit is wrong."""

_COORDINATES = ("x1_m", "y1_m", "z1_m", "x2_m", "y2_m", "z2_m")


class RowError(Exception):
    """What is wrong with one row, as a phrase that follows `line 7`."""


def read_row(line: int, fields: dict[str, Any]) -> TapeReading:
    """The reading of one row.

    Args:
        line: where it stands.
        fields: by column; empty ones left out. Text, or typed values where the file has types.

    Raises:
        RowError: something is missing or wrong.
    """
    if fields.get("value") in (None, ""):
        raise RowError("has no value (not measured)")
    instrument = _instrument(fields)
    value_m = _value_m(fields)
    faces = _faces(fields)
    points = _points(fields)
    dimension = None if fields.get("dimension") is None else str(fields["dimension"])
    if dimension is None and faces is None and points is None:
        raise RowError("does not say what was measured: a dimension, two faces or two points are needed")
    return TapeReading(
        line=line,
        value_m=value_m,
        std_m=_std_m(fields, instrument),
        instrument=instrument,
        scan=None if fields.get("scan") is None else str(fields["scan"]),
        dimension=dimension,
        faces=faces,
        points_m=points,
        number=_count(fields),
    )


def same_reading(reading: TapeReading) -> tuple:
    """What two rows share if one is a copy of the other.

    Without a number, readings of one length that differ are repetitions and equal ones are copies.
    """
    what = (reading.scan, reading.dimension, reading.faces, reading.points_m, reading.instrument)
    return (*what, reading.number, reading.value_m if reading.number is None else None)


def _instrument(fields: dict[str, Any]) -> Instrument:
    given = str(fields.get("instrument", "tape")).lower()
    for known in get_args(Instrument):
        if given == known:
            return known
    raise RowError(f"instrument: got {given[:40]!r}; needed is tape or laser")


def _value_m(fields: dict[str, Any]) -> float:
    value = _number(fields, "value")
    unit = fields.get("unit")
    if unit is None:
        raise RowError("has no unit; needed is m, cm, mm, ft or in")
    try:
        value_m = value * metres_per_unit(str(unit))
    except ConfigError:
        raise RowError(f"unit: got {str(unit)[:40]!r}; needed is m, cm, mm, ft or in") from None
    if not 0.0 < value_m <= LONGEST_M:
        raise RowError(f"value: got {value:g} {unit}; a length above 0 and up to {LONGEST_M:g} m is needed")
    return value_m


def _std_m(fields: dict[str, Any], instrument: Instrument) -> float:
    if fields.get("std_mm") is None:
        return DEFAULT_STD_M[instrument]
    std_mm = _number(fields, "std_mm")
    if not 0.0 < std_mm <= 1000.0:
        raise RowError(f"std_mm: got {std_mm:g}; needed is above 0 and up to 1000")
    return 1e-3 * std_mm


def _faces(fields: dict[str, Any]) -> tuple[str, str] | None:
    first, second = fields.get("face_1"), fields.get("face_2")
    if first is None and second is None:
        return None
    if first is None or second is None:
        raise RowError("names one face; a length has two")
    if first == second:
        raise RowError(f"names {str(first)[:40]} twice; a length has two faces")
    return str(first), str(second)


def _points(fields: dict[str, Any]) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None:
    given = [name for name in _COORDINATES if fields.get(name) is not None]
    if not given:
        return None
    if len(given) < len(_COORDINATES):
        missing = [name for name in _COORDINATES if name not in given]
        raise RowError(f"has no {missing[0]}; two points have six coordinates")
    x1, y1, z1, x2, y2, z2 = (_number(fields, name) for name in _COORDINATES)
    return (x1, y1, z1), (x2, y2, z2)


def _count(fields: dict[str, Any]) -> int | None:
    given = fields.get("reading")
    if given is None:
        return None
    number = _number(fields, "reading")
    if number != int(number) or number < 1:
        raise RowError(f"reading: got {given!r}; needed is 1, 2, 3, ...")
    return int(number)


def _number(fields: dict[str, Any], name: str) -> float:
    given = fields[name]
    try:
        # Python reads 1_000 as a thousand; no other program does. And true is not 1.
        if isinstance(given, bool) or (isinstance(given, str) and "_" in given):
            raise ValueError
        number = float(given)
    except (TypeError, ValueError, OverflowError):
        raise RowError(f"{name}: got {str(given)[:40]!r}; a number is needed") from None
    if not math.isfinite(number):
        raise RowError(f"{name}: got {str(given)[:40]!r}; a finite number is needed")
    return number
