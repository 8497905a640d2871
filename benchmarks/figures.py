"""The figures of a suite, and in which direction each of them is good."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from benchmarks.outcome import Outcome
from indoorfit.evaluate import LengthCheck, coverage, summarise

Row = dict[str, float | None]


@dataclass(frozen=True)
class Figure:
    """One figure of a suite; the gate fails when it gets worse by more than the tolerance."""

    about: str
    unit: str
    direction: Literal["higher", "lower", "level"]
    """Where better is; `level` means nearer to the nominal coverage."""
    absolute: float
    relative: float
    """Tolerance: `absolute` plus `relative` times the baseline."""
    reason: str


FIGURES: dict[str, Figure] = {
    "right": Figure("rooms whose structure is right", "share", "higher", 0.045, 0.0, "one room of 24"),
    "footprint_iou": Figure(
        "mean, 0 without a model", "share", "higher", 0.005, 0.0, "one notch in 24 rooms"
    ),
    "solid_iou": Figure("mean, 0 without a model", "share", "higher", 0.005, 0.0, "one notch in 24 rooms"),
    "completeness": Figure("ISPRS at 10 cm, mean", "share", "higher", 0.01, 0.0, "one wall in four rooms"),
    "correctness": Figure("ISPRS at 10 cm, mean", "share", "higher", 0.01, 0.0, "one wall in four rooms"),
    "lost": Figure("true lengths without a number", "share", "lower", 0.02, 0.0, "one wrong room of 24"),
    "rmse_mm": Figure("lengths", "mm", "lower", 0.1, 0.15, "one gross error decides it"),
    "mad_mm": Figure("lengths, median absolute deviation", "mm", "lower", 0.05, 0.10, "150 lengths: 10 %"),
    "coverage": Figure(
        "intervals that hold the truth", "share", "level", 0.04, 0.0, "2 sigma at 150 lengths"
    ),
    "score_mm": Figure("mean interval score", "mm", "lower", 0.2, 0.20, "one missed length decides it"),
    "width_mm": Figure("median width of the intervals", "mm", "lower", 0.1, 0.15, "as mad_mm, with a margin"),
    "status": Figure("faces with the right status", "share", "higher", 0.02, 0.0, "four faces of 200"),
    "crashed": Figure("rooms the program fails on", "share", "lower", 0.0, 0.0, "none may be new"),
    "cpu_s": Figure("median of a fit", "s", "lower", 0.5, 1.0, "another machine may take twice as long"),
    "peak_mb": Figure("largest of all rooms", "MB", "lower", 50.0, 0.3, "libraries differ by machine"),
}


def row_of(outcomes: Sequence[Outcome]) -> Row:
    """All figures of one suite under one way of fitting; None where there is nothing to count."""
    compared = [outcome.comparison for outcome in outcomes if outcome.comparison is not None]
    lengths = [length for comparison in compared for length in comparison.lengths]
    summary = summarise(lengths)
    n_lost = sum(len(comparison.lost) for comparison in compared)
    statuses = [check.expected == check.found for comparison in compared for check in comparison.statuses]

    def mean(values: Sequence[float]) -> float:
        # A room without a model counts as nothing shared.
        return float(np.sum(values)) / len(outcomes)

    row = {
        "right": mean([outcome.right for outcome in outcomes]),
        "footprint_iou": mean([comparison.footprint_iou for comparison in compared]),
        "solid_iou": mean([comparison.solid_iou for comparison in compared]),
        "completeness": float(np.nansum([outcome.isprs[0] for outcome in outcomes])) / len(outcomes),
        "correctness": float(np.nansum([outcome.isprs[1] for outcome in outcomes])) / len(outcomes),
        "lost": n_lost / (n_lost + len(lengths)) if n_lost + len(lengths) else float("nan"),
        "rmse_mm": 1e3 * summary.rmse_m,
        "mad_mm": 1e3 * summary.mad_m,
        "coverage": summary.coverage.share,
        "score_mm": 1e3 * summary.mean_score_m,
        "width_mm": 1e3 * summary.median_width_m,
        "status": float(np.mean(statuses)) if statuses else float("nan"),
        "crashed": mean([outcome.crashed for outcome in outcomes]),
        "cpu_s": float(np.median([outcome.cpu_s for outcome in outcomes])),
        "peak_mb": max(outcome.peak_mb for outcome in outcomes),
    }
    return {name: None if np.isnan(value) else round(value, 5) for name, value in row.items()}


def side_by_side(first: Sequence[Outcome], second: Sequence[Outcome]) -> dict[str, float]:
    """RMSE and median absolute error in millimetres of both, on the true lengths that both have a number for.

    Each way of fitting loses other rooms, the hard ones; over all its own lengths the one that loses more of
    them looks better. `rooms` where both have the right structure are told apart with `right_`.
    """
    pairs: list[tuple[float, float, bool]] = []
    for one, other in zip(first, second, strict=True):
        assert one.job.seed == other.job.seed, "the same rooms, in the same order"
        if one.comparison is None or other.comparison is None:
            continue
        theirs = {check.truth: check.error_m for check in other.comparison.lengths}
        both_right = one.right and other.right
        pairs += [
            (check.error_m, theirs[check.truth], both_right)
            for check in one.comparison.lengths
            if check.truth in theirs
        ]
    found: dict[str, float] = {}
    for prefix, chosen in (("", pairs), ("right_", [pair for pair in pairs if pair[2]])):
        errors_mm = 1e3 * np.array([pair[:2] for pair in chosen]).reshape(-1, 2)
        found[f"{prefix}lengths"] = len(errors_mm)
        if len(errors_mm):
            rmse, median = np.sqrt(np.mean(errors_mm**2, axis=0)), np.median(np.abs(errors_mm), axis=0)
            found |= {f"{prefix}rmse_mm": float(rmse[0]), f"{prefix}other_rmse_mm": float(rmse[1])}
            found |= {f"{prefix}median_mm": float(median[0]), f"{prefix}other_median_mm": float(median[1])}
    return found


def level_table(outcomes: Sequence[Outcome]) -> dict[float, dict[str, float]]:
    """Coverage with its own interval at every level that was run."""
    hits: dict[float, list[bool]] = {}
    for outcome in outcomes:
        if outcome.comparison is None:
            continue
        by_level = {outcome.job.levels[0]: outcome.comparison.lengths, **outcome.other_levels}
        for level, lengths in by_level.items():
            hits.setdefault(level, []).extend(length.hit for length in lengths)
    return {level: vars(coverage(hits[level])) for level in sorted(hits)}


def room_record(outcome: Outcome) -> dict[str, Any]:
    """One room as plain values for JSON."""
    record: dict[str, Any] = {
        "suite": outcome.job.suite,
        "run": outcome.job.run,
        "seed": outcome.job.seed,
        "right": outcome.right,
        "faults": list(outcome.faults),
        "notes": list(outcome.notes),
        "cpu_s": outcome.cpu_s,
        "wall_s": outcome.wall_s,
        "peak_mb": outcome.peak_mb,
    }
    comparison = outcome.comparison
    if comparison is None:
        return record
    completeness, correctness, accuracy_m = outcome.isprs
    return record | {
        "missing": list(comparison.missing),
        "extra": list(comparison.extra),
        "misplaced": [vars(item) for item in comparison.misplaced],
        "rooms": {"model": comparison.n_rooms[0], "truth": comparison.n_rooms[1]},
        "footprint_iou": comparison.footprint_iou,
        "solid_iou": comparison.solid_iou,
        "isprs_10cm": {"completeness": completeness, "correctness": correctness, "accuracy_m": accuracy_m},
        "lost": list(comparison.lost),
        "status_wrong": [vars(check) for check in comparison.statuses if check.expected != check.found],
        "statuses_judged": len(comparison.statuses),
        "lengths": [_length_record(length) for length in comparison.lengths],
    }


def _length_record(length: LengthCheck) -> dict[str, Any]:
    derived = {
        "error_m": length.error_m,
        "hit": length.hit,
        "width_m": length.width_m,
        "score_m": length.score_m,
    }
    return vars(length) | derived


def note_counts(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """Rooms in which each warning was given."""
    return dict(sorted(Counter(code for outcome in outcomes for code in outcome.notes).items()))
