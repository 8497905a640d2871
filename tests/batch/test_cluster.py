"""A real cluster on this machine: a scheduler and two workers, one of which is killed in the middle."""

import os
import signal
import socket
import subprocess
import sys
import time

import pytest

pytest.importorskip("distributed", reason="needs the extra dask")

MANIFEST = '[[simulate]]\nname = "room"\nplan = "box"\nrooms = 4\npoints = 4000\n'


@pytest.fixture
def cluster(tmp_path):
    """Address of the scheduler and the second worker's process; apart from us, for tests have no network."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    env = {**os.environ, "DASK_TEMPORARY_DIRECTORY": str(tmp_path / "dask")}

    def start(*command):
        base = [sys.executable, "-m", "dask", *command, "--no-dashboard"]
        return subprocess.Popen(base, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    processes = [start("scheduler", "--host", "127.0.0.1", "--port", str(port))]
    processes += [start("worker", address, "--nthreads", "1", "--no-nanny") for _ in range(2)]
    yield address, processes[2]
    for process in reversed(processes):
        process.kill()
        process.wait()


def evaluate(manifest, out, *options):
    command = [sys.executable, "-m", "indoorfit", "evaluate", str(manifest), "--out", str(out), *options]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def test_a_cluster_that_loses_a_worker_gives_the_same_tables(cluster, tmp_path):
    address, worker = cluster
    manifest = tmp_path / "study.toml"
    manifest.write_text(MANIFEST, encoding="utf-8")
    running = evaluate(manifest, tmp_path / "far", "--scheduler", address)
    near = evaluate(manifest, tmp_path / "near", "--workers", "1")
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and not list((tmp_path / "far" / "rows").glob("*.json")):
        time.sleep(0.02)
    worker.send_signal(signal.SIGKILL)
    _, log = running.communicate(timeout=90)
    assert running.returncode == 0, log
    _, log = near.communicate(timeout=90)
    assert near.returncode == 0, log
    for name in ("scans.csv", "lengths.csv", "summary.csv", "lengths.parquet", "report.html"):
        assert (tmp_path / "far" / name).read_bytes() == (tmp_path / "near" / name).read_bytes(), name


def test_no_scheduler_is_an_error_of_one_line(tmp_path, run_cli, monkeypatch):
    import distributed

    def refuse(*_, **__):
        raise OSError("Timed out trying to connect")

    monkeypatch.setattr(distributed, "Client", refuse)
    (tmp_path / "study.toml").write_text(MANIFEST, encoding="utf-8")
    outcome = run_cli(
        "evaluate", tmp_path / "study.toml", "--out", tmp_path / "o", "--scheduler", "tcp://h:1"
    )
    assert outcome.code == 1
    assert "no Dask scheduler at tcp://h:1" in outcome.err
