"""``indoorfit evaluate``: many scans against tape or truth, in one table."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from .maybe import Flag, Maybe, Quiet
from .runtime import set_up_logging


@dataclass(frozen=True)
class EvaluateCommand:
    """Fit all scans of a manifest and compare them with tape readings or with their truth.

    Writes scans, lengths, summary, pairs and refused as CSV (and Parquet, with the extra `batch`) and
    report.html. The same command again goes on where the last one was cut off and runs what has changed. A
    scan that fails is a row with its reason. Exit code 3 where some scan has no result.
    """

    manifest: tyro.conf.Positional[Path]
    """TOML or CSV; see docs/batch.md, and the studies in configs/."""
    out: Path
    """Directory of the batch: new, or that of an earlier run to go on with."""
    workers: Maybe[int] = None
    """Local processes; default: one per core."""
    scheduler: Maybe[str] = None
    """Address of a running Dask scheduler, e.g. tcp://host:8786, for its workers (extra `dask`)."""
    memory_gb: Maybe[float] = None
    """Most memory of one local process; a scan that needs more is ended and said so. Default: no limit."""
    timeout_s: float = 1800.0
    """Longest time for one scan on a local process."""
    retries: int = 1
    """How often a scan is tried again whose process was killed."""
    models: Flag = False
    """Keep the whole model of every scan, as `indoorfit fit` writes it, in DIR/models."""
    quiet: Quiet = False
    """Only warnings and errors on standard error."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(self.quiet, verbose=False)
        import logging

        from indoorfit.batch import Limits, RunOptions, collect, read_manifest, run_batch, write_tables

        log = logging.getLogger("indoorfit")
        study = read_manifest(self.manifest, self.out.resolve() / "models" if self.models else None)
        limits = Limits(self.memory_gb, self.timeout_s, self.retries)
        rows = run_batch(study, self.out, RunOptions(self.workers, self.scheduler, limits))
        tables = collect(study, rows)
        for record in tables.refused:
            where = f" ({record['scan']})" if record["scan"] else ""
            log.warning("%s, line %d%s: %s", record["table"], record["line"], where, record["reason"])
        write_tables(tables, self.out, f"Batch {study.name}")
        failed = sum(scan["state"] != "done" for scan in tables.scans)
        log.info("%d fits, %d without a result; written to %s", len(tables.scans), failed, self.out)
        return 3 if failed else 0
