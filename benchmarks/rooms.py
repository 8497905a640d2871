"""Accuracy on simulated rooms: structure, largest error, and whether the intervals hold.

    python benchmarks/rooms.py --rooms 12 --seed 1 --jobs 2
    python benchmarks/rooms.py --suites full sparse --keep failures

Suites (rooms are box, L, U, X, T, Z and stair in turn, of random size; any yaw, tilt to 6 degrees):

    thesis         120 to 200 thousand points, noise of 0.5 cm (thesis 5.1.1)
    full           the same with a furniture box and a window; in half of the rooms the box hides the wall
    kinect         line-of-sight noise of 4 cm at 5 m, level and not turned
    kinect-turned  the same rooms, tilted and turned
    sparse         5000 points, noise of 1 cm, 2 % outliers

One row per suite: RMS and largest error of the lengths and the room that it is in, share of intervals that
hold the truth, their median width; all of these over the rooms whose structure is right. Every room that
fails is listed below with its kind and seed; --keep writes its scan, truth and outputs, plan included.
"""

import argparse
import multiprocessing
import time
from dataclasses import dataclass, replace
from pathlib import Path

from indoorfit.cli.runtime import prepare_numerics

# Before NumPy: this module is imported again in every worker.
prepare_numerics()

import numpy as np  # noqa: E402

from indoorfit import ConfigError, IndoorfitError, RunConfig  # noqa: E402
from indoorfit.api import RoomModel  # noqa: E402
from indoorfit.io import write_model_json, write_ply  # noqa: E402
from indoorfit.model import FitResult, Shape  # noqa: E402
from indoorfit.pipeline import fit_scan, truth_result  # noqa: E402
from indoorfit.simulate import SamplingSettings, VirtualScan, room_shape, sample_surface  # noqa: E402
from matching import Comparison, compare  # noqa: E402
from tables import print_machine, print_table  # noqa: E402

KINDS = ("box", "L", "U", "X", "T", "Z", "stair")
SUITES = ("thesis", "full", "kinect", "kinect-turned", "sparse")
SIZES_M = {"box": (5.0, 4.0), "L": (5.08, 3.2), "U": (6.0, 4.0), "X": (6.0, 5.5)}
MAX_TILT_RAD = np.radians(6.0)


@dataclass(frozen=True)
class Job:
    """One room of one suite; everything about it follows from these."""

    suite: str
    kind: str
    seed: int
    method: str
    level: float
    keep: Path | None


@dataclass(frozen=True)
class Outcome:
    """What became of it."""

    job: Job
    comparison: Comparison | None
    """None where the scan was refused."""
    remark: str
    seconds: float


def random_shape(kind: str, rng: np.random.Generator) -> Shape:
    """A room of the kind, each extent some 10 to 35 % off the preset's."""
    length_m, width_m = SIZES_M.get(kind, (6.0, 4.5))
    for _ in range(20):
        try:
            return room_shape(
                kind,
                length_m=length_m * rng.uniform(0.9, 1.35),
                width_m=width_m * rng.uniform(0.9, 1.35),
                height_m=rng.uniform(2.4, 3.2),
            )
        except ConfigError:
            continue  # the notches of the preset leave no room in this size
    return room_shape(kind)


def simulate(suite: str, kind: str, seed: int) -> VirtualScan:
    """The scan of one room; the same shape and pose in every suite."""
    rng = np.random.default_rng(seed)
    shape = random_shape(kind, rng)
    settings = SamplingSettings(
        n_points=int(rng.integers(120_000, 200_001)),
        yaw_rad=rng.uniform(0.0, 2.0 * np.pi),
        tilt_rad=rng.uniform(0.0, MAX_TILT_RAD),
        tilt_azimuth_rad=rng.uniform(0.0, 2.0 * np.pi),
    )
    if suite == "full":
        settings = replace(settings, n_furniture=1, n_windows=1, furniture_hides=bool(seed % 2))
    elif suite.startswith("kinect"):
        settings = replace(settings, noise="kinect")
        if suite == "kinect":
            settings = replace(settings, yaw_rad=0.0, tilt_rad=0.0)
    elif suite == "sparse":
        settings = replace(settings, n_points=5000, sigma_m=0.01, outlier_share=0.02)
    return sample_surface(shape, settings, rng, name=f"{suite}-{kind}-{seed}")


def run(job: Job) -> Outcome:
    """Simulate, fit, compare."""
    virtual = simulate(job.suite, job.kind, job.seed)
    truth = truth_result(virtual.shape, virtual.frame, {"kind": job.kind, "suite": job.suite}, job.seed)
    start = time.perf_counter()
    try:
        result = fit_scan(virtual.scan, RunConfig(method=job.method, level=job.level))  # type: ignore[arg-type]
    except Exception as error:
        # A traceback is a fault of ours, but one room's must not hide the figures of the others.
        verdict = "refused" if isinstance(error, IndoorfitError) else f"CRASHED with {type(error).__name__}"
        _keep(job, virtual, truth, None)
        return Outcome(job, None, f"{verdict}: {error}", time.perf_counter() - start)
    seconds = time.perf_counter() - start
    comparison = compare(truth, result)
    if comparison.right and comparison.watertight:
        return Outcome(job, comparison, "", seconds)
    _keep(job, virtual, truth, result)
    return Outcome(job, comparison, _remark(comparison, result), seconds)


def _remark(comparison: Comparison, result: FitResult) -> str:
    codes = sorted({note.code for note in result.notes})
    parts = {
        "missing": comparison.missing,
        "extra": comparison.extra,
        "no dimension": comparison.lost,
        "warnings": codes,
    }
    said = [f"{name} {', '.join(ids)}" for name, ids in parts.items() if ids]
    if not comparison.watertight:
        said.append("not watertight")
    return "; ".join([f"{comparison.n_rooms} room(s)", *said])


def _keep(job: Job, virtual: VirtualScan, truth: FitResult, result: FitResult | None) -> None:
    if job.keep is None:
        return
    job.keep.mkdir(parents=True, exist_ok=True)
    name = virtual.scan.name
    write_ply(job.keep / f"{name}.ply", virtual.scan)
    write_model_json(job.keep / f"{name}.truth.json", truth)
    if result is not None:
        RoomModel(result, virtual.scan).write(job.keep / name, overwrite=True)


def row(suite: str, outcomes: list[Outcome]) -> list[str]:
    """The figures of one suite; lengths of rooms whose structure is right."""
    compared = [outcome.comparison for outcome in outcomes if outcome.comparison is not None]
    right = [comparison for comparison in compared if comparison.right]
    tight = sum(comparison.watertight for comparison in compared)
    n = len(outcomes)
    cells = [suite, f"{len(right)}/{n}", f"{tight}/{n}"]
    if not right:
        return [*cells, *["-"] * 7]
    errors_cm = 100.0 * np.concatenate([comparison.errors_m for comparison in right])
    hits = np.concatenate([comparison.hits for comparison in right])
    worst = max(
        (o for o in outcomes if o.comparison is not None and o.comparison.right),
        key=lambda o: np.abs(o.comparison.errors_m).max(),
    )
    widths_cm = 100.0 * np.concatenate([comparison.widths_m for comparison in right])
    return [
        *cells,
        f"{np.sqrt(np.mean(errors_cm**2)):.4f}",
        f"{np.abs(errors_cm).max():.4f}",
        f"{worst.job.kind} {worst.job.seed}",
        f"{100.0 * hits.mean():.1f}",
        f"{np.median(widths_cm):.4f}",
        str(len(hits)),
        f"{np.mean([outcome.seconds for outcome in outcomes]):.2f}",
    ]


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rooms", type=int, default=12, help="rooms per suite")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first room")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--suites", nargs="+", choices=SUITES, default=list(SUITES))
    parser.add_argument("--method", choices=("joint", "greedy"), default="joint")
    parser.add_argument("--level", type=float, default=0.95, help="of the intervals")
    parser.add_argument("--keep", type=Path, help="folder for scan, truth and outputs of rooms that fail")
    return parser.parse_args()


def main() -> None:
    """Run the suites and print the table."""
    wanted = parse()
    jobs = [
        Job(suite, KINDS[k % len(KINDS)], wanted.seed + k, wanted.method, wanted.level, wanted.keep)
        for suite in wanted.suites
        for k in range(wanted.rooms)
    ]
    with multiprocessing.get_context("spawn").Pool(wanted.jobs) as pool:
        outcomes = pool.map(run, jobs, chunksize=1)
    print_machine()
    print(f"{wanted.method}, {wanted.rooms} rooms a suite from seed {wanted.seed}, {wanted.jobs} processes\n")
    head = (
        "suite", "right", "watertight", "RMS cm", "largest cm", "in", f"held % of {100 * wanted.level:g}",
        "width cm", "lengths", "s/room",
    )  # fmt: skip
    print_table(head, [row(suite, [o for o in outcomes if o.job.suite == suite]) for suite in wanted.suites])
    for outcome in outcomes:
        if outcome.remark:
            print(f"\n{outcome.job.suite} {outcome.job.kind} seed {outcome.job.seed}: {outcome.remark}")


if __name__ == "__main__":
    main()
