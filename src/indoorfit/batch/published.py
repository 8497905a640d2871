"""Lengths out of a publication, so that its figures stand beside those of a run."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from indoorfit.errors import ConfigError, InputError
from indoorfit.io import metres_per_unit, printable_name

_COLUMNS = ("dimension", "kind", "value", "reference", "unit")


@dataclass(frozen=True)
class PublishedLength:
    """One length of a publication: what was modelled and what a tape said."""

    name: str
    config: str
    sensor: str
    dimension: str
    kind: str
    value_m: float
    reference_m: float


def read_published(path: Path, name: str, config: str, sensor: str) -> list[PublishedLength]:
    """Read a CSV table with the columns dimension, kind, value, reference, unit.

    Args:
        path: the table; lines that begin with # are remarks.
        name: of the room.
        config: of the method.
        sensor: any word.

    Raises:
        InputError: the file cannot be read or a row is wrong, with its line.
    """
    where = printable_name(path.name)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as e:
        raise InputError(f"{where}: cannot be read ({e}). Fix: check the path.") from e
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    if not lines or tuple(lines[0][1].split(",")) != _COLUMNS:
        raise InputError(f"{where}: a header {','.join(_COLUMNS)} is needed. Fix: write it as first line.")
    found = []
    for number, line in lines[1:]:
        try:
            dimension, kind, value, reference, unit = next(csv.reader([line], strict=True))
            scale = metres_per_unit(unit)
            value_m, reference_m = scale * float(value), scale * float(reference)
            if not math.isfinite(value_m + reference_m):
                raise ValueError(f"{value} and {reference} are no lengths")
        except (ValueError, csv.Error, ConfigError) as e:
            raise InputError(
                f"{where}, line {number}: is not {', '.join(_COLUMNS)} ({e}). Fix: repair the line."
            ) from e
        found.append(PublishedLength(name, config, sensor, dimension, kind, value_m, reference_m))
    return found
