"""The reliability of a finished batch's intervals as a picture."""

from pathlib import Path

from indoorfit.errors import InputError
from indoorfit.report import Picture

from .collect import Record
from .finished import finished_batch, length_records
from .plots import reliability_picture

_NUMBERS = ("level", "value_m", "low_m", "high_m", "reference_m", "error_m")


def reliability_of(folder: str | Path) -> Picture:
    """Share of references held over the nominal coverage, one curve per configuration.

    Args:
        folder: directory of `indoorfit evaluate`.

    Raises:
        InputError: no finished batch, or none of its lengths has an interval and a reference.
    """
    folder = Path(folder)
    with finished_batch(folder):
        records = [_record(row) for row in length_records(folder) if row["held"]]
    picture = reliability_picture(records)
    if picture is None:
        raise InputError(
            f"{folder}: no length has both an interval and a reference, so there is nothing to draw. "
            "Fix: give the scans of the manifest a tape or a truth."
        )
    return picture


def _record(row: dict[str, str]) -> Record:
    numbers = {name: float(row[name]) for name in _NUMBERS}
    # That of a truth is nought, and of no reference unknown.
    numbers["reference_std_m"] = float(row["reference_std_m"] or 0.0)
    return {"config": row["config"], "held": row["held"], **numbers}
