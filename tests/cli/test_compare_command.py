"""`indoorfit compare`: both ways of fitting side by side."""

import json

import pytest

from indoorfit.config import RunConfig
from indoorfit.io import write_ply
from indoorfit.pipeline import fit_scan
from synthetic import virtual


@pytest.fixture(scope="module")
def scan_ply(tmp_path_factory):
    path = tmp_path_factory.mktemp("compare") / "L.ply"
    write_ply(path, virtual("L", 1, n_points=25_000).scan)
    return path


def test_compare_says_what_two_runs_of_fit_would(run_cli, scan_ply, tmp_path):
    outcome = run_cli("compare", scan_ply, "--out", tmp_path / "both", "--json", "--level", 0.8, "--quiet")
    assert outcome.code == 0
    document = json.loads(outcome.out)
    assert document == json.loads((tmp_path / "both" / "compare.json").read_text(encoding="utf-8"))
    from indoorfit.io import read_scan

    for method in ("joint", "greedy"):
        alone = fit_scan(read_scan(scan_ply), RunConfig(method=method, level=0.8))
        known = {d.id: d.quantity for d in alone.dimensions}
        rows = [row[method] for row in document["dimensions"]]
        assert rows
        for row in rows:
            assert row["value"] == known[row["id"]].value
            assert (row["low"], row["high"]) == (
                known[row["id"]].interval.low,
                known[row["id"]].interval.high,
            )
            assert row["low"] <= row["value"] <= row["high"]
        assert document["methods"][method]["seconds"] > 0
        assert 0.004 < document["methods"][method]["rms"] < 0.006  # points of 5 mm
    for row in document["dimensions"]:
        assert row["difference"] == row["greedy"]["value"] - row["joint"]["value"]


def test_compare_prints_a_table_and_draws_a_picture(run_cli, scan_ply, tmp_path):
    outcome = run_cli("compare", scan_ply, "--out", tmp_path / "both", "--quiet")
    assert outcome.code == 0
    assert "greedy - joint mm" in outcome.out
    assert "time of the fit" in outcome.out
    names = sorted(path.name for path in (tmp_path / "both").iterdir())
    assert names == ["compare.json", "compare.png", "compare.svg", "compare.txt"]
    drawing = (tmp_path / "both" / "compare.svg").read_text(encoding="utf-8")
    assert "joint" in drawing
    assert "greedy" in drawing
    assert (tmp_path / "both" / "compare.png").read_bytes().startswith(b"\x89PNG")
    again = run_cli("compare", scan_ply, "--out", tmp_path / "both", "--quiet")
    assert again.code == 1
    assert "--overwrite" in again.err
    assert run_cli("compare", scan_ply, "--out", tmp_path / "both", "--quiet", "--overwrite").code == 0


def test_compare_leaves_nothing_behind_where_no_room_is(run_cli, xyz, tmp_path):
    path = xyz([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    outcome = run_cli("compare", path, "--out", tmp_path / "both")
    assert outcome.code == 1
    assert "Fix:" in outcome.err
    assert not (tmp_path / "both").exists()
    assert [entry.name for entry in tmp_path.iterdir()] == ["scans"]
