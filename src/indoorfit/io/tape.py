"""Tables of tape and laser-meter readings: CSV and TOML, every row accounted for.

A row that cannot be used is no reason to lose the others, and none is left out in silence: it comes back
with its line and the reason.
"""

import csv
import hashlib
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..model import RefusedRow, TapeReading, TapeTable
from .tape_rows import COLUMNS, RowError, read_row, same_reading
from .text_names import printable_name

MAX_BYTES = 16_000_000
"""A hundred thousand readings. A larger file is no table of readings but a scan or a log by mistake."""
_MAX_LINE = 4096

_TOML_DEFAULTS = ("unit", "instrument", "std_mm", "scan")
_HEADER = re.compile(r"^[ \t]*\[\[[ \t]*reading[ \t]*\]\]", re.MULTILINE)
_POINTS = ("x1_m", "y1_m", "z1_m", "x2_m", "y2_m", "z2_m")


def read_tape(path: str | Path) -> TapeTable:
    """Read a table of readings, CSV (comma, semicolon or tab) or TOML.

    Args:
        path: the suffix ``.toml`` tells the format; anything else is CSV with a header line.

    Raises:
        InputError: the file is missing or larger than `MAX_BYTES`, has no header, or is no TOML. Rows that
            are wrong raise nothing: they are in `TapeTable.refused`.
    """
    path = Path(path)
    name = printable_name(path.name)
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise InputError(
                f"{name}: has {size / 1e6:.0f} MB; a table of readings has at most {MAX_BYTES / 1e6:.0f} MB. "
                "Fix: check that it is the table and not the scan."
            )
        content = path.read_bytes()
    except OSError as e:
        raise InputError(f"{name}: cannot be read: {e.strerror}. Fix: check the path.") from e
    rows = _toml_rows(content, name) if path.suffix.lower() == ".toml" else _csv_rows(content, name)
    readings: dict[tuple, TapeReading] = {}
    refused: list[RefusedRow] = []
    for line, fields in rows:
        try:
            if isinstance(fields, str):
                raise RowError(fields)
            reading = read_row(line, fields)
            first = readings.setdefault(same_reading(reading), reading)
            if first is not reading:
                raise RowError(
                    f"repeats line {first.line}. Fix: delete it; if the length was measured twice, number "
                    "the readings 1, 2, ... in the column 'reading'"
                )
        except RowError as error:
            refused.append(RefusedRow(line, str(error)))
    digest = hashlib.sha256(content).hexdigest()
    return TapeTable(name, digest, tuple(readings.values()), tuple(refused))


def _csv_rows(content: bytes, name: str) -> Iterator[tuple[int, dict[str, Any] | str]]:
    """Line number with the row's fields, or with what is wrong with the line as a whole.

    One line is one row: line breaks within quotes are refused, so that a lost quote costs one row only.
    """
    columns: list[str] | None = None
    delimiter = ","
    for number, raw in enumerate(content.removeprefix(b"\xef\xbb\xbf").splitlines(), start=1):
        if not raw.strip() or raw.lstrip().startswith(b"#"):
            continue
        line = raw[:_MAX_LINE].decode("utf-8", "replace")
        if columns is None:
            delimiter = next((mark for mark in ";\t" if mark in line), ",")
            columns = _columns(line, delimiter, name, number)
            continue
        yield number, _csv_fields(raw, columns, delimiter)
    if columns is None:
        raise InputError(
            f"{name}: holds no row; a header line is needed. Fix: see `indoorfit tape-template`."
        )


def _columns(line: str, delimiter: str, name: str, number: int) -> list[str]:
    columns = [title.strip().strip('"').lower() for title in line.split(delimiter)]
    wrong = [title for title in columns if title not in COLUMNS]
    if wrong or len(set(columns)) < len(columns) or not {"value", "unit"} <= set(columns):
        found = f"the column {wrong[0][:40]!r}" if wrong else f"the columns {', '.join(columns)[:200]}"
        raise InputError(
            f"{name}, line {number}: found {found}; a header with value, unit and what was measured "
            f"is needed, out of: {', '.join(COLUMNS)}. Fix: see `indoorfit tape-template`."
        )
    return columns


def _csv_fields(raw: bytes, columns: list[str], delimiter: str) -> dict[str, Any] | str:
    if len(raw) > _MAX_LINE:
        return f"is {len(raw)} bytes long, more than any reading"
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError:
        return "is not UTF-8 text. Fix: save the table as UTF-8"
    if "\0" in text:
        return "holds a zero byte. Fix: delete the line or type it again"
    try:
        values = next(csv.reader([text], delimiter=delimiter, strict=True))
    except csv.Error as e:
        return f"is no row of a table ({e})"
    if len(values) != len(columns):
        return f"has {len(values)} values; the header has {len(columns)}"
    if not any(value.strip() for value in values):
        return "is empty but for its separators"
    fields: dict[str, Any] = {
        column: value.strip() for column, value in zip(columns, values, strict=True) if value.strip()
    }
    if delimiter == ";":
        # Tables with semicolons come from places that write 5,08.
        for column in ("value", "std_mm", *_POINTS):
            if column in fields:
                fields[column] = fields[column].replace(",", ".")
    return fields


def _toml_rows(content: bytes, name: str) -> Iterator[tuple[int, dict[str, Any] | str]]:
    try:
        text = content.decode("utf-8-sig")
        document = tomllib.loads(text)
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as e:
        raise InputError(f"{name}: is not TOML: {e}. Fix: repair the file.") from e
    defaults = {key: value for key, value in document.items() if key in _TOML_DEFAULTS}
    entries = document.get("reading")
    wrong = [key for key in document if key != "reading" and key not in _TOML_DEFAULTS]
    if wrong or not isinstance(entries, list):
        found = f"the key {wrong[0][:40]!r}" if wrong else "no [[reading]]"
        raise InputError(
            f"{name}: found {found}; needed are tables [[reading]], and before them at most "
            f"{', '.join(_TOML_DEFAULTS)}. Fix: see docs/batch.md."
        )
    # TOML readers keep no lines: the k-th head is that of the k-th table, unless some are written inline.
    heads = [1 + text.count("\n", 0, match.start()) for match in _HEADER.finditer(text)]
    for k, entry in enumerate(entries):
        line = heads[k] if len(heads) == len(entries) else k + 1
        if not isinstance(entry, dict):
            yield line, "is no table of keys and values"
            continue
        yield line, _flat({**defaults, **entry})


def _flat(entry: dict[str, Any]) -> dict[str, Any] | str:
    """TOML may say `faces = [..]` and `points_m = [[..], [..]]` where CSV has columns."""
    fields = dict(entry)
    faces, points = fields.pop("faces", None), fields.pop("points_m", None)
    if faces is not None:
        if not isinstance(faces, list) or len(faces) != 2:
            return "faces: two ids are needed"
        fields["face_1"], fields["face_2"] = faces
    if points is not None:
        ends = points if isinstance(points, list) and len(points) == 2 else []
        flat = [x for end in ends for x in (end if isinstance(end, list) else [])]
        if len(flat) != 6:
            return "points_m: two points of three coordinates are needed"
        fields |= dict(zip(_POINTS, flat, strict=True))
    unknown = [key for key in fields if key not in COLUMNS]
    return f"has the unknown key {unknown[0][:40]!r}" if unknown else fields
