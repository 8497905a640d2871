"""Readings of a tape or laser meter, and what they say of a model."""

from dataclasses import dataclass
from typing import Literal

Instrument = Literal["tape", "laser"]
Point = tuple[float, float, float]


@dataclass(frozen=True)
class TapeReading:
    """One reading of one length. Which length: by id, by its two faces, or by two points near its ends."""

    line: int
    """Line of the file that it stands in, from 1."""
    value_m: float
    std_m: float
    """Standard uncertainty of this one reading."""
    instrument: Instrument
    scan: str | None = None
    """Name of the scan that it belongs to; None where the whole table belongs to one."""
    dimension: str | None = None
    """Id of the dimension."""
    faces: tuple[str, str] | None = None
    """Ids of the two faces, in any order."""
    points_m: tuple[Point, Point] | None = None
    """Scan frame, each near one of the two faces."""
    number: int | None = None
    """Which of several readings of the same length this is; None where it was not said."""


@dataclass(frozen=True)
class RefusedRow:
    """A row that could not be used, and why."""

    line: int
    reason: str


@dataclass(frozen=True)
class TapeTable:
    """Everything that a file of readings holds: every row with content is in one of the two lists."""

    name: str
    """Name of the file, never its full path."""
    sha256: str
    readings: tuple[TapeReading, ...]
    refused: tuple[RefusedRow, ...]


@dataclass(frozen=True)
class TapeCheck:
    """One dimension of a model against all readings of it."""

    dimension: str
    lines: tuple[int, ...]
    """Lines of the readings that were combined."""
    value_m: float
    """Combined reading."""
    std_m: float
    """Standard uncertainty of the combined reading."""
    deviation_m: float
    """Model minus tape."""
    e_n: float
    """|deviation| / sqrt(U² + U_tape²), both expanded to 95 %; up to 1 the two agree (ISO/IEC 17043)."""
    holds: bool
    """Whether the model's interval, at its own level, holds the combined reading."""


@dataclass(frozen=True)
class TapeVerdict:
    """A model against a table of readings."""

    source: str
    sha256: str
    checks: tuple[TapeCheck, ...]
    """In the order of the model's dimensions."""
    refused: tuple[RefusedRow, ...]
    """Rows that were not used, those of the file and those that fit nothing in the model, by line."""
    chi2: float
    """Sum of squared deviations over their variances, with the correlations of the model's lengths."""
    p_value: float
    """Probability of a `chi2` at least as large if the intervals are right; 1 without any check."""
