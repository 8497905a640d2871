"""One room: simulated, fitted, compared."""

import resource
import time
import traceback
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Int

from benchmarks.outcome import Job, Outcome, PlanPicture
from benchmarks.suites import SUITES
from indoorfit import IndoorfitError, RunConfig
from indoorfit.evaluate import Comparison, LengthCheck, compare, isprs_curves
from indoorfit.fitting import BeliefConfig
from indoorfit.measure import at_level
from indoorfit.model import Face, FitResult, Frame, Scan
from indoorfit.pipeline import fit_scan, truth_result
from indoorfit.simulate import VirtualScan
from indoorfit.texture import TextureConfig

_N_DOTS = 5000
_SEEN_CELL_M = 0.10
_SEEN_SHARE = 0.20
_UNSEEN_SHARE = 0.02
"""A plane counts as seen if points lie in a fifth of its cells of 10 cm, as unseen below a fiftieth; what is
between is not judged: nobody can say whether a wall of which a corner shows is measured or inferred."""


_NOTHING = (float("nan"), float("nan"), float("nan"))


@dataclass(frozen=True)
class _Run:
    """One call of the program and its cost."""

    result: FitResult | None
    fault: str
    crashed: bool
    cpu_s: float
    wall_s: float
    peak_mb: float


def judge(job: Job) -> Outcome:
    """Everything about one room."""
    virtual = SUITES[job.suite].make(job.seed)
    scan = virtual.scan if job.frame_ids else replace(virtual.scan, frame_ids=None, frames=())
    try:
        truth = truth_result(virtual.shape, virtual.frame, {}, job.seed)
    except AssertionError:
        # Rooms that the survey cannot name the faces of: nobody can be right about them.
        return _without_truth(job)
    run = _fit(scan, job, job.levels[0])
    comparison, isprs = None, _NOTHING
    others: dict[float, tuple[LengthCheck, ...]] = {}
    notes: tuple[str, ...] = ()
    faults = (run.fault,) if run.fault else ()
    if run.result is not None:
        comparison = compare(run.result, truth, _seen(virtual, truth))
        curves = isprs_curves(run.result, truth, (0.10,))
        isprs = (curves.completeness[0], curves.correctness[0], curves.accuracy_m[0])
        notes = tuple(sorted({note.code for note in run.result.notes}))
        faults = comparison.faults
        others = {
            level: _at_level(comparison.lengths, at_level(run.result, level)) for level in job.levels[1:]
        }
    return Outcome(
        job=job,
        right=not faults,
        faults=faults,
        comparison=comparison,
        isprs=isprs,
        other_levels=others,
        notes=notes,
        crashed=run.crashed,
        cpu_s=run.cpu_s,
        wall_s=run.wall_s,
        peak_mb=run.peak_mb,
        picture=_picture(scan, truth, run.result, comparison, job.seed),
    )


def _without_truth(job: Job) -> Outcome:
    fault = "crashed: the true model cannot be written down\n" + traceback.format_exc(limit=-1)
    nan = float("nan")
    return Outcome(job, False, (fault,), None, _NOTHING, {}, (), True, nan, nan, nan)


def _fit(scan: Scan, job: Job, level: float) -> _Run:
    # Frames are used only where they are asked for; without ids in the scan there is nothing to use.
    belief = BeliefConfig(use_frames=job.frame_ids)
    # Colours change no length; benchmarks.textures judges them.
    bare = TextureConfig(enabled=False)
    config = RunConfig(method=job.method, level=level, belief=belief, texture=bare)  # type: ignore[arg-type]
    result, fault, crashed = None, "", False
    _forget_peak()
    cpu, wall = time.process_time(), time.perf_counter()
    try:
        result = fit_scan(scan, config)
    except IndoorfitError as error:
        fault = f"refused: {error}"
    except Exception:
        # A benchmark must come to its end and tell which rooms the program fails on.
        fault, crashed = "crashed: " + traceback.format_exc(limit=-3), True
    cpu_s, wall_s = time.process_time() - cpu, time.perf_counter() - wall
    return _Run(result, fault, crashed, cpu_s, wall_s, _peak_mb())


def _at_level(checks: tuple[LengthCheck, ...], result: FitResult) -> tuple[LengthCheck, ...]:
    """The same lengths with the intervals of the same model at another level."""
    intervals = {d.id: d.quantity.interval for d in result.dimensions}
    return tuple(
        replace(
            check,
            level=result.level,
            low_m=intervals[check.model].low,
            high_m=intervals[check.model].high,
        )
        for check in checks
    )


def _forget_peak() -> None:
    """Start the count of peak memory anew, where the system can (Linux)."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return


def _peak_mb() -> float:
    """Peak resident memory since `_forget_peak`; since the start of the process where there is no /proc."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
        return float(next(line.split()[1] for line in lines if line.startswith("VmHWM"))) / 1024.0
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _seen(virtual: VirtualScan, truth: FitResult) -> dict[str, bool]:
    """Which true faces the scan has points on; those in doubt are left out."""
    in_manhattan_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    seen = {}
    for face in truth.faces:
        own = virtual.shape.planes[face.plane]
        axes = [axis for axis in range(3) if axis != own.axis]
        points_m = own.to_own(in_manhattan_m[virtual.point_plane == face.plane])[:, axes]
        corners_m = own.to_own(virtual.frame.to_manhattan(face.rings_m[0]))[:, axes]
        # Faces of one plane lie apart; drift carries points over their edges by less than a cell.
        low_m, high_m = corners_m.min(axis=0) - _SEEN_CELL_M, corners_m.max(axis=0) + _SEEN_CELL_M
        own_m = points_m[np.all((points_m > low_m) & (points_m < high_m), axis=1)]
        cells: Int[np.ndarray, "n 2"] = np.floor(own_m / _SEEN_CELL_M).astype(int)
        share = len(np.unique(cells, axis=0)) * _SEEN_CELL_M**2 / _area_m2(face)
        if share >= _SEEN_SHARE or share < _UNSEEN_SHARE:
            seen[face.id] = share >= _SEEN_SHARE
    return seen


def _area_m2(face: Face) -> float:
    """By the shoelace formula; holes count negative because they run the other way."""
    total = np.zeros(3)
    for ring in face.rings_m:
        total += 0.5 * np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)
    return float(np.linalg.norm(total))


def _picture(
    scan: Scan, truth: FitResult, result: FitResult | None, comparison: Comparison | None, seed: int
) -> PlanPicture:
    points_m = truth.frame.to_manhattan(scan.points_m)
    floor_m, ceiling_m = (f(p.offset_m for p in truth.shape.planes if p.axis == 2) for f in (min, max))
    middle = points_m[(points_m[:, 2] > floor_m + 0.3) & (points_m[:, 2] < ceiling_m - 0.3)]
    some = np.random.default_rng(seed).permutation(len(middle))[:_N_DOTS]
    found = set() if comparison is None else set(comparison.pairs)
    sound = set() if comparison is None else set(comparison.pairs.values())
    true_lines = [
        (*_line(face, truth.frame), face.id in found) for face in truth.faces if face.kind == "wall"
    ]
    lines = []
    for face in () if result is None else result.faces:
        if face.kind == "wall":
            lines.append((*_line(face, truth.frame), face.status if face.id in sound else "wrong"))
    return PlanPicture(middle[some, :2].astype(np.float32), tuple(true_lines), tuple(lines))


def _line(face: Face, frame: Frame) -> tuple[float, float, float, float]:
    """A wall from above: the two corners of its ring that are furthest apart in plan."""
    ring_m = frame.to_manhattan(face.rings_m[0])[:, :2]
    start = ring_m[0]
    end = ring_m[np.argmax(np.linalg.norm(ring_m - start, axis=1))]
    start = ring_m[np.argmax(np.linalg.norm(ring_m - end, axis=1))]
    return float(start[0]), float(start[1]), float(end[0]), float(end[1])
