"""From a batch on disk to settings with calibrated intervals."""

import csv
import json
import math
from pathlib import Path
from typing import Any

from indoorfit.errors import InputError

from .calibration import Calibration, JudgedLength
from .run import MARK
from .settings import settings_toml


def read_lengths(folder: str | Path, config: str | None = None) -> tuple[list[JudgedLength], dict[str, Any]]:
    """The lengths of one configuration of a batch that have an interval, and the settings it changes.

    Args:
        folder: directory of `indoorfit evaluate`.
        config: name of the configuration; may be left out where there is only one.

    Raises:
        InputError: no batch, no such configuration, or several and none chosen.
    """
    folder = Path(folder)
    try:
        batch = json.loads((folder / MARK).read_text(encoding="utf-8"))
        with open(folder / "lengths.csv", encoding="utf-8", newline="") as file:
            records = [record for record in csv.DictReader(file) if record.get("low_m")]
        configs = dict(batch["configs"])
    except (OSError, ValueError, KeyError, TypeError) as e:
        raise InputError(
            f"{folder}: is no finished batch ({e}). Fix: run `indoorfit evaluate MANIFEST --out {folder}`."
        ) from e
    if config is None and len(configs) == 1:
        config = next(iter(configs))
    if config is None or config not in configs:
        found = f"has no configuration {config!r}" if config else "has several configurations"
        raise InputError(f"{folder}: {found}: {', '.join(configs)}. Fix: choose one with --config.")
    return [_judged(record) for record in records if record["config"] == config], configs[config]


def _judged(record: dict[str, str]) -> JudgedLength:
    value_m, reference_m = float(record["value_m"]), float(record["reference_m"])
    half_m = float(record["high_m"]) - value_m if reference_m > value_m else value_m - float(record["low_m"])
    return JudgedLength(
        room=record["room"],
        error_m=value_m - reference_m,
        half_m=half_m,
        level=float(record["level"]),
        reference_std_m=float(record["reference_std_m"] or 0.0),
    )


def preset_toml(found: Calibration, settings: dict[str, Any], conformal: bool) -> str:
    """Settings for `indoorfit fit --config`, with what they rest on.

    Args:
        found: of `calibrate`.
        settings: those of the batch that are not the defaults; all of them are kept, for the factor is right
            with them only. A factor among them is multiplied.
        conformal: whether the conformal factor is taken instead of the most likely one.

    Raises:
        InputError: the conformal factor is asked for, and there are too few rooms.
    """
    if conformal and found.conformal is None:
        raise InputError(
            f"calibrate: {found.n_rooms} rooms; a conformal interval at {100 * found.level:g} % needs "
            f"{found.conformal_rooms}. Fix: measure more rooms, or leave --conformal out."
        )
    factor = found.conformal if conformal and found.conformal is not None else found.factor
    guarantee = (
        "Conformal: in a new room that is exchangeable with these (same sensor, same way of scanning), the",
        "interval of a length picked at random holds its reference with a probability of at least "
        f"{100 * found.level:g} %.",
        "This holds for no other level and says nothing of one given room.",
    )
    likely = (
        f"Most likely factor; 95 % interval {found.factor_low:.3f} to {found.factor_high:.3f}.",
        "No guarantee: it assumes that errors scale with the intervals, in new rooms as in these.",
    )
    lines = [
        f"Intervals calibrated by indoorfit on {found.n_lengths} lengths in {found.n_rooms} rooms.",
        *(guarantee if conformal else likely),
        f"Held before {100 * found.held_before:.1f} %, after {100 * found.held_after:.1f} % (each room with",
        "the most likely factor of the others), the references' own uncertainty allowed for.",
    ]
    head = "\n".join(f"# {line}" for line in lines)
    belief = dict(settings.get("belief", {}))
    # Rounded up, so that no interval is narrower than what was learnt.
    belief["inflation"] = math.ceil(belief.get("inflation", 1.0) * factor * 1e4) / 1e4
    return f"{head}\n\n{settings_toml({**settings, 'level': found.level, 'belief': belief})}"
