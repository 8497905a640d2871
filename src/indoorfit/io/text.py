"""Reading points as plain text: xyz, txt, csv, pts and asc.

Columns are taken by the names of a header line, if there is one (``x y z``, colours as ``r g b`` or
``red green blue``, ``frame``; also behind ``#`` or ``//``, as CloudCompare writes it). Without names:

- columns 1 to 3 are x, y, z;
- 7 columns are x y z intensity r g b (the .pts order) if the last three can be colours, else
  x y z r g b and something;
- 6 or more than 7 columns have their colours in columns 4 to 6, else 5 to 7, else 7 to 9, whichever
  comes first that can be colours;
- columns can be colours if they hold integers from 0 to 255, or (6 and 7 columns only) numbers from
  0 to 1. Other columns are ignored. Where both orders of 7 columns fit, a note says which was taken.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import InputError
from ..model import Note
from .raw import RawCloud, cloud_from_columns
from .table import TableLayout, open_text, read_table, split_row

_COMMENTS = ("#", "//")
_MAX_LINE = 1 << 16
_FIX = "Fix: delete the line, or write one point per line as 'x y z' or 'x y z r g b'."


@dataclass(frozen=True)
class _Preamble:
    layout: TableLayout
    names: tuple[str, ...] | None
    promised: int | None
    """Point count that a .pts file begins with."""


def read_text(path: Path) -> RawCloud:
    """The points of a text file.

    Raises:
        InputError: a line does not fit (with its number), fewer points than promised, binary data.
    """
    found = _read_preamble(path)
    table = read_table(path, found.layout)
    notes: list[Note] = []
    if found.promised is not None and len(table) != found.promised:
        counts = f"the first line promises {found.promised} points, the file holds {len(table)}"
        if len(table) < found.promised:
            raise InputError(f"{path.name}: {counts}; it is cut off. Fix: copy or export the scan again.")
        notes.append(Note("COUNT_MISMATCH", f"In {path.name} {counts}; all were read."))
    names, name_notes = _column_names(table, found.names)
    columns = {name: table[:, index] for index, name in enumerate(names) if name}
    raw = cloud_from_columns(path.name, columns)
    return RawCloud(raw.points, raw.colours, raw.frame_ids, False, (*notes, *name_notes, *raw.notes))


def looks_like_text(head: bytes) -> bool:
    """Whether a file of unknown extension begins like lines of numbers."""
    if b"\0" in head:
        return False
    for line in head.decode("latin-1").splitlines()[:20]:
        values = [value for value in re.split(r"[\s,;]+", line.strip()) if value]
        if len(values) >= 3 and all(_is_number(value) for value in values[:3]):
            return True
    return False


def _read_preamble(path: Path) -> _Preamble:
    """Everything up to the first row of numbers, which decides how all rows are split."""
    remark: str | None = None
    header: str | None = None
    promised: int | None = None
    with open_text(path) as file:
        number = 0
        while line := file.readline(_MAX_LINE):
            number += 1
            if "\0" in line or len(line) == _MAX_LINE:
                raise InputError(
                    f"{path.name}, line {number}: found binary data; lines of numbers are needed. "
                    "Fix: give the file the extension of its real format."
                )
            stripped = line.strip()
            if not stripped:
                continue
            if stripped.startswith(_COMMENTS):
                remark = stripped.lstrip("#/ \t")
            elif re.fullmatch("[0-9]+", stripped) and promised is None and header is None:
                promised = int(stripped)
            elif _is_number(split_row(stripped, _delimiter(stripped))[0].replace(",", ".")):
                return _preamble(path.name, number, stripped, (header, remark), promised)
            elif header is None:
                header = stripped
            else:
                raise InputError(
                    f"{path.name}, line {number}: found {stripped[:40]!r}; a point is needed. {_FIX}"
                )
    return _Preamble(TableLayout(3, comments=_COMMENTS), None, promised)


def _preamble(
    where: str, number: int, row: str, headers: tuple[str | None, str | None], promised: int | None
) -> _Preamble:
    delimiter = _delimiter(row)
    columns = len(split_row(row, delimiter))
    if columns < 3:
        raise InputError(f"{where}, line {number}: found {columns} values; x, y and z are needed. {_FIX}")
    header, remark = headers
    names = None
    if header is not None:
        names = _names(header, delimiter)
        if len(names) != columns:
            raise InputError(
                f"{where}, line {number}: found {columns} values under a header of {len(names)} names; "
                "equal numbers are needed. Fix: repair or delete the header line."
            )
    elif remark is not None:
        # A remark is a header only if it looks like one.
        remark_names = _names(remark, delimiter)
        if len(remark_names) == columns and {"x", "y", "z"} <= set(remark_names):
            names = remark_names
    comma = delimiter == ";" and "," in row
    layout = TableLayout(columns, number - 1, None, delimiter, comma, _COMMENTS)
    return _Preamble(layout, names, promised)


def _delimiter(line: str) -> str | None:
    return next((mark for mark in ";," if mark in line), None)


def _names(line: str, delimiter: str | None) -> tuple[str, ...]:
    # Headers are often separated otherwise than the rows below them; units as in 'x [m]' are dropped.
    text = re.sub(r"[\[(][^\])]*[\])]", "", line)
    parts = split_row(text, delimiter if delimiter is not None and delimiter in text else _delimiter(text))
    return tuple(part.strip("\"' ").lower() for part in parts)


def _column_names(
    table: Float[np.ndarray, "rows columns"], names: tuple[str, ...] | None
) -> tuple[tuple[str, ...], tuple[Note, ...]]:
    """A name for each column, empty for those that are ignored."""
    if names is not None and {"x", "y", "z"} <= set(names):
        return names, ()
    n_columns = table.shape[1]
    candidates = {7: (4, 3)}.get(n_columns, tuple(at for at in (3, 4, 6) if at + 3 <= n_columns))
    fitting = [at for at in candidates if _can_be_colours(table[:, at : at + 3], n_columns in (6, 7))]
    named = ["x", "y", "z", *[""] * (n_columns - 3)]
    if fitting:
        named[fitting[0] : fitting[0] + 3] = ["red", "green", "blue"]
    notes: tuple[Note, ...] = ()
    if names is not None or (n_columns == 7 and len(fitting) == 2):
        colours = f"{fitting[0] + 1} to {fitting[0] + 3}" if fitting else "none"
        text = (
            f"The {n_columns} columns have no names that say x, y and z or where the colours are; taken "
            f"were 1 to 3 as coordinates, colours: {colours}. A header line with names settles it."
        )
        notes = (Note("COLUMNS_ASSUMED", text),)
    return tuple(named), notes


def _can_be_colours(values: Float[np.ndarray, "rows 3"], unit_scale: bool) -> bool:
    known = values[np.isfinite(values)]
    if known.size == 0 or known.min() < 0:
        return False
    if known.max() <= 1:
        return unit_scale
    return bool(known.max() <= 255 and np.array_equal(known, np.rint(known)))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
