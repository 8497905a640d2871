"""The reliability of a finished batch's intervals as a picture."""

import csv
from pathlib import Path

from indoorfit.errors import InputError
from indoorfit.report import Picture

from .collect import Record
from .plots import reliability_picture

_NUMBERS = ("level", "value_m", "low_m", "high_m", "reference_m", "reference_std_m", "error_m")


def reliability_of(folder: str | Path) -> Picture:
    """Share of references held over the nominal coverage, one curve per configuration.

    Args:
        folder: directory of `indoorfit evaluate`.

    Raises:
        InputError: no finished batch, or none of its lengths has an interval and a reference.
    """
    path = Path(folder) / "lengths.csv"
    try:
        with open(path, encoding="utf-8", newline="") as file:
            # Lengths out of a paper have no interval.
            records = [_record(row) for row in csv.DictReader(file) if row["low_m"] and row["held"]]
    except (OSError, KeyError, ValueError) as e:
        raise InputError(
            f"{folder}: is no finished batch ({e}). Fix: run `indoorfit evaluate MANIFEST --out {folder}`."
        ) from e
    picture = reliability_picture(records)
    if picture is None:
        raise InputError(
            f"{folder}: no length has both an interval and a reference, so there is nothing to draw. "
            "Fix: give the scans of the manifest a tape or a truth."
        )
    return picture


def _record(row: dict[str, str]) -> Record:
    numbers = {name: float(row[name] or 0.0) for name in _NUMBERS}
    return {"config": row["config"], "held": row["held"], **numbers}
