"""The calibration study: what it writes, that it goes on where it stopped, and that it can fail."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks import calibration
from benchmarks.calibration import main, run_room, summary, table
from benchmarks.paired import paired, paired_table
from benchmarks.suites import SUITES

from indoorfit.model import STANDARD_LEVELS, Scan

ROOM = ("drift5mm", False, 20_001)


def every_sixth_point(seed: int):
    """A room of that regime; drift is what is judged here, and it is the same at every sixth point."""
    made = SUITES["drift5mm"].make(seed)
    points_m = np.ascontiguousarray(made.scan.points_m[::6])
    return replace(made, scan=Scan(points_m, name=made.scan.name))


@pytest.fixture(scope="module")
def record():
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(calibration.REGIMES, "drift5mm", every_sixth_point)
        return run_room(ROOM)


def test_a_room_has_every_method_and_level(record):
    methods = {entry["method"] for entry in record["lengths"]}
    assert methods == {"joint", "greedy", "iid", "CR2", "bootstrap"}
    for entry in record["lengths"]:
        assert len(entry["ends"]) == len(STANDARD_LEVELS)
        lows, highs = zip(*entry["ends"], strict=True)
        assert list(lows) == sorted(lows, reverse=True)
        assert list(highs) == sorted(highs)
    json.dumps(record, allow_nan=False)


def test_points_taken_as_independent_are_the_narrowest_and_worst(record):
    rows = {row["method"]: row for row in summary([record])}
    assert all(rows["iid"]["width_mm"] < rows[name]["width_mm"] for name in ("joint", "CR2", "greedy"))
    # One room of 5 mm drift: i.i.d. intervals of tenths of a millimetre against errors of millimetres.
    assert rows["iid"]["coverage"][0.95]["share"] < rows["joint"]["coverage"][0.95]["share"]
    assert rows["iid"]["score_mm"] > rows["joint"]["score_mm"]
    assert "| drift5mm | no | iid |" in table(list(rows.values()))


def test_joint_and_greedy_are_compared_on_lengths_that_both_measured(record):
    (row,) = paired([record], seed=1)
    both = [{e["length"] for e in record["lengths"] if e["method"] == name} for name in ("joint", "greedy")]
    assert row["lengths"] == len(both[0] & both[1]) > 0
    # Of one room every draw is the same.
    assert row["ratio"] == [pytest.approx(row["rmse_mm"][0] / row["rmse_mm"][1], rel=0.01)] * 3
    swapped = {"joint": "greedy", "greedy": "joint"}
    turned = [{**e, "method": swapped.get(e["method"], e["method"])} for e in record["lengths"]]
    (other,) = paired([{**record, "lengths": turned}], seed=1)
    assert other["rmse_mm"] == row["rmse_mm"][::-1]
    assert "| drift5mm | no | 1 |" in paired_table([row])


def test_a_study_goes_on_where_it_stopped(record, tmp_path, monkeypatch):
    name, _, seed = ROOM
    (tmp_path / "rooms.jsonl").write_text(json.dumps(record) + "\n" + json.dumps(record)[:40])
    monkeypatch.setattr(calibration, "run_room", None)  # nothing is left to run
    arguments = [
        "--out",
        str(tmp_path),
        "--rooms",
        "1",
        "--seed",
        str(seed),
        "--regimes",
        name,
        "--ids",
        "no",
    ]
    assert main(arguments) == 0
    results = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert {row["method"] for row in results["rows"]} >= {"joint", "iid"}
    assert (tmp_path / "table.md").read_text(encoding="utf-8").startswith("| regime |")
    # The torn line is gone.
    assert len((tmp_path / "rooms.jsonl").read_text(encoding="utf-8").splitlines()) == 1


def test_rooms_in_the_folder_can_be_tabulated_without_running_any(record, tmp_path, monkeypatch):
    (tmp_path / "rooms.jsonl").write_text(json.dumps(record) + "\n")
    monkeypatch.setattr(calibration, "run_room", None)
    assert main(["--out", str(tmp_path), "--tables"]) == 0
    rows = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))["rows"]
    assert {(row["regime"], row["rooms"], row["judged"]) for row in rows} == {("drift5mm", 1, 1)}


def test_the_printed_table_is_that_of_the_study():
    root = Path(__file__).resolve().parents[1]
    study = json.loads((root / "benchmarks" / "calibration.json").read_text(encoding="utf-8"))
    printed = (root / "docs" / "intervals.md").read_text(encoding="utf-8")
    ours = [row for row in study["rows"] if row["method"] == "joint"]
    assert ours
    for row in ours:
        shares = " | ".join(f"{100 * row['coverage'][str(level)]['share']:.1f}" for level in STANDARD_LEVELS)
        head = f"| {row['regime']} | {'yes' if row['ids'] else 'no'} | {row['judged']} of {row['rooms']}"
        assert f"{head} | {row['lengths']} | {shares} |" in printed
