"""Do the intervals hold what they promise? Through the whole pipeline, on simulated rooms.

    python -m benchmarks.calibration --out calibration                      200 rooms a regime
    python -m benchmarks.calibration --out calibration --rooms 20 --regimes drift5mm clutter
    python -m benchmarks.calibration --out calibration --regimes drift5mm --sbc 100
    python -m benchmarks.calibration --out calibration --tables                           runs none

Every room is one line of rooms.jsonl in the folder; rooms that are there are not run again, so an interrupted
study goes on where it stopped. Rooms are run in turn over all regimes, so that it is about as far with each.
At the end the folder has results.json and table.md: coverage at 50, 80, 90, 95 and 99 %, mean interval
score and width at 95 %, of the joint fit and of what it must beat: the greedy fit, points taken as
independent (the negative control: at 5 mm drift it must hold less than 25 %), CR2 and the bootstrap on
patches; then the errors of joint and greedy on the lengths that both measured. --sbc adds rank histograms
of the sampler on rooms from the noise model's own prior. calibration.json beside this file is the
results.json of the study that docs/intervals.md tells of.
"""

import argparse
import json
import os
import sys
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from indoorfit.environment import prepare_numerics

# Before NumPy, and before the worker processes, which inherit the settings.
prepare_numerics()

import numpy as np  # noqa: E402

from benchmarks.paired import paired, paired_table  # noqa: E402
from benchmarks.suites import FURNISHED, SLIPPED, SUITES, scanned  # noqa: E402
from benchmarks.yardsticks import yardsticks  # noqa: E402
from indoorfit import IndoorfitError, RunConfig  # noqa: E402
from indoorfit.evaluate import compare, coverage, interval_score  # noqa: E402
from indoorfit.fitting import BeliefConfig  # noqa: E402
from indoorfit.measure import at_level  # noqa: E402
from indoorfit.model import STANDARD_LEVELS, FitResult  # noqa: E402
from indoorfit.pipeline import fit_scan, truth_result  # noqa: E402
from indoorfit.simulate import VirtualScan, regime  # noqa: E402
from indoorfit.texture import TextureConfig  # noqa: E402

SCORED = 0.95

REGIMES: dict[str, Callable[[int], VirtualScan]] = {
    "drift0": lambda seed: scanned(seed, regime("0")),
    **{
        name: SUITES[name].make
        for name in ("drift5mm", "drift2cm", "drift5cm", "clutter", "slipped", "kinect", "laser")
    },
    "clutter2cm": lambda seed: scanned(seed, regime("2cm"), FURNISHED),
    "slipped-clutter": lambda seed: scanned(seed, SLIPPED, FURNISHED),
    "phone": lambda seed: scanned(seed, regime("5mm"), sensor="phone_lidar"),
}
"""Kinect unless the name says otherwise; each is run with and without frame ids."""
WITHOUT_FRAMES = {"kinect"}
"""Points drawn from the surface belong to no frame; there is only one way to run these."""


def run_room(task: tuple[str, bool, int]) -> dict[str, Any]:
    """One room under all methods, as plain values."""
    name, ids, seed = task
    record: dict[str, Any] = {"regime": name, "ids": ids, "seed": seed, "lengths": [], "refused": []}
    virtual = REGIMES[name](seed)
    scan = virtual.scan if ids else replace(virtual.scan, frame_ids=None, frames=())
    truth = truth_result(virtual.shape, virtual.frame, {}, seed)
    for method in ("joint", "greedy"):
        config = RunConfig(
            method=method,  # type: ignore[arg-type]
            belief=BeliefConfig(use_frames=ids),
            texture=TextureConfig(enabled=False),
        )
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
                entry = {"method": way, "length": check.truth, "kind": check.kind, "true": check.true_m}
                record["lengths"].append({**entry, "value": check.value_m, "ends": ends[check.model]})
    return record


def _intervals(result: FitResult) -> dict[str, list[tuple[float, float]]]:
    """By dimension, low and high end at every standard level."""
    found: dict[str, list[tuple[float, float]]] = {d.id: [] for d in result.dimensions}
    for level in STANDARD_LEVELS:
        for d in at_level(result, level).dimensions:
            found[d.id].append((d.quantity.interval.low, d.quantity.interval.high))
    return found


def summary(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row per regime, with or without ids, and method; coverage has Wilson's interval.

    `rooms` were run; of `judged` the structure was right, so that lengths could be compared.
    """
    rows: dict[tuple[str, bool, str], list[dict[str, Any]]] = {}
    rooms, judged = Counter[tuple[str, bool]](), Counter[tuple[str, bool, str]]()
    for record in records:
        key = record["regime"], record["ids"]
        rooms[key] += 1
        judged.update((*key, method) for method in {entry["method"] for entry in record["lengths"]})
        for entry in record["lengths"]:
            rows.setdefault((*key, entry["method"]), []).append(entry)
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
                "rooms": rooms[name, ids],
                "judged": judged[name, ids, method],
                "lengths": len(entries),
                "coverage": {level: _shares(hits[:, k]) for k, level in enumerate(STANDARD_LEVELS)},
                "score_mm": round(1e3 * float(np.mean(interval_score(low, high, truth, SCORED))), 4),
                "width_mm": round(1e3 * float(np.mean(high - low)), 4),
            }
        )
    return found


def _shares(hits: np.ndarray) -> dict[str, float]:
    found = coverage(hits)
    return {"share": round(found.share, 4), "low": round(found.low, 4), "high": round(found.high, 4)}


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    head = [
        "regime",
        "ids",
        "method",
        "rooms",
        "lengths",
        *(f"{100 * level:g} %" for level in STANDARD_LEVELS),
    ]
    lines = [[*head, "score mm", "width mm"]]
    lines.append(["---"] * len(lines[0]))
    for row in rows:
        shares = [f"{100 * row['coverage'][level]['share']:.1f}" for level in STANDARD_LEVELS]
        last = [f"{row['score_mm']:.2f}", f"{row['width_mm']:.2f}"]
        ids = "yes" if row["ids"] else "no"
        rooms = f"{row['judged']} of {row['rooms']}"
        lines.append([row["regime"], ids, row["method"], rooms, str(row["lengths"]), *shares, *last])
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
    parser.add_argument(
        "--tables", action="store_true", help="run nothing: tables of the rooms in the folder"
    )
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
    if not wanted.tables:
        records = _completed(wanted, records, journal)
    document: dict[str, Any] = {"levels": STANDARD_LEVELS, "scored": SCORED, "rows": summary(records)}
    document["paired"] = paired(records, wanted.seed)
    if wanted.sbc:
        from benchmarks.rank_test import rank_histograms

        document["sbc"] = rank_histograms(wanted.sbc, wanted.seed)
    temporary = wanted.out / "results.json.part"
    temporary.write_text(_one_row_a_line(document), encoding="utf-8")
    os.replace(temporary, wanted.out / "results.json")
    text = table(document["rows"]) + "\n" + paired_table(document["paired"])
    (wanted.out / "table.md").write_text(text, encoding="utf-8")
    print(text)
    return 0


def _completed(
    wanted: argparse.Namespace, records: list[dict[str, Any]], journal: Path
) -> list[dict[str, Any]]:
    """All records that were asked for; those that are missing are run, and written as they come."""
    done = {(record["regime"], record["ids"], record["seed"]) for record in records}
    tasks = [
        (name, ids == "yes", wanted.seed + k)
        for k in range(wanted.rooms)
        for name in wanted.regimes
        for ids in wanted.ids
        if ids == "no" or name not in WITHOUT_FRAMES
    ]
    missing = [task for task in tasks if task not in done]
    with ProcessPoolExecutor(wanted.jobs) as pool, journal.open("a", encoding="utf-8") as file:
        for k, record in enumerate(pool.map(run_room, missing), start=1):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            print(f"{k} of {len(missing)} rooms", file=sys.stderr, flush=True)
    asked = set(tasks)
    return [r for r in records if (r["regime"], r["ids"], r["seed"]) in asked]


def _one_row_a_line(document: dict[str, Any]) -> str:
    """JSON that people can read and compare line by line."""
    rows = ",\n".join("  " + json.dumps(row) for row in document["rows"])
    head = {key: value for key, value in document.items() if key != "rows"}
    return json.dumps(head)[:-1] + f', "rows": [\n{rows}\n]}}\n'


if __name__ == "__main__":
    sys.exit(main())
