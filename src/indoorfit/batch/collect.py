"""From rows to tables: every length, every scan, and figures by sensor, kind, status and configuration."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from indoorfit.evaluate import LengthCheck, coverage, summarise, wilson

from .jobs import Job, Row
from .manifest import Study
from .published import PublishedLength

Record = dict[str, Any]
"""One line of a table; every line of a table has the same keys."""

TABLE_NAMES = ("scans", "lengths", "summary", "pairs", "refused")
TABLE_FILES = (*(f"{name}.{kind}" for name in TABLE_NAMES for kind in ("csv", "parquet")), "report.html")
"""What a finished batch has beside its rows."""

_NAN = float("nan")


@dataclass(frozen=True)
class Tables:
    """What a batch found; in the order of the manifest, and without any time in it."""

    scans: tuple[Record, ...]
    """One line for each scan and configuration, failures included."""
    lengths: tuple[Record, ...]
    """One line for each length that has a reference."""
    summary: tuple[Record, ...]
    """Figures over groups of lengths."""
    pairs: tuple[Record, ...]
    """Configurations side by side, on the lengths that both have."""
    refused: tuple[Record, ...]
    """Rows of tape tables that were not used."""

    def named(self) -> dict[str, tuple[Record, ...]]:
        """The tables by the names of their files."""
        return {name: getattr(self, name) for name in TABLE_NAMES}


def collect(study: Study, rows: Mapping[str, Row]) -> Tables:
    """Put the rows of a study together.

    Args:
        study: what was run.
        rows: by key, one for each job.
    """
    lengths = [_length(job, length) for job in study.jobs for length in rows[job.key]["lengths"]]
    lengths += [_published(length) for length in study.published]
    scans = tuple(_scan(job, rows[job.key]) for job in study.jobs)
    return Tables(scans, tuple(lengths), _summary(lengths), _pairs(lengths), _refused(study, rows))


def _length(job: Job, length: Record) -> Record:
    check = _check(length)
    return {
        "scan": job.name,
        "room": job.room,
        "sensor": job.sensor,
        "config": job.config_name,
        "method": job.config.method,
        "reference": length["reference"],
        "of": length["truth"],
        "dimension": length["model"],
        "kind": length["kind"],
        "status": length["status"],
        "reference_m": length["true_m"],
        "reference_std_m": length["reference_std_m"],
        "value_m": length["value_m"],
        "std_m": length["std_m"],
        "data_std_m": length["data_std_m"],
        "level": length["level"],
        "low_m": length["low_m"],
        "high_m": length["high_m"],
        "error_m": check.error_m,
        "held": check.hit,
        "score_m": check.score_m,
        "e_n": _NAN if length["e_n"] is None else length["e_n"],
    }


def _published(length: PublishedLength) -> Record:
    return {
        "scan": length.name,
        "room": length.name,
        "sensor": length.sensor,
        "config": length.config,
        "method": "published",
        "reference": "tape",
        "of": length.dimension,
        "dimension": length.dimension,
        "kind": length.kind,
        "status": "observed",
        "reference_m": length.reference_m,
        "reference_std_m": _NAN,
        "value_m": length.value_m,
        "std_m": _NAN,
        "data_std_m": _NAN,
        "level": _NAN,
        "low_m": _NAN,
        "high_m": _NAN,
        "error_m": length.value_m - length.reference_m,
        "held": None,
        "score_m": _NAN,
        "e_n": _NAN,
    }


def _check(length: Record) -> LengthCheck:
    names = ("truth", "model", "kind", "true_m", "value_m", "std_m", "low_m", "high_m", "level", "status")
    return LengthCheck(**{name: length[name] for name in names})


def _scan(job: Job, row: Row) -> Record:
    done = row["state"] == "done"
    structure, tape = row.get("structure") or {}, row.get("tape") or {}
    figures = summarise([_check(length) for length in row["lengths"]])
    return {
        "scan": job.name,
        "room": job.room,
        "sensor": job.sensor,
        "config": job.config_name,
        "method": job.config.method,
        "state": row["state"],
        "reason": row["reason"] or "",
        "converged": row["converged"] if done else None,
        "points": row["points"] if done else None,
        "walls": row["walls"] if done else None,
        "structure_right": structure.get("right"),
        "faults": "; ".join(structure.get("faults", ())),
        "lengths": figures.n,
        "lengths_lost": len(structure.get("lost", ())),
        "bias_m": figures.bias_m,
        "rmse_m": figures.rmse_m,
        "held": figures.coverage.share,
        "tape_chi2": tape.get("chi2", _NAN),
        "tape_p": tape.get("p_value", _NAN),
        "warnings": " ".join(row.get("warnings", ())),
        "key": job.key,
    }


_GROUPS: dict[str, Callable[[Record], str]] = {
    "all": lambda record: "all",
    "sensor": lambda record: record["sensor"],
    "kind": lambda record: record["kind"],
    "status": lambda record: record["status"],
}


def _summary(lengths: Sequence[Record]) -> tuple[Record, ...]:
    """By configuration and reference, over everything and by sensor, by kind and by status."""
    found = []
    for config, reference in _distinct((r["config"], r["reference"]) for r in lengths):
        own = [r for r in lengths if (r["config"], r["reference"]) == (config, reference)]
        for by, group_of in _GROUPS.items():
            for group in sorted({group_of(r) for r in own}):
                members = [r for r in own if group_of(r) == group]
                head = {"config": config, "reference": reference, "by": by, "group": group}
                found.append({**head, **figures(members)})
    return tuple(found)


def figures(lengths: Sequence[Record]) -> Record:
    """Bias, RMSE, MAD, coverage with its interval, and score, of any set of lengths; NaN where not known."""
    errors_m = np.array([r["error_m"] for r in lengths])
    judged = [r for r in lengths if r["held"] is not None]
    held = coverage([r["held"] for r in judged])
    agreeing = [r["e_n"] <= 1.0 for r in judged if math.isfinite(r["e_n"])]
    low, high = _clustered(judged)
    return {
        "lengths": len(lengths),
        "rooms": len({r["room"] for r in lengths}),
        "bias_m": float(errors_m.mean()),
        "rmse_m": float(np.sqrt(np.mean(errors_m**2))),
        "mad_m": float(np.median(np.abs(errors_m - np.median(errors_m)))),
        "largest_m": float(np.abs(errors_m).max()),
        "level": float(np.mean([r["level"] for r in judged])) if judged else _NAN,
        "held": held.share,
        "held_low": held.low if judged else _NAN,
        "held_high": held.high if judged else _NAN,
        "held_rooms_low": low,
        "held_rooms_high": high,
        "agree": float(np.mean(agreeing)) if agreeing else _NAN,
        "score_m": float(np.mean([r["score_m"] for r in judged])) if judged else _NAN,
        "median_width_m": float(np.median([r["high_m"] - r["low_m"] for r in judged])) if judged else _NAN,
    }


def _clustered(judged: Sequence[Record]) -> tuple[float, float]:
    """Wilson's interval of the coverage with rooms, not lengths, as independent witnesses.

    The number of lengths is divided by the design effect: the variance of the share as the scatter between
    rooms shows it, over that of independent lengths; never below 1. With one room nothing can be said.

    Source: L. Kish, Survey Sampling (1965), 5.4 (ratio estimate from clusters) and 8.2 (design effect).
    """
    rooms = _distinct(r["room"] for r in judged)
    if len(rooms) < 2:
        return _NAN, _NAN
    hits = np.array([sum(bool(r["held"]) for r in judged if r["room"] == room) for room in rooms], float)
    sizes = np.array([sum(r["room"] == room for r in judged) for room in rooms], float)
    n, share = sizes.sum(), hits.sum() / sizes.sum()
    between = len(rooms) / (len(rooms) - 1) * float(np.sum((hits - share * sizes) ** 2)) / n**2
    # Of no misses at all the scatter knows nothing; then the largest effect that there can be is taken.
    alone = share * (1.0 - share) / n
    effect = max(1.0, between / alone) if alone > 0.0 else float(n / len(rooms))
    return wilson(float(share), float(n / effect))


def _pairs(lengths: Sequence[Record]) -> tuple[Record, ...]:
    """Every two configurations on the lengths that both found, room by room."""
    configs = _distinct(r["config"] for r in lengths if r["method"] != "published")
    found = []
    for k, first in enumerate(configs):
        for second in configs[k + 1 :]:
            a, b = ({_of(r): r for r in lengths if r["config"] == config} for config in (first, second))
            common = [key for key in a if key in b]
            if common:
                found.append(_pair(first, second, [(a[key], b[key]) for key in common]))
    return tuple(found)


def _of(record: Record) -> tuple[str, str, str]:
    return record["scan"], record["reference"], record["of"]


def _pair(first: str, second: str, both: Sequence[tuple[Record, Record]]) -> Record:
    errors_m = np.array([[a["error_m"], b["error_m"]] for a, b in both])
    rooms = [a["room"] for a, _ in both]
    squares = {room: np.zeros(2) for room in rooms}
    for room, error in zip(rooms, errors_m, strict=True):
        squares[room] += error**2
    better = coverage([bool(s[0] < s[1]) for s in squares.values()])
    rmse_m = np.sqrt(np.mean(errors_m**2, axis=0))
    middle_m = np.median(np.abs(errors_m), axis=0)
    return {
        "first": first,
        "second": second,
        "lengths": len(both),
        "rooms": len(squares),
        "first_rmse_m": float(rmse_m[0]),
        "second_rmse_m": float(rmse_m[1]),
        "first_median_error_m": float(middle_m[0]),
        "second_median_error_m": float(middle_m[1]),
        "first_better": better.share,
        "first_better_low": better.low,
        "first_better_high": better.high,
    }


def _refused(study: Study, rows: Mapping[str, Row]) -> tuple[Record, ...]:
    found = [
        {"table": table, "line": row.line, "scan": "", "config": "", "reason": row.reason}
        for table, row in study.refused
    ]
    for job in study.jobs:
        tape = rows[job.key].get("tape") or {}
        found += [
            {"table": tape["source"], **row, "scan": job.name, "config": job.config_name}
            for row in tape.get("refused", ())
        ]
    order = ("table", "line", "scan", "config", "reason")
    return tuple({key: record[key] for key in order} for record in found)


def _distinct(values: Iterable[Any]) -> list[Any]:
    return list(dict.fromkeys(values))
