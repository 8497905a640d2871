"""The same in real processes: exit codes, streams, and what an interrupt leaves."""

import os
import signal
import subprocess
import sys

import pytest

from indoorfit.io import write_ply
from synthetic import virtual


def process(*arguments, cwd=None, **options) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "indoorfit", *map(str, arguments)]
    return subprocess.run(
        command, capture_output=True, text=True, cwd=cwd, timeout=120, check=False, **options
    )


def test_good_input_ends_with_0_and_the_table_on_standard_output(room_ply, tmp_path):
    done = process("fit", room_ply, "--out", tmp_path / "out", "--quiet")
    assert done.returncode == 0
    assert done.stderr == "", "no warning of any library"
    assert "overall" in done.stdout


def test_bad_input_ends_with_1_and_one_line(tmp_path):
    done = process("fit", "nowhere.ply", "--out", "out", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stdout == ""
    assert len(done.stderr.strip().splitlines()) == 1
    assert "nowhere.ply" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_usage_ends_with_2(tmp_path):
    done = process("fit", cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_bad_input_is_refused_before_the_numerics_are_loaded(tmp_path):
    """An error that needs no fit comes without JAX, in a fraction of the start-up time."""
    code = """
import sys
sys.argv = ["indoorfit", "fit", "nowhere.ply", "--out", "out"]
from indoorfit.cli.main import main
try:
    main()
except SystemExit as end:
    print(end.code, "optimistix" in sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=60, check=False
    )
    assert done.stdout.split() == ["1", "False"]


def test_a_pipe_that_is_closed_early_is_no_crash(room_ply, tmp_path):
    """`indoorfit fit ... | head -1`"""
    out = tmp_path / "out"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "indoorfit", "fit", str(room_ply), "--out", str(out), "--json", "--quiet"],
        stdout=write, stderr=subprocess.PIPE, text=True, timeout=120, check=False,
    )  # fmt: skip
    os.close(write)
    assert "Traceback" not in done.stderr
    assert (out / "model.json").is_file()


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["interrupt", "terminate"]
)
@pytest.mark.parametrize("stage", ["thin", "fit"])
def test_a_signal_leaves_nothing_half_written(tmp_path, stage, number, code):
    """In the middle of the numerics, and just before or during the writing."""
    scans = tmp_path / "scans"
    scans.mkdir()
    write_ply(scans / "room.ply", virtual("X", 1, n_points=200_000).scan)
    out = tmp_path / "out"
    running = subprocess.Popen(
        [sys.executable, "-m", "indoorfit", "fit", str(scans / "room.ply"), "--out", str(out)],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert running.stderr is not None
    for line in running.stderr:
        if line.startswith(f"{stage}:"):
            break
    running.send_signal(number)
    _, err = running.communicate(timeout=120)
    assert running.returncode in (0, code)
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == (["out", "scans"] if running.returncode == 0 else ["scans"])
    assert "Traceback" not in err


def test_a_termination_in_the_middle_of_writing_takes_the_hidden_folder_along(tmp_path):
    """Not left to chance: the program waits with an open staging folder until the signal comes."""
    code = """
import sys, time
from indoorfit.cli import main
from indoorfit.cli.fit import FitCommand
from indoorfit.files import atomic_directory

def run(self):
    with atomic_directory("out") as place:
        (place / "model.json").write_text("{")
        print("ready", flush=True)
        time.sleep(60)

FitCommand.run = run
sys.argv = ["indoorfit", "fit", "room.ply"]
main.main()
"""
    running = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    )
    assert running.stdout is not None
    assert running.stdout.readline() == "ready\n"
    assert [path.suffix for path in tmp_path.iterdir()] == [".part"]
    running.send_signal(signal.SIGTERM)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 143
    assert err == "indoorfit: terminated; nothing is half written.\n"
    assert list(tmp_path.iterdir()) == []
