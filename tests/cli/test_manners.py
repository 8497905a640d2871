"""What a person at a terminal and a machine at a pipe may expect."""

import io
import json
import os
import pty
import subprocess
import sys
import time
from dataclasses import replace
from typing import get_args

import pytest

from indoorfit.cli import health
from indoorfit.cli.main import Command
from indoorfit.cli.progress import ProgressLine
from indoorfit.errors import InputError

STEP_S = 120


def on_terminal(arguments, **environment) -> tuple[int, str]:
    """Run with standard error on a terminal; returns the exit code and what it showed."""
    ours, theirs = pty.openpty()
    env = {**os.environ, "TERM": "xterm", **environment}
    env = {name: value for name, value in env.items() if value is not None}
    command = [sys.executable, "-m", "indoorfit", *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=theirs, env=env) as running:
        os.close(theirs)
        shown = b""
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:  # Linux says so at the end of a terminal
                break
            shown += piece
            if not piece:
                break
        code = running.wait(STEP_S)
    os.close(ours)
    return code, shown.decode()


def piped(*arguments, **environment) -> subprocess.CompletedProcess:
    env = {**os.environ, **environment}
    command = [sys.executable, "-m", "indoorfit", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=env, timeout=STEP_S, check=False)


def test_a_terminal_sees_the_stages_with_times_and_a_clean_line_at_the_end(room_ply, tmp_path):
    code, shown = on_terminal(["fit", room_ply, "--out", tmp_path / "out"])
    assert code == 0
    for stage in ("read", "thin", "discover", "fit", "texture", "write"):
        assert f"] {stage} " in shown
    # The line is gone when the last message stands.
    assert shown.rstrip().endswith(f"written to {tmp_path / 'out'}")
    assert "\x1b[2K" in shown


def test_quiet_shows_no_progress(room_ply, tmp_path):
    code, shown = on_terminal(["fit", room_ply, "--out", tmp_path / "out", "--quiet"])
    assert (code, shown) == (0, "")


def test_a_file_gets_neither_progress_nor_colours(room_ply, tmp_path):
    done = piped("fit", room_ply, "--out", tmp_path / "out")
    assert done.returncode == 0
    assert "\x1b" not in done.stdout + done.stderr
    assert "\r" not in done.stderr


def test_between_stages_the_terminal_is_free_for_the_output():
    terminal = io.StringIO()
    line = ProgressLine(terminal)
    line.begin("thin")
    line.end()
    time.sleep(0.5)  # two rounds of the ticker
    terminal.write("the table\n")
    time.sleep(0.5)
    assert terminal.getvalue().rpartition("\x1b[2K")[2] == "the table\n"
    line.clear()


def test_a_terminal_sees_how_far_a_batch_is(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(
        '[[simulate]]\nname = "room"\nplan = "box"\nrooms = 1\npoints = 6000\n', encoding="utf-8"
    )
    arguments = ["evaluate", study, "--out", tmp_path / "batch", "--workers", "1"]
    code, shown = on_terminal(arguments)
    assert code == 0
    assert "[....................] 0 of 1 fits (" in shown
    assert shown.rstrip().endswith(f"written to {tmp_path / 'batch'}")
    # Nothing is left to do, and nothing is shown of it.
    assert on_terminal([*arguments, "--quiet"]) == (0, "")


def test_a_batch_fills_the_bar_by_its_share():
    terminal = io.StringIO()
    line = ProgressLine(terminal)
    for done in range(5):
        line.count(done, 4)
    assert "[##########..........] 2 of 4 fits (" in terminal.getvalue()
    assert terminal.getvalue().endswith("\x1b[2K")
    line.clear()


@pytest.mark.parametrize(
    ("environment", "colours"),
    [({"NO_COLOR": None}, True), ({"NO_COLOR": "1"}, False), ({"NO_COLOR": None, "TERM": "dumb"}, False)],
    ids=["terminal", "no-color", "dumb"],
)
def test_errors_are_coloured_where_that_is_wanted(environment, colours):
    code, shown = on_terminal(["info", "nowhere.ply"], **environment)
    assert code == 1
    assert ("\x1b[31m" in shown) == colours


@pytest.mark.parametrize("arguments", [("--help",), ("completion", "bash"), ("doctor", "--json")], ids=str)
def test_a_reader_that_leaves_early_ends_the_program_as_sigpipe_would(arguments):
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "indoorfit", *arguments]
    done = subprocess.run(
        command, stdout=write, stderr=subprocess.PIPE, text=True, timeout=STEP_S, check=False
    )
    os.close(write)
    assert done.returncode == 141
    assert done.stderr == ""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
def test_output_that_does_not_fit_is_one_line_and_no_traceback():
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "indoorfit", "--version"]
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=STEP_S, check=False
        )
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert "No space left" in done.stderr


@pytest.mark.parametrize("closed", [">&-", "2>&-"])
def test_a_closed_stream_is_one_that_nobody_reads(closed):
    line = f'"$0" -m indoorfit info nowhere.ply {closed}; "$0" -m indoorfit --version {closed}'
    done = subprocess.run(
        ["sh", "-c", line, sys.executable], capture_output=True, text=True, timeout=STEP_S, check=False
    )
    assert done.returncode == 0
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_names_the_commands(run_cli, shell):
    outcome = run_cli("completion", shell)
    assert outcome.code == 0
    for command in ("fit", "figures", "doctor", "completion"):
        assert command in outcome.out


def test_help_does_not_say_that_flags_are_off_by_default(run_cli):
    for command in get_args(Command):
        name = get_args(command)[1].name
        outcome = run_cli(name, "--help")
        assert outcome.code == 0
        assert "False" not in outcome.out, name


def test_bash_accepts_its_completion_script():
    script = piped("completion", "bash").stdout
    done = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_doctor_lists_what_is_needed_and_tests_itself(run_cli):
    outcome = run_cli("doctor", "--json")
    document = json.loads(outcome.out)
    assert outcome.code == 0
    assert document["ok"]
    assert document["self_test"]["ok"]
    needed = {library["name"]: library for library in document["libraries"] if not library["extra"]}
    assert {"indoorfit", "numpy", "jax", "manifold3d", "scipy"} <= set(needed)
    assert all(library["version"] and not library["problem"] for library in needed.values())
    (cache,) = document["caches"]
    assert cache["place"] == os.environ["JAX_COMPILATION_CACHE_DIR"]
    # The fit of the test above this line compiled something.
    assert cache["files"] > 0
    assert cache["bytes"] > 0
    text = run_cli("doctor").out
    assert "self-test: ok" in text
    assert cache["place"] in text


def test_doctor_fails_where_the_fit_is_wrong(run_cli, monkeypatch):
    monkeypatch.setattr(health, "_fit_known_room", lambda: ("9 lengths, the worst 30 mm off", False))
    outcome = run_cli("doctor")
    assert outcome.code == 1
    assert "self-test: FAILED: 9 lengths, the worst 30 mm off" in outcome.out


def test_doctor_survives_a_fit_that_raises(run_cli, monkeypatch):
    def breaks():
        raise ImportError("libjax is gone")

    monkeypatch.setattr(health, "_fit_known_room", breaks)
    outcome = run_cli("doctor", "--json")
    assert outcome.code == 1
    assert "libjax is gone" in json.loads(outcome.out)["self_test"]["message"]


def test_doctor_tells_missing_and_old_libraries(monkeypatch):
    extras = ['no-such-extra>=2; extra == "plan"', "pytest>=1; extra == 'dev'"]
    lines = ["numpy>=99.0", "no-such-library>=1", *extras]
    monkeypatch.setattr(health, "requires", lambda _: lines)
    found = {library.name: library for library in health.libraries()}
    assert "too old" in found["numpy"].problem
    assert "pip install" in found["no-such-library"].problem
    assert found["no-such-extra"].problem == ""
    assert found["no-such-extra"].extra == "plan"
    assert "pytest" not in found


def test_figures_command_writes_what_it_prints(run_cli, room_ply, tmp_path):
    pytest.importorskip("matplotlib")
    outcome = run_cli("figures", room_ply, "--out", tmp_path / "figures", "--format", "svg", "--json", "-q")
    assert outcome.code == 0
    files = [file for entry in json.loads(outcome.out).values() for file in entry["files"]]
    assert "residuals.svg" in files
    assert all((tmp_path / "figures" / file).is_file() for file in files)
    assert run_cli("figures", room_ply, "--out", tmp_path / "figures").code == 1
    outcome = run_cli("figures", room_ply, "--out", tmp_path / "other", "--batch", tmp_path)
    assert outcome.code == 1
    assert "no finished batch" in outcome.err
    assert not (tmp_path / "other").exists()


def test_a_place_without_room_for_figures_is_told_before_the_fit(run_cli, room_ply, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr("indoorfit.pipeline.fit_scan", lambda *_: pytest.fail("fitted for nothing"))
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("mine")
    for out in (tmp_path / "no" / "folder", tmp_path / "mine", room_ply):
        outcome = run_cli("figures", room_ply, "--out", out, "--overwrite")
        assert outcome.code == 1
        assert str(out) in outcome.err


@pytest.mark.parametrize(
    ("command", "fits"), [("fit", "fit_scan"), ("compare", "fit_both"), ("figures", "fit_scan")]
)
def test_every_command_that_fits_asks_the_data_for_their_sensor(
    run_cli, room_ply, tmp_path, monkeypatch, command, fits
):
    sensors = []

    def fitted(scan, config, *_):
        sensors.append(config.type_b.sensor)
        raise InputError("enough")

    def told(scan, config):
        return scan, replace(config, type_b=replace(config.type_b, sensor="laser"))

    monkeypatch.setattr(f"indoorfit.pipeline.{fits}", fitted)
    monkeypatch.setattr("indoorfit.pipeline.sensor_from_data", told)
    for options in ((), ("--sensor", "kinect_v1"), ("--sensor", "unknown")):
        assert run_cli(command, room_ply, "--out", tmp_path / "out", *options).code == 1
    assert sensors == ["laser", "kinect_v1", "unknown"]
