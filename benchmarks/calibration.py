"""Do the intervals hold what they promise? Through the whole pipeline, on simulated rooms.

    python -m benchmarks.calibration --out calibration                      200 rooms a regime
    python -m benchmarks.calibration --out calibration --rooms 20 --regimes drift5mm clutter
    python -m benchmarks.calibration --out calibration --regimes drift5mm --sbc 100

Every room is one line of rooms.jsonl in the folder; rooms that are there are not run again, so an interrupted
study goes on where it stopped. At the end the folder has results.json and table.md: coverage at 50, 80, 90,
95 and 99 %, mean interval score and width at 95 %, of the joint fit and of what it must beat: the greedy fit,
points taken as independent (the negative control: at 5 mm drift it must hold less than 25 %), CR2 and the
bootstrap on patches. --sbc adds rank histograms of the sampler on rooms from the noise model's own prior.
"""

import argparse
import json
import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from indoorfit.environment import prepare_numerics

# Before NumPy, and before the worker processes, which inherit the settings.
prepare_numerics()

import numpy as np  # noqa: E402

from benchmarks.suites import FURNISHED, SLIPPED, SUITES, scanned  # noqa: E402
from benchmarks.yardsticks import yardsticks  # noqa: E402
from indoorfit import IndoorfitError, RunConfig  # noqa: E402
from indoorfit.evaluate import compare, coverage, interval_score  # noqa: E402
from indoorfit.fitting import BeliefConfig  # noqa: E402
from indoorfit.measure import at_level  # noqa: E402
from indoorfit.model import STANDARD_LEVELS, FitResult  # noqa: E402
from indoorfit.pipeline import fit_scan, truth_result  # noqa: E402
from indoorfit.simulate import VirtualScan, regime  # noqa: E402

SCORED = 0.95

REGIMES: dict[str, Callable[[int], VirtualScan]] = {
    "drift0": lambda seed: scanned(seed, regime("0")),
    **{
        name: SUITES[name].make
        for name in ("drift5mm", "drift2cm", "drift5cm", "clutter", "slipped", "laser")
    },
    "clutter2cm": lambda seed: scanned(seed, regime("2cm"), FURNISHED),
    "slipped-clutter": lambda seed: scanned(seed, SLIPPED, FURNISHED),
    "phone": lambda seed: scanned(seed, regime("5mm"), sensor="phone_lidar"),
}
"""Kinect unless the name says otherwise; each is run with and without frame ids."""


def run_room(task: tuple[str, bool, int]) -> dict[str, Any]:
    """One room under all methods, as plain values."""
    name, ids, seed = task
    record: dict[str, Any] = {"regime": name, "ids": ids, "seed": seed, "lengths": [], "refused": []}
    virtual = REGIMES[name](seed)
    scan = virtual.scan if ids else replace(virtual.scan, frame_ids=None, frames=())
    truth = truth_result(virtual.shape, virtual.frame, {}, seed)
    for method in ("joint", "greedy"):
        config = RunConfig(method=method, belief=BeliefConfig(use_frames=ids))  # type: ignore[arg-type]
        try:
            result = fit_scan(scan, config)
        except IndoorfitError as error:
            record["refused"].append(f"{method}: {error}")
            continue
        intervals = {method: _intervals(result)}
        if method == "joint":
            record["notes"] = sorted({note.code for note in result.notes})
            intervals |= yardsticks(scan, result, STANDARD_LEVELS, np.random.default_rng(seed))
        comparison = compare(result, truth)
        if not comparison.right:
            # Lengths of a wrong structure belong to other walls: counted, but not judged.
            record["refused"].append(f"{method}: {'; '.join(comparison.faults)}")
            continue
        for check in comparison.lengths:
            if check.status == "inferred":
                continue
            for way, ends in intervals.items():
                entry = {"method": way, "kind": check.kind, "true": check.true_m, "ends": ends[check.model]}
                record["lengths"].append(entry)
    return record


def _intervals(result: FitResult) -> dict[str, list[tuple[float, float]]]:
    """By dimension, low and high end at every standard level."""
    found: dict[str, list[tuple[float, float]]] = {d.id: [] for d in result.dimensions}
    for level in STANDARD_LEVELS:
        for d in at_level(result, level).dimensions:
            found[d.id].append((d.quantity.interval.low, d.quantity.interval.high))
    return found


def summary(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row per regime, with or without ids, and method; coverage has Wilson's interval."""
    rows: dict[tuple[str, bool, str], list[dict[str, Any]]] = {}
    for record in records:
        for entry in record["lengths"]:
            rows.setdefault((record["regime"], record["ids"], entry["method"]), []).append(entry)
    found = []
    for (name, ids, method), entries in sorted(rows.items()):
        ends = np.array([entry["ends"] for entry in entries])
        truth = np.array([entry["true"] for entry in entries])
        hits = (ends[..., 0] <= truth[:, None]) & (truth[:, None] <= ends[..., 1])
        low, high = ends[:, STANDARD_LEVELS.index(SCORED)].T
        found.append(
            {
                "regime": name,
                "ids": ids,
                "method": method,
                "lengths": len(entries),
                "coverage": {level: vars(coverage(hits[:, k])) for k, level in enumerate(STANDARD_LEVELS)},
                "score_mm": 1e3 * float(np.mean(interval_score(low, high, truth, SCORED))),
                "width_mm": 1e3 * float(np.mean(high - low)),
            }
        )
    return found


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    head = ["regime", "ids", "method", "lengths", *(f"{100 * level:g} %" for level in STANDARD_LEVELS)]
    lines = [[*head, "score mm", "width mm"]]
    lines.append(["---"] * len(lines[0]))
    for row in rows:
        shares = [f"{100 * row['coverage'][level]['share']:.1f}" for level in STANDARD_LEVELS]
        last = [f"{row['score_mm']:.2f}", f"{row['width_mm']:.2f}"]
        ids = "yes" if row["ids"] else "no"
        lines.append([row["regime"], ids, row["method"], str(row["lengths"]), *shares, *last])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks.calibration",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--out", type=Path, required=True, help="folder; rooms that it holds are not run again"
    )
    parser.add_argument("--rooms", type=int, default=200, help="rooms per regime (default 200)")
    parser.add_argument("--seed", type=int, default=20_000, help="seed of the first room (default 20000)")
    parser.add_argument(
        "--regimes", nargs="+", choices=list(REGIMES), default=list(REGIMES), metavar="REGIME"
    )
    parser.add_argument("--ids", nargs="+", choices=("no", "yes"), default=["no", "yes"], help="frame ids")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--sbc", type=int, default=0, help="rooms of the sampler's rank test (default none)")
    return parser.parse_args(arguments)


def main(arguments: list[str] | None = None) -> int:
    """Run what is missing, write the tables."""
    wanted = parse(arguments)
    wanted.out.mkdir(parents=True, exist_ok=True)
    journal = wanted.out / "rooms.jsonl"
    lines = journal.read_text(encoding="utf-8").splitlines() if journal.exists() else []
    # The last line may be torn where the study was interrupted.
    records = [json.loads(line) for line in lines if line.endswith("}")]
    journal.write_text("".join(json.dumps(record) + "\n" for record in records), encoding="utf-8")
    done = {(record["regime"], record["ids"], record["seed"]) for record in records}
    tasks = [
        (name, ids == "yes", wanted.seed + k)
        for name in wanted.regimes
        for ids in wanted.ids
        for k in range(wanted.rooms)
    ]
    missing = [task for task in tasks if task not in done]
    with ProcessPoolExecutor(wanted.jobs) as pool, journal.open("a", encoding="utf-8") as file:
        for k, record in enumerate(pool.map(run_room, missing), start=1):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            print(f"{k} of {len(missing)} rooms", file=sys.stderr, flush=True)
    asked = set(tasks)
    rows = summary([r for r in records if (r["regime"], r["ids"], r["seed"]) in asked])
    document: dict[str, Any] = {"rows": rows}
    if wanted.sbc:
        from benchmarks.rank_test import rank_histograms

        document["sbc"] = rank_histograms(wanted.sbc, wanted.seed)
    temporary = wanted.out / "results.json.part"
    temporary.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, wanted.out / "results.json")
    (wanted.out / "table.md").write_text(table(rows), encoding="utf-8")
    print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
