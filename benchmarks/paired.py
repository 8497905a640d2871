"""Joint against greedy on the lengths that both measured, in rooms that both got right."""

from typing import Any

import numpy as np
from jaxtyping import Float

_RESAMPLED = 2_000
"""A quantile of 2.5 % among so many is good to 0.35 per cent points."""


def paired(records: list[dict[str, Any]], seed: int) -> list[dict[str, Any]]:
    """One row per regime, with or without ids: errors of both methods in mm, and the ratio of their RMSE.

    The ratio's 95 % interval is from rooms drawn anew (bootstrap): the lengths of a room share its frames.

    Args:
        records: of the study, see `benchmarks.calibration.run_room`.
        seed: of the draws.
    """
    rooms: dict[tuple[str, bool], list[Float[np.ndarray, "lengths 2"]]] = {}
    for record in records:
        errors_mm = _errors_mm(record)
        if len(errors_mm):
            rooms.setdefault((record["regime"], record["ids"]), []).append(errors_mm)
    return [_row(name, ids, found, seed) for (name, ids), found in sorted(rooms.items())]


def _errors_mm(record: dict[str, Any]) -> Float[np.ndarray, "lengths 2"]:
    """Of joint and of greedy, for the lengths of one room that both have."""
    by_method: dict[str, dict[str, float]] = {"joint": {}, "greedy": {}}
    for entry in record["lengths"]:
        if entry["method"] in by_method:
            by_method[entry["method"]][entry["length"]] = 1e3 * (entry["value"] - entry["true"])
    joint, greedy = by_method["joint"], by_method["greedy"]
    return np.array([(joint[name], greedy[name]) for name in joint if name in greedy]).reshape(-1, 2)


def _row(name: str, ids: bool, rooms: list[Float[np.ndarray, "lengths 2"]], seed: int) -> dict[str, Any]:
    errors_mm = np.concatenate(rooms)
    rms, middle = np.sqrt(np.mean(errors_mm**2, axis=0)), np.median(np.abs(errors_mm), axis=0)
    sums = np.array([np.sum(room**2, axis=0) for room in rooms])
    drawn = sums[np.random.default_rng(seed).integers(len(rooms), size=(_RESAMPLED, len(rooms)))].sum(axis=1)
    low, high = np.quantile(np.sqrt(drawn[:, 0] / drawn[:, 1]), [0.025, 0.975])
    return {
        "regime": name,
        "ids": ids,
        "rooms": len(rooms),
        "lengths": len(errors_mm),
        "rmse_mm": [round(float(value), 3) for value in rms],
        "median_mm": [round(float(value), 3) for value in middle],
        "ratio": [round(float(value), 3) for value in (rms[0] / rms[1], low, high)],
    }


def paired_table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    head = ("regime", "ids", "rooms", "lengths", "RMSE joint", "RMSE greedy", "median joint", "median greedy")
    lines = ["| " + " | ".join((*head, "ratio of RMSE")) + " |", "|" + " --- |" * 9]
    for row in rows:
        cells = [row["regime"], "yes" if row["ids"] else "no", str(row["rooms"]), str(row["lengths"])]
        cells += [f"{value:.1f}" for value in (*row["rmse_mm"], *row["median_mm"])]
        ratio, low, high = row["ratio"]
        cells.append(f"{ratio:.2f} ({low:.2f} to {high:.2f})")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
