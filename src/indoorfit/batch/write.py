"""Tables on disk: CSV always, Parquet where its library is installed, and one page to look at."""

import csv
import io
import logging
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from indoorfit.files import replace_file

from .collect import Record, Tables
from .page import batch_page

log = logging.getLogger("indoorfit")

_HEADS = {
    "refused": ("table", "line", "scan", "config", "reason"),
    "pairs": ("first", "second", "lengths", "rooms"),
}
"""Columns of tables that may have no line at all."""


def write_tables(tables: Tables, folder: Path, title: str) -> None:
    """Write NAME.csv and NAME.parquet for every table, and report.html. The same tables give the same bytes.

    Raises:
        OutputError: the folder cannot be written.
    """
    parquet = _parquet_library()
    for name, records in tables.named().items():
        replace_file(folder / f"{name}.csv", _csv(name, records))
        if parquet is not None:
            replace_file(folder / f"{name}.parquet", _parquet(parquet, name, records))
    if parquet is None:
        log.info("no Parquet files: pip install 'indoorfit[batch]' adds them")
    replace_file(folder / "report.html", batch_page(tables, title).encode("utf-8"))


def _columns(name: str, records: Sequence[Record]) -> tuple[str, ...]:
    return tuple(records[0]) if records else _HEADS.get(name, ("scan",))


def _csv(name: str, records: Sequence[Record]) -> bytes:
    text = io.StringIO(newline="")
    rows = csv.writer(text, lineterminator="\r\n")
    columns = _columns(name, records)
    rows.writerow(columns)
    rows.writerows([_cell(record[column]) for column in columns] for record in records)
    return text.getvalue().encode("utf-8", "replace")


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    # A nanometre is below every uncertainty and keeps the last bits of the arithmetic out of the file.
    return repr(round(value, 9) + 0.0) if isinstance(value, float) else str(value)


def _parquet_library() -> Any:
    try:
        from pyarrow import parquet
    except ImportError:
        return None
    return parquet


def _parquet(parquet: Any, name: str, records: Sequence[Record]) -> bytes:
    import pyarrow

    columns = {column: [record[column] for record in records] for column in _columns(name, records)}
    content = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), content, compression="zstd")
    return content.getvalue()
