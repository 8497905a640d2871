"""Every real scan of a folder through the whole pipeline: what came out, or why not.

    INDOORFIT_REAL_SCANS=~/scans python -m benchmarks.real --out plans --jobs 2

Real scans have no truth here, so nothing is judged: the table shows rooms, extents with their intervals,
warnings and time, and the folder of outputs holds a plan per scan to look at.
"""

import argparse
import multiprocessing
import os
import time
from dataclasses import dataclass
from pathlib import Path

from indoorfit.environment import prepare_numerics

# Before NumPy: this module is imported again in every worker.
prepare_numerics()

from benchmarks.tables import machine, table  # noqa: E402
from indoorfit import IndoorfitError, RunConfig  # noqa: E402
from indoorfit.api import RoomModel, fit, read  # noqa: E402

SUFFIXES = (".ply", ".pcd", ".xyz", ".txt", ".csv", ".pts", ".asc", ".npy", ".npz")


@dataclass(frozen=True)
class Job:
    """One scan."""

    scan: Path
    out: Path
    method: str
    seed: int


@dataclass(frozen=True)
class Outcome:
    """A row of the table, and what there is to say below it."""

    row: tuple[str, ...]
    remarks: tuple[str, ...]


def run(job: Job) -> Outcome:
    """Read, fit, write."""
    start = time.perf_counter()
    try:
        model = fit(read(job.scan), RunConfig(method=job.method, seed=job.seed))  # type: ignore[arg-type]
        model.write(job.out / job.scan.stem, overwrite=True)
    except IndoorfitError as error:
        seconds = f"{time.perf_counter() - start:.1f}"
        return Outcome((job.scan.name, "refused", "", "", seconds), (f"{job.scan.name}: {error}",))
    seconds = f"{time.perf_counter() - start:.1f}"
    status = "fitted" if model.result.converged else "not sound"
    remarks = [f"{job.scan.name}: {note.code}: {note.message}" for note in model.warnings]
    row = (job.scan.name, status, str(len(model.rooms)), str(len(model.faces)), seconds)
    return Outcome(row, (*[f"{job.scan.name}: {line}" for line in extents(model)], *remarks))


def extents(model: RoomModel) -> list[str]:
    """One line per room: overall lengths and height."""
    lines = []
    for room in model.rooms:
        sizes = [d for d in model.dimensions if d.room == room.id and d.kind in ("overall", "height")]
        numbers = [
            f"{d.quantity.value:.3f} ({d.quantity.interval.low:.3f} to {d.quantity.interval.high:.3f}"
            f"{', inferred' if d.status == 'inferred' else ''})"
            for d in sizes
        ]
        lines.append(f"{room.id}: {' x '.join(numbers)} m")
    return lines


def main() -> None:
    """Run all scans and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scans", type=Path, default=os.environ.get("INDOORFIT_REAL_SCANS"))
    parser.add_argument("--out", type=Path, default=Path("out/real"), help="folder for the outputs")
    parser.add_argument("--method", choices=("joint", "greedy"), default="joint")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    wanted = parser.parse_args()
    if wanted.scans is None or not Path(wanted.scans).is_dir():
        parser.error("no folder of scans: set INDOORFIT_REAL_SCANS or give --scans")
    scans = sorted(path for path in Path(wanted.scans).iterdir() if path.suffix.lower() in SUFFIXES)
    jobs = [Job(scan, wanted.out, wanted.method, wanted.seed) for scan in scans]
    with multiprocessing.get_context("spawn").Pool(wanted.jobs) as pool:
        outcomes = pool.map(run, jobs, chunksize=1)
    print(machine())
    print()
    print(table(("scan", "result", "rooms", "faces", "s"), [outcome.row for outcome in outcomes]))
    for outcome in outcomes:
        print()
        for line in outcome.remarks:
            print(line)


if __name__ == "__main__":
    main()
