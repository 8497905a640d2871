"""A batch from its manifest to rows on disk, resumed where an earlier run was cut off."""

import json
import logging
import os
import time
from dataclasses import dataclass, field
from pathlib import Path

from indoorfit.errors import ConfigError, OutputError
from indoorfit.files import atomic_file
from indoorfit.stages import counted

from .cluster import run_on_dask
from .collect import TABLE_FILES
from .jobs import Job, Row, Timing
from .manifest import Study
from .pool import Limits, run_in_processes
from .settings import changed_settings

log = logging.getLogger("indoorfit")

MARK = "batch.json"
_SCHEMA = "indoorfit.batch/1"


@dataclass(frozen=True)
class RunOptions:
    """How a batch is run; none of it changes a result."""

    workers: int | None = None
    """Local processes; None takes one per core."""
    scheduler: str | None = None
    """Address of a Dask scheduler; None runs on this machine."""
    limits: Limits = field(default_factory=Limits)


def run_batch(study: Study, out: str | Path, options: RunOptions | None = None) -> dict[str, Row]:
    """Run every job that has no row in the directory yet; rows are written as they come in.

    Args:
        study: what to run.
        out: the directory of the batch, made if missing. An earlier one is gone on with: rows whose scan,
            settings, readings and version are the same are kept, everything else is run.
        options: see `RunOptions`.

    Returns:
        the rows by key, for all jobs of the study.

    Raises:
        OutputError: the directory holds something else, or cannot be written.
        ConfigError: an option is wrong.
    """
    options = options or RunOptions()
    workers = _checked(options)
    folder = Path(out)
    _open(study, folder)
    rows = {job.key: row for job in study.jobs if (row := _kept(folder, job)) is not None}
    by_key = {job.key: job for job in study.jobs}
    missing = [job for key, job in by_key.items() if key not in rows]
    if rows:
        log.info("%d of %d results are there already", len(rows), len(by_key))
    if missing:
        # Tables of an earlier manifest must not stand beside a run that is cut off.
        for name in TABLE_FILES:
            (folder / name).unlink(missing_ok=True)
    progress = _Progress(len(missing))
    counted(0, len(missing))

    def keep(job: Job, row: Row, timing: Timing) -> None:
        _write(folder / "rows" / f"{job.key}.json", row)
        _write(folder / "timings" / f"{job.key}.json", timing)
        rows[job.key] = row
        progress.tell(job, row, timing)

    if missing and options.scheduler is not None:
        run_on_dask(missing, options.scheduler, options.limits.retries, keep)
    elif missing:
        run_in_processes(missing, min(workers, len(missing)), options.limits, keep)
    return rows


def _checked(options: RunOptions) -> int:
    limits = options.limits
    workers = options.workers if options.workers is not None else len(_cores())
    if workers < 1 or limits.retries < 0 or limits.timeout_s <= 0 or (limits.memory_gb or 1.0) <= 0:
        raise ConfigError(
            f"evaluate: got {workers} workers, {limits.retries} retries, {limits.timeout_s:g} s, "
            f"{limits.memory_gb} GB; needed are at least 1 worker, 0 retries and limits above 0. "
            "Fix: leave them out for the defaults."
        )
    if options.scheduler is not None and (limits.memory_gb is not None or options.workers is not None):
        raise ConfigError(
            "--scheduler: a cluster has its own workers and memory limits. Fix: leave --workers and "
            "--memory-gb out; give them to the Dask workers (dask worker --nthreads 1 --memory-limit 4GB)."
        )
    return workers


def _cores() -> set[int]:
    """The cores that this process may use, which on shared machines are fewer than there are."""
    if hasattr(os, "sched_getaffinity"):
        return os.sched_getaffinity(0)
    return set(range(os.cpu_count() or 1))


def _open(study: Study, folder: Path) -> None:
    """Make the directory, or make sure that it is an earlier batch; and say in it what belongs to it."""
    try:
        if folder.exists() and not folder.is_dir():
            raise OutputError(f"{folder}: is no directory. Fix: choose another --out.")
        if folder.is_dir() and any(folder.iterdir()) and not (folder / MARK).is_file():
            raise OutputError(f"{folder}: holds something that is no batch. Fix: choose another --out.")
        for name in ("rows", "timings"):
            (folder / name).mkdir(parents=True, exist_ok=True)
            for remnant in (folder / name).glob(".*.part"):
                # Of a run that was killed while it wrote.
                remnant.unlink(missing_ok=True)
    except OSError as e:
        raise OutputError(f"{folder}: cannot be written: {e.strerror}. Fix: choose another --out.") from e
    entries = [
        {"name": j.name, "room": j.room, "sensor": j.sensor, "config": j.config_name, "key": j.key}
        for j in study.jobs
    ]
    settings = {j.config_name: changed_settings(j.config) for j in study.jobs}
    content = {"schema": _SCHEMA, "manifest": study.name, "sha256": study.sha256}
    content |= {"configs": settings, "jobs": entries}
    _write(folder / MARK, content)


def _kept(folder: Path, job: Job) -> Row | None:
    """The row of an earlier run, if it is whole and final."""
    try:
        row = json.loads((folder / "rows" / f"{job.key}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    final = isinstance(row, dict) and row.get("key") == job.key and row.get("state") in ("done", "failed")
    if not final or (
        job.model_dir is not None and row["state"] == "done" and not Path(job.model_dir).is_dir()
    ):
        return None
    return row


def _write(path: Path, content: dict) -> None:
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False, sort_keys=True) + "\n"
    with atomic_file(path) as file:
        file.write(text.encode("utf-8", "replace"))


@dataclass
class _Progress:
    total: int
    done: int = 0
    start_s: float = field(default_factory=time.monotonic)

    def tell(self, job: Job, row: Row, timing: Timing) -> None:
        """One line on the log for each row."""
        self.done += 1
        left_s = (time.monotonic() - self.start_s) / self.done * (self.total - self.done)
        said = (
            f"{len(row['lengths'])} lengths" if row["state"] == "done" else f"{row['state']}: {row['reason']}"
        )
        log.info(
            "[%d/%d] %s, %s: %s (%.1f s; about %.0f s left)",
            self.done, self.total, job.name, job.config_name, said, timing["wall_s"], left_s,
        )  # fmt: skip
        counted(self.done, self.total)
