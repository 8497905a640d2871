"""A finished batch on disk, as those read it who learn from it."""

import csv
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from indoorfit.errors import InputError


@contextmanager
def finished_batch(folder: Path) -> Iterator[None]:
    """Turn what goes wrong in the block with files of a batch into an InputError that names its folder."""
    try:
        yield
    except (OSError, ValueError, KeyError, TypeError, csv.Error) as e:
        # An OSError's own text begins with its number, which tells nobody anything.
        why = f"{Path(e.filename).name}: {e.strerror}" if isinstance(e, OSError) and e.filename else e
        raise InputError(
            f"{folder}: is no finished batch ({why}). Fix: run `indoorfit evaluate MANIFEST --out {folder}`."
        ) from e


def length_records(folder: Path) -> list[dict[str, str]]:
    """The lines of lengths.csv that have an interval; those out of a publication have none."""
    with open(folder / "lengths.csv", encoding="utf-8", newline="") as file:
        return [record for record in csv.DictReader(file, strict=True) if record["low_m"]]
