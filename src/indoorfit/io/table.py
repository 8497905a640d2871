"""Rows of numbers in a text file, fast where they are sound and exact about the line where not."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import InputError


@dataclass(frozen=True)
class TableLayout:
    """Where the rows are in the file and how their values are told apart."""

    columns: int
    """Values per row."""
    skip_lines: int = 0
    """Lines before the first row."""
    max_rows: int | None = None
    """Rows to read; None for all."""
    delimiter: str | None = None
    """One character; None for any run of blanks and tabs."""
    decimal_comma: bool = False
    """Values are written as 1,5."""
    comments: tuple[str, ...] = ()
    """What starts a remark that runs to the end of its line."""


def open_text(path: Path):
    """The file as text lines. Latin-1 maps every byte, so a remark in any encoding cannot stop us."""
    return open(path, encoding="latin-1")


def read_table(path: Path, layout: TableLayout) -> Float[np.ndarray, "rows columns"]:
    """All rows; blank lines and remarks are skipped.

    Raises:
        InputError: a row has another number of values or something that is no number; with its line.
    """
    with open_text(path) as file:
        lines = islice(_clean(file, layout), layout.skip_lines, None)
        # loadtxt warns of blank lines and of none at all, and allocates max_rows before it reads:
        # so it sees neither.
        rows = islice((line for line in lines if not line.isspace()), layout.max_rows)
        first = next(rows, None)
        if not first:
            return np.empty((0, layout.columns))
        try:
            table = np.loadtxt(chain((first,), rows), delimiter=layout.delimiter, comments=None, ndmin=2)
        except ValueError as e:
            raise InputError(_first_fault(path, layout)) from e
    if table.shape[1] != layout.columns:
        raise InputError(_first_fault(path, layout))
    return table


def split_row(line: str, delimiter: str | None) -> list[str]:
    """The values of one line as text."""
    return [value.strip() for value in line.strip().split(delimiter)]


def count_rows(path: Path, layout: TableLayout) -> int:
    """Lines with content from the first row on."""
    with open_text(path) as file:
        return sum(1 for line in islice(_clean(file, layout), layout.skip_lines, None) if line.strip())


def _clean(lines: Iterable[str], layout: TableLayout) -> Iterable[str]:
    """The lines without remarks and with decimal points; the same object where nothing is to do."""
    if not layout.comments and not layout.decimal_comma:
        return lines
    remark = re.compile("|".join(re.escape(mark) for mark in layout.comments) or r"(?!)")
    comma = layout.decimal_comma

    def cleaned() -> Iterator[str]:
        for line in lines:
            kept = remark.split(line, maxsplit=1)[0] if remark.search(line) else line
            # A line that was all remark keeps a blank, which marks it as a line without content.
            yield (kept or " ").replace(",", ".") if comma else kept or " "

    return cleaned()


def _first_fault(path: Path, layout: TableLayout) -> str:
    """The message about the first line that is not a row of `layout.columns` numbers."""
    row = 0
    with open_text(path) as file:
        for number, line in enumerate(_clean(file, layout), start=1):
            if number <= layout.skip_lines or not line.strip():
                continue
            row += 1
            values = split_row(line, layout.delimiter)
            of_rows = f" (row {row} of {layout.max_rows})" if layout.max_rows is not None else ""
            where = f"{path.name}, line {number}{of_rows}"
            fix = "Fix: repair or delete the line, or export the scan again."
            if len(values) != layout.columns:
                return f"{where}: found {len(values)} values; {layout.columns} are needed. {fix}"
            for value in values:
                if not _is_number(value):
                    return f"{where}: found {value[:40]!r}; a number is needed. {fix}"
    return f"{path.name}: the rows of numbers could not be read. Fix: export the scan again, as PLY."


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    # Python reads 1_000 as a thousand; no other program does.
    return "_" not in text
