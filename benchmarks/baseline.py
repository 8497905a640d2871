"""The committed figures, and the gate that a change has to pass."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from benchmarks.figures import FIGURES, Row

BASELINE = Path(__file__).with_name("baseline.json")
Rows = Mapping[str, Mapping[str, Row]]
"""By way of fitting, then by suite."""


def accept(path: Path, rows: Rows, settings: Mapping[str, Any]) -> None:
    """Write the figures as the new baseline; rows that were not run now stay as they are."""
    known = json.loads(path.read_text(encoding="utf-8"))["rows"] if path.exists() else {}
    for run, suites in rows.items():
        for suite, row in suites.items():
            known.setdefault(run, {})[suite] = {**settings, "figures": dict(row)}
    document = {
        "about": "Accepted figures of `python -m benchmarks`. Change with --accept only, and say why.",
        "figures": {name: asdict(figure) for name, figure in FIGURES.items()},
        "rows": known,
    }
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, path)


def worse(path: Path, rows: Rows, settings: Mapping[str, Any], level: float) -> list[str]:
    """What is worse than the baseline, one sentence each.

    A row without a baseline of the same rooms is one of them: a gate must not pass what it cannot judge.

    Args:
        path: of the baseline.
        rows: figures of now.
        settings: rooms and seed; they must be those of the baseline.
        level: nominal coverage.
    """
    document = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"rows": {}, "figures": {}}
    said = []
    for run, suites in rows.items():
        for suite, row in suites.items():
            accepted = document["rows"].get(run, {}).get(suite)
            if accepted is None or any(accepted[key] != value for key, value in settings.items()):
                wanted = ", ".join(f"{key} {value}" for key, value in settings.items())
                said.append(f"{suite}, {run}: no baseline with {wanted}. Fix: run with --accept first.")
                continue
            for name, figure in document["figures"].items():
                before, now = accepted["figures"].get(name), row.get(name)
                if before is not None and _is_worse(figure, before, now, level):
                    said.append(
                        f"{suite}, {run}: {name} {_text(now)} instead of {before:.4g} {figure['unit']}"
                    )
    return said


def _text(value: float | None) -> str:
    return "nothing" if value is None else f"{value:.4g}"


def _is_worse(figure: Mapping[str, Any], before: float, now: float | None, level: float) -> bool:
    if now is None:
        return True
    allowed = figure["absolute"] + figure["relative"] * abs(before)
    if figure["direction"] == "higher":
        return now < before - allowed
    if figure["direction"] == "lower":
        return now > before + allowed
    return abs(now - level) > abs(before - level) + allowed
