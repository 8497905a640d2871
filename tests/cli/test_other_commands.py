"""`simulate`, `info`, `demo` and `--help`."""

import json
from importlib.metadata import version
from typing import get_args

import numpy as np
import pytest

from indoorfit import io
from indoorfit.cli.main import Command
from indoorfit.errors import OutputError
from indoorfit.io import read_model_json, read_scan
from synthetic import KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_simulate_writes_a_scan_and_its_truth_that_fit_finds_again(run_cli, tmp_path, kind):
    path = tmp_path / "scan.ply"
    assert run_cli("simulate", kind, "-o", path, "--points", 30_000, "--yaw", 30, "--tilt", 4).code == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["scan.ply", "scan.truth.json"]
    truth = read_model_json(tmp_path / "scan.truth.json")
    assert truth.method == "truth"
    assert run_cli("fit", path, "--out", tmp_path / "out", "--quiet", "--no-textures").code == 0
    found = read_model_json(tmp_path / "out" / "model.json")
    a, b = (np.sort([d.quantity.value for d in model.dimensions]) for model in (found, truth))
    # 30 000 points of 5 mm; the stair's smallest face has 200 of them: 5 x 5 mm / sqrt(100).
    np.testing.assert_allclose(a, b, rtol=0, atol=0.0025)


def test_same_seed_same_bytes(run_cli, tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        run_cli("simulate", "L", "-o", tmp_path / name / "s.ply", "--points", 2000, "--seed", 5)
    assert (tmp_path / "a" / "s.ply").read_bytes() == (tmp_path / "b" / "s.ply").read_bytes()
    run_cli("simulate", "L", "-o", tmp_path / "a" / "s.ply", "--points", 2000, "--seed", 6, "--overwrite")
    assert (tmp_path / "a" / "s.ply").read_bytes() != (tmp_path / "b" / "s.ply").read_bytes()


def test_sizes_are_those_asked_for(run_cli, tmp_path):
    arguments = ["--length", 7, "--width", 5, "--height", 3, "--notch-length", 2, "--notch-width", 1]
    assert run_cli("simulate", "L", "-o", tmp_path / "s.ply", "--points", 1000, *arguments).code == 0
    truth = read_model_json(tmp_path / "s.truth.json")
    values = [round(d.quantity.value, 9) for d in truth.dimensions]
    assert values == [7.0, 5.0, 3.0, 7.0, 4.0, 2.0, 1.0, 5.0, 5.0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "scan.pcd"], ".ply"),
        (["-o", "scan.ply", "--points", "0"], "points"),
        (["-o", "scan.ply", "--noise=-1"], "sigma"),
        (["-o", "scan.ply", "--outliers", "1.5"], "outlier"),
        (["-o", "scan.ply", "--length", "0.1"], "room"),
        (["-o", "scan.ply", "--height=-2"], "room"),
        (["-o", "nowhere/below/scan.ply"], "nowhere"),
    ],
    ids=["format", "no-points", "noise", "outliers", "notch-larger-than-room", "height", "no-directory"],
)
def test_impossible_simulations_are_refused_and_leave_nothing(
    run_cli, tmp_path, monkeypatch, arguments, said
):
    monkeypatch.chdir(tmp_path)
    outcome = run_cli("simulate", "L", *arguments)
    assert outcome.code == 1
    assert "Fix:" in outcome.err
    assert said in outcome.err
    assert "Traceback" not in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_simulate_keeps_what_exists(run_cli, tmp_path):
    path = tmp_path / "scan.ply"
    path.write_text("mine")
    outcome = run_cli("simulate", "box", "-o", path, "--points", 1000)
    assert outcome.code == 1
    assert "--overwrite" in outcome.err
    assert path.read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["scan.ply"]


def test_simulate_that_cannot_write_the_scan_leaves_no_truth_either(run_cli, tmp_path, monkeypatch):
    def fails(*_, **__):
        raise OutputError("scan.ply: cannot be written: disk full. Fix: make room.")

    monkeypatch.setattr(io, "write_ply", fails)
    assert run_cli("simulate", "box", "-o", tmp_path / "scan.ply", "--points", 1000).code == 1
    assert list(tmp_path.iterdir()) == []


def test_info_says_what_the_file_holds(run_cli, room_ply):
    outcome = run_cli("info", room_ply)
    assert outcome.code == 0
    assert "8000 points" in outcome.out
    assert "with colours" in outcome.out
    facts = json.loads(run_cli("info", room_ply, "--json").out)
    scan = read_scan(room_ply)
    assert facts["points"] == 8000
    assert facts["sha256"] == scan.sha256
    np.testing.assert_array_equal(facts["low_m"], scan.points_m.min(axis=0))
    np.testing.assert_array_equal(facts["extent_m"], np.ptp(scan.points_m, axis=0))


def test_info_on_bad_input_is_the_same_error(run_cli, tmp_path):
    outcome = run_cli("info", tmp_path / "nowhere.ply")
    assert outcome.code == 1
    assert "nowhere.ply" in outcome.err


def test_demo_runs_the_whole_way_and_can_be_repeated(run_cli, tmp_path):
    for _ in range(2):
        outcome = run_cli("demo", "--out", tmp_path / "demo")
        assert outcome.code == 0
    found = read_model_json(tmp_path / "demo" / "model.json")
    # The thesis' room (table 6-1); requirement 0.08 cm at most.
    assert [d.quantity.value for d in found.dimensions[:3]] == pytest.approx([5.08, 3.20, 2.70], abs=0.0008)
    assert [path.name for path in tmp_path.iterdir()] == ["demo"]


def test_demo_does_not_replace_what_is_not_its_own(run_cli, tmp_path):
    (tmp_path / "demo").mkdir()
    (tmp_path / "demo" / "mine.txt").write_text("keep")
    assert run_cli("demo", "--out", tmp_path / "demo").code == 1
    assert (tmp_path / "demo" / "mine.txt").read_text() == "keep"


COMMANDS = [get_args(command)[1].name for command in get_args(Command)]


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)], ids=lambda c: "".join(c) or "all")
def test_help_is_printed_and_is_no_error(run_cli, command):
    outcome = run_cli(*command, "--help")
    assert outcome.code == 0
    assert outcome.err == ""
    assert "usage: indoorfit" in outcome.out
    assert "None" not in outcome.out, "what happens without an option is said in words"


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("fitt", "fit"), ("Fit", "fit"), ("simulte", "simulate"), ("tape_template", "tape-template")],
)
def test_a_misspelt_command_is_answered_with_the_one_that_is_meant(run_cli, typed, meant):
    outcome = run_cli(typed, "scan.ply")
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err == f"indoorfit: there is no command {typed!r}; did you mean {meant}?\n"


def test_a_word_like_no_command_gets_the_list(run_cli):
    outcome = run_cli("xyzzy")
    assert outcome.code == 2
    assert all(name in outcome.err + outcome.out for name in COMMANDS)


def test_the_version_is_that_of_the_package(run_cli):
    outcome = run_cli("--version")
    assert (outcome.code, outcome.out) == (0, f"indoorfit {version('indoorfit')}\n")
