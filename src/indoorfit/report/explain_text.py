"""Why the plan is as it is, as text and as JSON values."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from indoorfit.discover import CandidateReport, Explanation, Trial
from indoorfit.model import Frame, Note

from .table import aligned

EXPLAIN_SCHEMA = "indoorfit.explain/1"


def explain_document(found: Explanation, frame: Frame) -> dict[str, Any]:
    """Everything that decided, as plain values: metres, nats; lines and cells in the Manhattan frame.

    Args:
        found: the decision and its reasons.
        frame: of the explanation, in the scan.
    """
    return {
        "schema": EXPLAIN_SCHEMA,
        "frame": {
            "R_manhattan_scan": frame.R_manhattan_scan.tolist(),
            "origin_scan": frame.origin_scan_m.tolist(),
        },
        "energy": found.energy_nats,
        "corner_price": found.corner_price_nats,
        "candidates": [_candidate(candidate, found, frame) for candidate in found.candidates],
        "oblique": _all_oblique(found, frame),
        "cells": [
            {
                "x": [float(found.grid[0][i]), float(found.grid[0][i + 1])],
                "y": [float(found.grid[1][j]), float(found.grid[1][j + 1])],
                "ceiling": float(found.evidence.ceiling[i, j]),
                "floor": float(found.evidence.floor[i, j]),
                **_free(found, i, j),
                "log_odds": float(found.log_odds[i, j]),
                "inside": bool(found.inside[i, j]),
                "room": int(found.room[i, j]) or None,
            }
            for i, j in np.ndindex(found.room.shape)
        ],
        "notes": [{"code": note.code, "message": note.message} for note in found.notes],
    }


def _candidate(candidate: CandidateReport, found: Explanation, frame: Frame) -> dict[str, Any]:
    ends_m = np.full((2, 3), sum(found.heights_m) / 2.0)
    ends_m[:, candidate.axis] = candidate.position_m
    ends_m[:, 1 - candidate.axis] = candidate.stretch_m
    from_m, to_m = frame.to_scan(ends_m).tolist()
    return {
        "id": candidate.id,
        "axis": "xy"[candidate.axis],
        "position": candidate.position_m,
        "stretch": list(candidate.stretch_m),
        "from_scan": from_m,
        "to_scan": to_m,
        "source": _source(candidate),
        "verdict": candidate.verdict,
        "wall_seen": candidate.wall_m,
        "wall_passed": candidate.passed_m,
        "outline": candidate.outline_m,
        "outline_seen": candidate.outline_seen,
        "difference": candidate.difference_nats,
        "beside": [
            {"ceiling": s.ceiling, "floor": s.floor, "log_odds": s.log_odds, "room": s.room or None}
            for s in candidate.beside
        ],
        "reason": candidate.reason,
    }


def _all_oblique(found: Explanation, frame: Frame) -> list[dict[str, Any]]:
    return [_oblique(k, found, frame) for k in range(len(found.oblique))]


def _oblique(k: int, found: Explanation, frame: Frame) -> dict[str, Any]:
    """A wall that follows neither axis."""
    trial = found.oblique[k]
    heights_m = np.full((2, 1), sum(found.heights_m) / 2.0)
    from_m, to_m = frame.to_scan(np.concatenate([trial.line.ends_m, heights_m], axis=1)).tolist()
    return {
        "id": f"o{k + 1}",
        "yaw": trial.line.yaw_rad,
        "from_scan": from_m,
        "to_scan": to_m,
        "verdict": "accepted" if trial.accepted else "refused",
        "difference": trial.difference_nats if np.isfinite(trial.difference_nats) else None,
        "reason": _why(trial),
    }


def _why(trial: Trial) -> str:
    nats = trial.difference_nats
    if trial.accepted:
        whose = (
            "the edge of something in the room" if trial.cut is not None and trial.cut.opens else "a corner"
        )
        return f"It cuts {whose} off; the best plan without it is {nats:.1f} nats worse."
    if np.isfinite(nats):
        return f"The best plan with a corner cut off there is {nats:.1f} nats worse."
    return "It cuts no corner off between two walls: furniture, or a wall beyond the room."


def _free(found: Explanation, i: int, j: int) -> dict[str, float]:
    """Shares of a cell that lines of sight passed, where they are known."""
    free = found.evidence.free
    return {} if free is None else {"overhead": float(free.overhead[i, j]), "air": float(free.air[i, j])}


def _source(candidate: CandidateReport) -> str:
    return "seen" if candidate.seen else "forced" if candidate.forced else "inferred"


def explain_table(found: Explanation, frame: Frame) -> str:
    """The candidates as a table, then the reason for each in words.

    Args:
        found: the decision and its reasons.
        frame: of the explanation, in the scan.
    """
    head = ("id", "value [m]", "verdict", "source", "value seen [m]", "value outline [m]", "value nats")
    rows = [_row(candidate) for candidate in found.candidates]
    rooms = int(found.room.max())
    lines = [
        f"{rooms} room(s), {len(rows)} candidates, {found.room.size} cells; energy of the plan "
        f"{found.energy_nats:.1f} nats, each corner costs {found.corner_price_nats:.1f}",
        "Positions in the Manhattan frame. nats: by how much the best plan is worse without an accepted",
        "candidate, or with a refused one; 3 nats are odds of 20 to 1.",
        "",
        aligned(head, rows),
        "",
        *(f"{c.id}: {c.reason}\n    in the scan: {_points(c, found, frame)}" for c in found.candidates),
        *(f"{o['id']} ({o['verdict']}, oblique): {o['reason']}" for o in _all_oblique(found, frame)),
        *_notes(found.notes),
    ]
    return "\n".join(lines) + "\n"


def _row(candidate: CandidateReport) -> Sequence[str]:
    nats = candidate.difference_nats
    return (
        candidate.id,
        f"{candidate.position_m:.3f}",
        candidate.verdict,
        _source(candidate),
        f"{candidate.wall_m:.2f}",
        f"{candidate.outline_m:.2f}",
        "-" if nats is None else f"{nats:.1f}",
    )


def _points(candidate: CandidateReport, found: Explanation, frame: Frame) -> str:
    values = _candidate(candidate, found, frame)
    texts = (", ".join(f"{x:.3f}" for x in values[name]) for name in ("from_scan", "to_scan"))
    return "from_m = [{}], to_m = [{}]".format(*texts)


def _notes(notes: Sequence[Note]) -> list[str]:
    return ["", *(f"{note.code}: {note.message}" for note in notes)] if notes else []
