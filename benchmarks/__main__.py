"""What indoorfit reaches on simulated rooms whose truth is known.

    python -m benchmarks                                   every suite, 24 rooms each
    python -m benchmarks thesis drift2cm --rooms 8         some
    python -m benchmarks clutter --method joint greedy     side by side
    python -m benchmarks --gate                            exit code 1 if anything is worse than the baseline

Prints a row per suite and way of fitting and every room that went wrong; --out gets all of it as results.json
and table.txt, a page per suite with truth and model drawn over the points, and the reliability of the
intervals. Figures are explained in benchmarks/baseline.json, suites by --list.
"""

import argparse
import json
import multiprocessing
import os
import sys
from pathlib import Path
from typing import Any

from indoorfit.environment import prepare_numerics

# Before NumPy, and before the worker processes, which inherit the settings.
prepare_numerics()

from benchmarks.baseline import BASELINE, accept, worse  # noqa: E402
from benchmarks.figures import FIGURES, Row, level_table, note_counts, room_record, row_of, side_by_side  # noqa: E402
from benchmarks.judge import judge  # noqa: E402
from benchmarks.outcome import Job, Outcome  # noqa: E402
from benchmarks.pictures import overlay_page, reliability_picture  # noqa: E402
from benchmarks.suites import SUITES  # noqa: E402
from benchmarks.tables import machine, table  # noqa: E402

Results = dict[tuple[str, str], list[Outcome]]
"""By way of fitting and suite."""


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("suites", nargs="*", metavar="SUITE", help="default: all")
    parser.add_argument("--list", action="store_true", help="say what the suites are, and stop")
    parser.add_argument("--rooms", type=int, default=24, help="rooms per suite (default 24)")
    parser.add_argument("--seed", type=int, default=9000, help="seed of the first room (default 9000)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--method", nargs="+", choices=("joint", "greedy"), default=["joint"])
    parser.add_argument("--frame-ids", action="store_true", help="keep and use the frame of every point")
    parser.add_argument(
        "--levels",
        nargs="+",
        type=float,
        default=[0.95],
        help="nominal coverages; the first is scored, all come from one fit",
    )
    parser.add_argument("--out", type=Path, help="folder for results, table and pictures")
    parser.add_argument("--baseline", type=Path, default=BASELINE)
    parser.add_argument("--gate", action="store_true", help="exit 1 if worse than the baseline")
    parser.add_argument("--accept", action="store_true", help="make these figures the baseline")
    wanted = parser.parse_args(arguments)
    wanted.suites = wanted.suites or list(SUITES)
    unknown = [name for name in wanted.suites if name not in SUITES]
    if unknown:
        parser.error(f"no such suite: {', '.join(unknown)}; there are {', '.join(SUITES)}")
    if min(wanted.rooms, wanted.jobs) < 1:
        parser.error("--rooms and --jobs must be at least 1")
    return wanted


def run(jobs: list[Job], n_processes: int) -> list[Outcome]:
    """Judge all rooms; progress to standard error."""
    outcomes = []
    # Fresh processes: a fork would inherit the threads of the numerics in an undefined state.
    with multiprocessing.get_context("spawn").Pool(min(n_processes, len(jobs))) as pool:
        for k, outcome in enumerate(pool.imap(judge, jobs), start=1):
            outcomes.append(outcome)
            if k % 10 == 0 or k == len(jobs):
                print(f"{k} of {len(jobs)} rooms", file=sys.stderr, flush=True)
    return outcomes


def row_texts(name: str, run_name: str, outcomes: list[Outcome], row: Row) -> list[str]:
    """One line of the table."""
    right = sum(outcome.right for outcome in outcomes)

    def text(figure: str, digits: int, factor: float = 1.0) -> str:
        value = row[figure]
        return "-" if value is None else f"{factor * value:.{digits}f}"

    return [
        name, run_name, f"{right}/{len(outcomes)}", text("footprint_iou", 4), text("solid_iou", 4),
        text("completeness", 3), text("correctness", 3), text("lost", 1, 100), text("rmse_mm", 2),
        text("mad_mm", 2), text("coverage", 1, 100), text("score_mm", 1), text("width_mm", 2),
        text("status", 1, 100), text("cpu_s", 2), text("peak_mb", 0),
    ]  # fmt: skip


_HEAD = (
    "suite", "run", "right", "plan IoU", "solid IoU", "compl.", "corr.", "lost %", "RMSE mm", "MAD mm",
    "held %", "score mm", "width mm", "status %", "CPU s", "peak MB",
)  # fmt: skip


def write_out(folder: Path, results: Results, document: dict[str, Any], text: str) -> None:
    """JSON, table and pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    temporary = folder / "results.json.part"
    temporary.write_text(json.dumps(document, indent=1, default=float) + "\n", encoding="utf-8")
    os.replace(temporary, folder / "results.json")
    (folder / "table.txt").write_text(text + "\n", encoding="utf-8")
    for (run_name, suite), outcomes in results.items():
        title = f"{suite}, {run_name}: {SUITES[suite].about}"
        overlay_page(outcomes, title, folder / f"{suite}-{run_name}.png")
    tables = {f"{suite}, {run_name}": level_table(o) for (run_name, suite), o in results.items()}
    everything = [outcome for outcomes in results.values() for outcome in outcomes]
    reliability_picture({"all": level_table(everything), **tables}, folder / "reliability.png")


def main(arguments: list[str] | None = None) -> int:
    """Run, print, write, judge; returns the exit code."""
    wanted = parse(arguments)
    if wanted.list:
        print(table(("suite", "what"), [(name, suite.about) for name, suite in SUITES.items()]))
        return 0
    jobs = [
        Job(suite, wanted.seed + k, method, wanted.frame_ids, tuple(wanted.levels))
        for method in wanted.method
        for suite in wanted.suites
        for k in range(wanted.rooms)
    ]
    results: Results = {}
    for outcome in run(jobs, wanted.jobs):
        results.setdefault((outcome.job.run, outcome.job.suite), []).append(outcome)
    rows: dict[str, dict[str, Row]] = {}
    for (run_name, suite), outcomes in results.items():
        rows.setdefault(run_name, {})[suite] = row_of(outcomes)
    lines = [row_texts(suite, name, o, rows[name][suite]) for (name, suite), o in results.items()]
    settings = {"rooms": wanted.rooms, "seed": wanted.seed}
    heading = f"{wanted.rooms} rooms a suite from seed {wanted.seed}, {wanted.jobs} processes; {machine()}"
    text = "\n\n".join([heading, table(_HEAD, lines), *compared(results), *remarks(results)])
    print(text)
    if wanted.out is not None:
        write_out(wanted.out, results, document(settings, rows, results), text)
    complaints = worse(wanted.baseline, rows, settings, wanted.levels[0]) if wanted.gate else []
    if wanted.accept:
        accept(wanted.baseline, rows, settings)
    for complaint in complaints:
        print(f"WORSE  {complaint}", file=sys.stderr)
    return 1 if complaints else 0


def compared(results: Results) -> list[str]:
    """Joint and greedy on the lengths that both found, where both were run."""
    lines = []
    for (run_name, suite), outcomes in results.items():
        greedy = results.get((run_name.replace("joint", "greedy"), suite))
        if not run_name.startswith("joint") or greedy is None:
            continue
        figures = side_by_side(outcomes, greedy)
        cells = [suite]
        for prefix in ("", "right_"):
            cells.append(str(int(figures[f"{prefix}lengths"])))
            for name in ("rmse_mm", "other_rmse_mm", "median_mm", "other_median_mm"):
                value = figures.get(f"{prefix}{name}")
                cells.append("-" if value is None else f"{value:.2f}")
        lines.append(cells)
    four = ("RMSE joint", "greedy", "median joint", "greedy")
    head = ("mm on lengths both found", "number", *four, "both right", *four)
    return [table(head, lines)] if lines else []


def remarks(results: Results) -> list[str]:
    """Every room that went wrong, and how often each warning came."""
    said = []
    for (run_name, suite), outcomes in results.items():
        lines = [f"{suite}, {run_name}: warnings {note_counts(outcomes) or 'none'}"]
        for outcome in outcomes:
            if not outcome.right:
                lines.append(f"  seed {outcome.job.seed}: {'; '.join(map(brief, outcome.faults))}")
        said.append("\n".join(lines))
    return said


def brief(fault: str) -> str:
    """A fault in one line; of a traceback, which results.json has whole, its kind and its last line."""
    first, *rest = fault.strip().splitlines()
    return f"{first.split(':')[0]}: {rest[-1].strip()}" if rest else first


def document(settings: dict[str, Any], rows: dict[str, dict[str, Row]], results: Results) -> dict[str, Any]:
    """All of it as plain values."""
    return {
        "settings": settings,
        "machine": machine(),
        "figures": {name: vars(figure) for name, figure in FIGURES.items()},
        "rows": rows,
        "reliability": {f"{suite}, {name}": level_table(o) for (name, suite), o in results.items()},
        "warnings": {f"{suite}, {name}": note_counts(o) for (name, suite), o in results.items()},
        "rooms": [room_record(outcome) for outcomes in results.values() for outcome in outcomes],
    }


if __name__ == "__main__":
    sys.exit(main())
