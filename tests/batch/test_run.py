"""Whatever happens to a run, the tables are those of an undisturbed one."""

import json
import logging
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import pytest

from indoorfit.batch import Limits, RunOptions, collect, read_manifest, run_batch, write_tables
from indoorfit.batch.pool import run_in_processes
from indoorfit.errors import ConfigError, OutputError
from indoorfit.io import write_ply
from synthetic import virtual

TABLES = [
    f"{name}.{kind}" for name in ("scans", "lengths", "summary", "pairs") for kind in ("csv", "parquet")
]
MANIFEST = """
[config.joint]
[config.greedy]
method = "greedy"
[[simulate]]
name = "room"
plan = "box"
rooms = 2
points = 6000
[[scan]]
file = "flat.ply"
"""


@pytest.fixture(autouse=True, scope="module")
def _quiet_log():
    """Commands that ran before have left a handler whose stream is gone."""
    logging.getLogger("indoorfit").handlers.clear()


@pytest.fixture(scope="module")
def manifest(tmp_path_factory):
    folder = tmp_path_factory.mktemp("batch")
    # Half a room: one wall and nothing else is refused by the fit.
    scan = virtual("box", 0, n_points=6000).scan
    write_ply(folder / "flat.ply", replace(scan, points_m=scan.points_m * [1.0, 0.0, 1.0]))
    (folder / "study.toml").write_text(MANIFEST, encoding="utf-8")
    return folder / "study.toml"


def run(manifest, out, **options):
    study = read_manifest(manifest)
    rows = run_batch(study, out, RunOptions(**options))
    tables = collect(study, rows)
    write_tables(tables, out, "test")
    return tables


@pytest.fixture(scope="module")
def undisturbed(manifest, tmp_path_factory):
    out = tmp_path_factory.mktemp("undisturbed") / "out"
    return run(manifest, out, workers=1), out


def content(out):
    return {name: (out / name).read_bytes() for name in [*TABLES, "report.html"]}


def test_a_scan_that_fails_is_a_row_with_its_reason(undisturbed):
    tables, _ = undisturbed
    failed = [scan for scan in tables.scans if scan["state"] == "failed"]
    assert [(scan["scan"], scan["config"]) for scan in failed] == [("flat", "joint"), ("flat", "greedy")]
    assert all("Fix:" in scan["reason"] for scan in failed)
    assert len(tables.scans) == 6
    assert {length["scan"] for length in tables.lengths} == {"room-0", "room-1"}


def test_two_workers_and_a_kill_change_no_byte(manifest, undisturbed, tmp_path):
    out = tmp_path / "out"
    command = [
        sys.executable,
        "-m",
        "indoorfit",
        "evaluate",
        str(manifest),
        "--out",
        str(out),
        "--workers",
        "2",
    ]
    running = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and len(list((out / "rows").glob("*.json"))) < 2:
        time.sleep(0.02)
    running.send_signal(signal.SIGKILL)
    running.wait()
    there = len(list((out / "rows").glob("*.json")))
    assert 2 <= there
    run(manifest, out, workers=2)
    assert content(out) == content(undisturbed[1])


def test_what_is_there_is_kept_and_what_changed_is_run_again(manifest, undisturbed, tmp_path):
    out = tmp_path / "out"
    rows, _ = (undisturbed[1] / "rows", (out / "rows").mkdir(parents=True))
    (out / "batch.json").write_text("{}")
    for row in rows.iterdir():
        (out / "rows" / row.name).write_bytes(row.read_bytes())
    damaged = sorted((out / "rows").iterdir())[0]
    damaged.write_text('{"key": "half')
    changed = manifest.with_name("changed.toml")
    changed.write_text(MANIFEST.replace('method = "greedy"', 'method = "greedy"\nlevel = 0.9'))
    before = {path.name: path.stat().st_mtime_ns for path in (out / "rows").iterdir()}
    run(changed, out, workers=1)
    after = {path.name: path.stat().st_mtime_ns for path in (out / "rows").iterdir()}
    # Three greedy fits at a new level; of the joint ones at most the damaged row.
    assert len(after) == len(before) + 3
    rewritten = {name for name in before if after[name] != before[name]}
    assert rewritten <= {damaged.name}


def test_rows_hold_no_time(undisturbed):
    _, out = undisturbed
    for row in (out / "rows").iterdir():
        assert "_s" not in {key[-2:] for key in json.loads(row.read_text(encoding="utf-8"))}
    assert len(list((out / "timings").iterdir())) == 6


def collected(jobs, n_workers, limits):
    rows = {}
    run_in_processes(jobs, n_workers, limits, lambda job, row, _: rows.update({job.key: row}))
    return rows


def test_memory_and_time_have_limits_that_cost_one_row_each(manifest):
    jobs = read_manifest(manifest).jobs[2:4]
    memory = collected(jobs, 1, Limits(memory_gb=0.05))
    assert [row["state"] for row in memory.values()] == ["lost", "lost"]
    assert all("--memory-gb" in row["reason"] for row in memory.values())
    late = collected(jobs[:1], 1, Limits(timeout_s=0.01))
    assert all("--timeout-s" in row["reason"] for row in late.values())


def test_a_killed_worker_has_its_scan_fitted_by_another(manifest, undisturbed):
    jobs = read_manifest(manifest).jobs[:3]

    def kill_the_first():
        deadline = time.monotonic() + 20.0
        while time.monotonic() < deadline and not multiprocessing.active_children():
            time.sleep(0.01)
        pid = multiprocessing.active_children()[0].pid
        assert pid is not None
        os.kill(pid, signal.SIGKILL)

    killer = threading.Thread(target=kill_the_first)
    killer.start()
    rows = collected(jobs, 1, Limits())
    killer.join()
    for job in jobs:
        kept = json.loads((undisturbed[1] / "rows" / f"{job.key}.json").read_text(encoding="utf-8"))
        assert json.loads(json.dumps(rows[job.key])) == kept


def test_a_worker_that_is_idle_takes_the_scan_of_one_that_died(manifest):
    """The last two scans: one worker has ended its own and waits when the other is killed."""
    quick, slow = read_manifest(manifest).jobs[0], read_manifest(manifest).jobs[2]

    def kill_the_other():
        deadline = time.monotonic() + 20.0
        while time.monotonic() < deadline and not rows:
            time.sleep(0.005)
        for child in sorted(multiprocessing.active_children(), key=lambda child: child.pid or 0)[:1]:
            child.kill()

    rows: dict = {}
    killer = threading.Thread(target=kill_the_other)
    killer.start()
    # Started first, the slow scan has the smaller process id.
    run_in_processes([slow, quick], 2, Limits(), lambda job, row, _: rows.update({job.key: row}))
    killer.join()
    assert {rows[slow.key]["state"], rows[quick.key]["state"]} == {"done", "failed"}


def test_a_killed_worker_without_retries_is_a_row_that_the_next_run_mends(manifest, tmp_path, monkeypatch):
    from indoorfit.batch import run as run_module
    from indoorfit.batch.jobs import failed_row

    def lose(jobs, n_workers, limits, on_done):
        for job in jobs:
            on_done(job, failed_row(job, "was killed", lost=True), {"key": job.key, "wall_s": 0.0})

    out = tmp_path / "out"
    with monkeypatch.context() as patched:
        patched.setattr(run_module, "run_in_processes", lose)
        first = run(manifest, out, workers=1)
    assert {scan["state"] for scan in first.scans} == {"lost"}
    second = run(manifest, out, workers=2)
    assert {scan["state"] for scan in second.scans} == {"done", "failed"}


def test_a_directory_of_something_else_is_left_alone(manifest, tmp_path):
    (tmp_path / "mine.txt").write_text("keep")
    with pytest.raises(OutputError, match="no batch"):
        run(manifest, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    "options",
    [{"workers": 0}, {"limits": Limits(retries=-1)}, {"limits": Limits(timeout_s=0.0)},
     {"scheduler": "tcp://x:1", "workers": 2}],
    ids=["no workers", "retries", "timeout", "both"],
)  # fmt: skip
def test_options_out_of_range_are_refused(manifest, tmp_path, options):
    with pytest.raises(ConfigError):
        run(manifest, tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()
