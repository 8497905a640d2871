"""From a batch on disk to settings with calibrated intervals."""

import json
import math
from pathlib import Path
from typing import Any

from indoorfit.errors import InputError

from .calibration import Calibration, JudgedLength
from .finished import finished_batch, length_records
from .run import MARK
from .scales import NoiseScales
from .settings import settings_toml


def read_lengths(
    folder: str | Path, config: str | None = None, sensor: str | None = None
) -> tuple[list[JudgedLength], dict[str, Any]]:
    """The lengths of one configuration of a batch that have an interval, and the settings it changes.

    Args:
        folder: directory of `indoorfit evaluate`.
        config: name of the configuration; may be left out where there is only one.
        sensor: only scans of this sensor, by the batch's word for it; None takes all.

    Raises:
        InputError: no batch, no such configuration or sensor, or several configurations and none chosen.
    """
    folder = Path(folder)
    with finished_batch(folder):
        batch = json.loads((folder / MARK).read_text(encoding="utf-8"))
        configs = dict(batch["configs"])
        records = length_records(folder)
    if config is None and len(configs) == 1:
        config = next(iter(configs))
    if config is None or config not in configs:
        found = f"has no configuration {config!r}" if config else "has several configurations"
        raise InputError(f"{folder}: {found}: {', '.join(configs)}. Fix: choose one with --config.")
    with finished_batch(folder):
        own = [record for record in records if record["config"] == config]
        sensors = sorted({record["sensor"] for record in own})
    if sensor is not None and sensor not in sensors:
        raise InputError(
            f"{folder}: has no sensor {sensor!r}: {', '.join(sensors)}. Fix: choose one with --sensor."
        )
    if own and "data_std_m" not in own[0]:
        raise InputError(
            f"{folder}: lengths.csv has no column data_std_m: it was written by an earlier version. Fix: run "
            f"`indoorfit evaluate MANIFEST --out {folder}` again."
        )
    with finished_batch(folder):
        lengths = [_judged(record) for record in own if sensor in (None, record["sensor"])]
    return lengths, configs[config]


def _judged(record: dict[str, str]) -> JudgedLength:
    value_m, reference_m = float(record["value_m"]), float(record["reference_m"])
    half_m = float(record["high_m"]) - value_m if reference_m > value_m else value_m - float(record["low_m"])
    return JudgedLength(
        room=record["room"],
        error_m=value_m - reference_m,
        half_m=half_m,
        level=float(record["level"]),
        reference_std_m=float(record["reference_std_m"] or 0.0),
        value_m=value_m,
        data_share=float(record["data_std_m"]) / max(float(record["std_m"]), 1e-12),
        sensor=record["sensor"],
        kind=record["kind"],
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
    belief["inflation"] = _rounded_up(belief.get("inflation", 1.0) * factor)
    return f"{head}\n\n{settings_toml({**settings, 'level': found.level, 'belief': belief})}"


def scales_toml(found: NoiseScales, settings: dict[str, Any], level: float) -> str:
    """Settings for `indoorfit fit --config` with the noise scales that were learnt, and what they rest on.

    Args:
        found: of `learn_scales`.
        settings: those of the batch that are not the defaults; all of them are kept.
        level: of the batch's intervals.
    """
    k, s, c = found.factor, found.scale_std, found.definition_std_m
    lines = [
        f"Noise scales learnt by indoorfit in {found.n_rooms} rooms; in brackets 95 % intervals.",
        f"Of the scan's residuals: times {k.value:.3f} ({k.low:.3f} to {k.high:.3f}).",
        f"Of the scan's scale: {100 * s.value:.3g} % ({100 * s.low:.3g} to {100 * s.high:.3g} %).",
        f"Of where the wall is: {1e3 * c.value:.3g} mm ({1e3 * c.low:.3g} to {1e3 * c.high:.3g} mm).",
        f"Held {100 * found.held:.1f} % of the references, each room with the scales of the others.",
        "No guarantee: it assumes that errors are made in new rooms as in these.",
    ]
    head = "\n".join(f"# {line}" for line in lines)
    belief, type_b = dict(settings.get("belief", {})), dict(settings.get("type_b", {}))
    factor = _rounded_up(belief.get("inflation", 1.0) * k.value)
    belief["inflation"] = factor
    # The factor lies on everything that the fit adds, so these are written without it.
    type_b |= {
        "scale_std": _rounded_up(s.value / factor),
        "scale_dof": float(found.n_rooms - 1),
        "definition_std_m": _rounded_up(c.value / factor),
    }
    return f"{head}\n\n{settings_toml({**settings, 'level': level, 'belief': belief, 'type_b': type_b})}"


def _rounded_up(value: float) -> float:
    """To four significant digits, up: no interval is narrower than what was learnt."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 3)
    return float(f"{math.ceil(round(value / unit, 6)) * unit:.4g}")
