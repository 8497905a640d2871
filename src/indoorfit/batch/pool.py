"""Local processes, one job at a time each, that may die without taking the batch along.

`concurrent.futures` gives all jobs up when one process dies, and does not tell which job it had. Here every
process has a pipe of its own, so that a death is one job's.
"""

import signal
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from indoorfit.environment import prepare_numerics

from .jobs import Job, Row, Timing, failed_row
from .worker import EXIT_MEMORY, serve

OnDone = Callable[[Job, Row, Timing], None]
_WAKE_S = 1.0
"""Deadlines are looked at this often: they are minutes long."""


@dataclass(frozen=True)
class Limits:
    """What one task may use."""

    memory_gb: float | None = None
    """Resident memory of a worker; None for no limit."""
    timeout_s: float = 1800.0
    """Wall-clock time: a scan of ten million points takes some minutes on a slow machine."""
    retries: int = 1
    """How often a task is tried again whose process died without a word."""


@dataclass
class _Worker:
    process: BaseProcess
    pipe: Connection
    job: Job | None = None
    attempt: int = 0
    started_s: float = 0.0


def run_in_processes(jobs: Sequence[Job], n_workers: int, limits: Limits, on_done: OnDone) -> None:
    """Run all jobs; each ends in exactly one call of `on_done`, in this process, in any order.

    Args:
        jobs: what to do.
        n_workers: processes; more than jobs are not started.
        limits: of each task.
        on_done: called with every row and timing as they come in.
    """
    # Fresh processes inherit the environment: single-threaded, with the compiled functions' cache.
    prepare_numerics()
    waiting: deque[tuple[Job, int]] = deque((job, 1) for job in jobs)
    crew: list[_Worker] = []
    try:
        while waiting or any(worker.job for worker in crew):
            while waiting:
                idle = next((worker for worker in crew if worker.job is None), None)
                if idle is None and len(crew) >= n_workers:
                    break
                if idle is None:
                    idle = _hired(limits)
                    crew.append(idle)
                _give(idle, *waiting.popleft())
            for worker in _ready(crew):
                _settle(worker, crew, waiting, limits, on_done)
            for worker in [w for w in crew if w.job and time.monotonic() - w.started_s > limits.timeout_s]:
                _overdue(worker, crew, limits, on_done)
    finally:
        for worker in crew:
            worker.process.kill()
            worker.process.join()


def _hired(limits: Limits) -> _Worker:
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    memory = None if limits.memory_gb is None else int(limits.memory_gb * 1e9)
    process = context.Process(target=serve, args=(theirs, memory), daemon=True)
    process.start()
    # Ours alone must be open, or the end of the worker would never be seen.
    theirs.close()
    return _Worker(process, ours)


def _give(worker: _Worker, job: Job, attempt: int) -> None:
    worker.job, worker.attempt, worker.started_s = job, attempt, time.monotonic()
    # A worker that is dead already shows itself when its pipe is read.
    try:
        worker.pipe.send(job)
    except OSError:
        pass


def _ready(crew: list[_Worker]) -> list[_Worker]:
    pipes = [worker.pipe for worker in crew if worker.job]
    found = wait(pipes, timeout=_WAKE_S)
    return [worker for worker in crew if worker.pipe in found]


def _settle(
    worker: _Worker, crew: list[_Worker], waiting: deque[tuple[Job, int]], limits: Limits, on_done: OnDone
) -> None:
    job, attempt = worker.job, worker.attempt
    assert job is not None
    try:
        row, timing = worker.pipe.recv()
    except (EOFError, OSError):
        crew.remove(worker)
        worker.process.join()
        worker.pipe.close()
        code = worker.process.exitcode or 0
        if code != EXIT_MEMORY and attempt <= limits.retries:
            waiting.append((job, attempt + 1))
        else:
            on_done(job, failed_row(job, _why(code, attempt, limits), lost=True), _no_time(job))
        return
    worker.job = None
    # The next job first: the worker must not wait for the disk.
    if waiting:
        _give(worker, *waiting.popleft())
    on_done(job, row, timing)


def _overdue(worker: _Worker, crew: list[_Worker], limits: Limits, on_done: OnDone) -> None:
    job = worker.job
    assert job is not None
    crew.remove(worker)
    worker.process.kill()
    worker.process.join()
    worker.pipe.close()
    reason = f"took longer than {limits.timeout_s:g} s and was ended. Fix: raise --timeout-s."
    on_done(job, failed_row(job, reason, lost=True), _no_time(job))


def _why(code: int, attempt: int, limits: Limits) -> str:
    if code == EXIT_MEMORY:
        return f"needed more than {limits.memory_gb:g} GB of memory and was ended. Fix: raise --memory-gb."
    if code < 0:
        cause = f"was killed ({signal.Signals(-code).name}, {attempt} time(s))"
        return f"{cause}; with SIGKILL mostly for lack of memory. Fix: fewer --workers."
    return f"ended its process with code {code}, {attempt} time(s). Fix: run it alone with indoorfit fit."


def _no_time(job: Job) -> Timing:
    return {"key": job.key, "wall_s": 0.0, "cpu_s": 0.0, "stages_s": {}}
