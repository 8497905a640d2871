"""The same jobs on a Dask cluster that is running already (SLURM, Kubernetes, a few machines)."""

from collections.abc import Sequence
from typing import Any

from indoorfit.errors import ConfigError

from .jobs import Job, Row, Timing, failed_row
from .pool import OnDone
from .task import run_task

_CONNECT_S = 20.0


def run_on_dask(jobs: Sequence[Job], address: str, retries: int, on_done: OnDone) -> None:
    """Run all jobs, one task each; each ends in exactly one call of `on_done`, in this process.

    A task whose worker dies is run again by the scheduler; the cluster's own memory limits hold.

    Args:
        jobs: what to do.
        address: of the scheduler, e.g. ``tcp://10.0.0.1:8786``.
        retries: how often a task that was lost with its workers is handed in again.
        on_done: called with every row and timing as they come in.

    Raises:
        ConfigError: Dask is not installed, or there is no scheduler at the address.
    """
    try:
        from distributed import Client, as_completed
    except ImportError as e:
        raise ConfigError("--scheduler needs Dask. Fix: pip install 'indoorfit[dask]'.") from e
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as e:
        raise ConfigError(f"--scheduler: no Dask scheduler at {address} ({e}). Fix: check it.") from e
    with client:
        # Keys are new in every run: a scheduler that remembers a failed task must not answer for this one.
        submit = {"retries": retries, "pure": False}
        futures: dict[Any, tuple[Job, int]] = {client.submit(_task, j, **submit): (j, 1) for j in jobs}
        done = as_completed(futures, loop=client.loop)
        for future in done:
            # `as_completed` has been seen to hand back a future that was not finished; its status alone
            # would then read as a failure.
            if not future.done():
                done.add(future)
                continue
            job, attempt = futures.pop(future)
            row, timing = _outcome(future, job)
            if row["state"] == "lost" and attempt <= retries:
                again = client.submit(_task, job, **submit)
                futures[again] = (job, attempt + 1)
                done.add(again)
            else:
                on_done(job, row, timing)
            future.release()


def _task(job: Job) -> tuple[Row, Timing]:
    return run_task(job)


def _outcome(future: Any, job: Job) -> tuple[Row, Timing]:
    from concurrent.futures import CancelledError

    try:
        return future.result()
    except CancelledError:
        reason = "was cancelled by the cluster. Fix: run the same command again."
    except Exception as error:
        # Anything that Dask reports: a killed worker, a lost connection, a worker without indoorfit.
        reason = f"was lost by the cluster ({type(error).__name__}: {str(error)[:200]}). Fix: see its log."
    timing = {"key": job.key, "wall_s": 0.0, "cpu_s": 0.0, "stages_s": {}}
    return failed_row(job, reason, lost=True), timing
