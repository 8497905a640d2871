"""One task: one scan with one configuration, from its source to a row of plain values."""

import time
from dataclasses import asdict, replace
from typing import Any

from indoorfit.errors import IndoorfitError
from indoorfit.evaluate import Comparison, LengthCheck, compare
from indoorfit.io import read_model_json, read_scan
from indoorfit.model import FitResult, Scan
from indoorfit.pipeline import fit_scan, with_tape, write_outputs

from .jobs import Job, Row, ScanFile, Timing, failed_row
from .simulated import simulate


def run_task(job: Job) -> tuple[Row, Timing]:
    """Fit, compare, and say what came of it. Never raises: a failure is a row with its reason.

    The row depends on the job alone, so it may be computed anywhere and any number of times.
    """
    start_s, cpu_start_s = time.perf_counter(), time.process_time()
    stages: dict[str, float] = {}
    try:
        row = _run(job, stages)
    except IndoorfitError as error:
        row = failed_row(job, str(error))
    except MemoryError:
        row = failed_row(job, "needed more memory than there is. Fix: fewer --workers.", lost=True)
    except Exception as error:
        # A fault of ours in one scan must not take the others along; the row names it.
        row = failed_row(job, f"a fault of the program: {type(error).__name__}: {error}")
    wall_s, cpu_s = time.perf_counter() - start_s, time.process_time() - cpu_start_s
    return row, {"key": job.key, "wall_s": wall_s, "cpu_s": cpu_s, "stages_s": stages}


def _run(job: Job, stages: dict[str, float]) -> Row:
    scan, truth = _source(job)
    config = job.config
    if job.model_dir is None:
        # Images change no number, and nobody would see them.
        config = replace(config, texture=replace(config.texture, enabled=False))
    result = fit_scan(scan, config)
    if job.tape is not None:
        result = with_tape(result, job.tape, job.name)
    if job.model_dir is not None:
        write_outputs(result, job.model_dir, scan, overwrite=True)
    stages.update(result.provenance["timings_s"])
    against = None if truth is None else compare(result, truth)
    return {
        "key": job.key,
        "state": "done",
        "reason": None,
        "converged": bool(result.converged),
        "points": int(scan.n_points),
        "rooms": len(result.rooms),
        "walls": sum(face.kind == "wall" for face in result.faces),
        "warnings": sorted({note.code for note in result.notes}),
        "structure": None if against is None else _structure(against),
        "lengths": [
            *([] if against is None else [_against_truth(result, check) for check in against.lengths]),
            *_against_tape(result),
        ],
        "tape": _tape(result),
    }


def _source(job: Job) -> tuple[Scan, FitResult | None]:
    if not isinstance(job.source, ScanFile):
        return simulate(job.source, job.name)
    scan = read_scan(job.source.path, unit=job.source.unit)  # pyright: ignore[reportArgumentType]
    if scan.sha256 != job.source.sha256:
        raise IndoorfitError(
            f"{scan.name}: has changed since the batch was planned. Fix: run the same command again."
        )
    return scan, None if job.source.truth is None else read_model_json(job.source.truth)


def _structure(against: Comparison) -> dict[str, Any]:
    return {"right": against.right, "faults": list(against.faults), "lost": list(against.lost)}


def _against_truth(result: FitResult, check: LengthCheck) -> dict[str, Any]:
    return {"reference": "truth", "reference_std_m": 0.0, "e_n": None, **_plain(result, check)}


def _against_tape(result: FitResult) -> list[dict[str, Any]]:
    if result.tape is None:
        return []
    known = {dimension.id: dimension for dimension in result.dimensions}
    rows = []
    for check in result.tape.checks:
        dimension = known[check.dimension]
        quantity = dimension.quantity
        length = LengthCheck(
            truth="line " + ", ".join(map(str, check.lines)),
            model=dimension.id,
            kind=dimension.kind,
            true_m=check.value_m,
            value_m=quantity.value,
            std_m=quantity.std,
            low_m=quantity.interval.low,
            high_m=quantity.interval.high,
            level=quantity.interval.level,
            status=dimension.status,
        )
        reference = {"reference": "tape", "reference_std_m": check.std_m, "e_n": check.e_n}
        rows.append({**reference, **_plain(result, length)})
    return rows


def _plain(result: FitResult, check: LengthCheck) -> dict[str, Any]:
    """A check, and how much of its standard uncertainty the residuals of the scan account for."""
    plain = {key: float(value) if key.endswith("_m") else value for key, value in asdict(check).items()}
    quantity = next(d.quantity for d in result.dimensions if d.id == check.model)
    data_std_m = quantity.std if quantity.budget is None else quantity.budget.data_std
    return {**plain, "data_std_m": float(data_std_m)}


def _tape(result: FitResult) -> dict[str, Any] | None:
    if result.tape is None:
        return None
    refused = [asdict(row) for row in result.tape.refused]
    return {
        "source": result.tape.source,
        "chi2": result.tape.chi2,
        "p_value": result.tape.p_value,
        "refused": refused,
    }
