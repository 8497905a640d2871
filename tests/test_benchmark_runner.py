"""The benchmark judges rooms, keeps what it finds, and its gate lets nothing worse pass."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from benchmarks import baseline, figures, judge, suites
from benchmarks.outcome import Job

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Two rooms through the command, spawned workers and pictures included."""
    folder = tmp_path_factory.mktemp("benchmark")
    command = [
        sys.executable, "-m", "benchmarks", "sparse", "--rooms", "2", "--seed", "7", "--jobs", "1",
        "--out", str(folder / "out"), "--baseline", str(folder / "baseline.json"), "--accept",
    ]  # fmt: skip
    path = [ROOT, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path))}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_every_room_and_every_figure_is_written(finished):
    folder, printed = finished
    document = json.loads((folder / "out" / "results.json").read_text(encoding="utf-8"))
    assert [room["seed"] for room in document["rooms"]] == [7, 8]
    assert set(document["rows"]["joint"]["sparse"]) == set(figures.FIGURES)
    # 5000 points of 1 cm in a box and an L: any program that works at all finds both.
    assert document["rows"]["joint"]["sparse"]["right"] == 1.0
    for room in document["rooms"]:
        assert room["lengths"]
        assert room["peak_mb"] > 50.0
        assert 0.0 < room["isprs_10cm"]["completeness"] <= 1.0
    assert "sparse" in printed
    assert {path.name for path in (folder / "out").iterdir()} == {
        "results.json", "table.txt", "sparse-joint.png", "reliability.png"
    }  # fmt: skip


def test_gate_passes_what_was_accepted_and_names_what_is_worse(finished):
    folder, _ = finished
    path = folder / "baseline.json"
    accepted = json.loads(path.read_text(encoding="utf-8"))["rows"]["joint"]["sparse"]["figures"]
    settings = {"rooms": 2, "seed": 7}
    worse = baseline.worse

    def complaints(**changes):
        return worse(path, {"joint": {"sparse": {**accepted, **changes}}}, settings, 0.95)

    assert complaints() == []
    (one,) = complaints(rmse_mm=2.0 * accepted["rmse_mm"] + 1.0)
    assert "rmse_mm" in one
    assert complaints(rmse_mm=0.0) == []
    assert len(complaints(right=0.5)) == 1
    assert len(complaints(right=None)) == 1
    # Too wide is not as bad as too narrow, but both are away from the level.
    assert len(complaints(coverage=0.5)) == 1


def test_gate_refuses_rows_that_have_no_baseline(finished):
    folder, _ = finished
    row = {"joint": {"sparse": {"right": 1.0}}}
    for settings in ({"rooms": 3, "seed": 7}, {"rooms": 2, "seed": 8}):
        (one,) = baseline.worse(folder / "baseline.json", row, settings, 0.95)
        assert "no baseline" in one


def test_the_committed_baseline_knows_every_suite_and_figure():
    document = json.loads((ROOT / "benchmarks" / "baseline.json").read_text(encoding="utf-8"))
    assert set(document["rows"]["joint"]) == set(suites.SUITES)
    assert set(document["figures"]) == set(figures.FIGURES)


def test_a_refused_room_is_wrong_and_does_not_stop_the_benchmark(monkeypatch):
    from indoorfit import InputError

    def refuse(scan, config):
        raise InputError("no room here. Fix: scan one.")

    monkeypatch.setattr(judge, "fit_scan", refuse)
    outcome = judge.judge(Job("sparse", 7, "joint", False, (0.95,)))
    assert not outcome.right
    assert not outcome.crashed
    assert "no room here" in outcome.faults[0]
    row = figures.row_of([outcome])
    assert row["right"] == 0.0
    assert row["solid_iou"] == 0.0
    assert row["rmse_mm"] is None


@pytest.mark.parametrize("suite", ["thesis", "drift2cm"], ids=["sampled", "scanned"])
def test_a_suite_gives_the_same_scan_for_the_same_seed(suite):
    first, second, other = (suites.SUITES[suite].make(seed).scan for seed in (3, 3, 4))
    assert first.points_m.tobytes() == second.points_m.tobytes()
    assert first.points_m.shape != other.points_m.shape or (first.points_m != other.points_m).any()
