"""`fit --tape`, `tape-template`, `evaluate` and `calibrate` as a user meets them."""

import csv
import io
import json
import os
import shutil
import subprocess
import sys

import jsonschema
import pytest

from indoorfit.batch import read_lengths, reliability_of
from indoorfit.errors import InputError
from indoorfit.io import SCHEMA_PATH, read_model_json, read_tape
from indoorfit.io.model_json import to_document


@pytest.fixture(scope="module")
def fitted(room_ply, tmp_path_factory):
    out = tmp_path_factory.mktemp("fitted") / "room"
    subprocess.run(
        [sys.executable, "-m", "indoorfit", "fit", str(room_ply), "--out", str(out), "-q"],
        check=True, capture_output=True,
    )  # fmt: skip
    return out


def filled_in(template, model, off_m=0.001):
    """The table as it comes back from the site."""
    rows = list(csv.DictReader(io.StringIO(template)))
    values = {d["id"]: d["value"] for d in model["dimensions"]}
    for row in rows:
        row["value"] = f"{1000 * (values[row['dimension']] + off_m):.1f}"
        row["unit"] = "mm"
    text = io.StringIO()
    writer = csv.DictWriter(text, rows[0].keys())
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def test_a_template_comes_back_as_a_comparison(run_cli, room_ply, fitted, tmp_path):
    model = json.loads((fitted / "model.json").read_text(encoding="utf-8"))
    outcome = run_cli("tape-template", fitted / "model.json", "--plan", tmp_path / "plan.svg")
    assert outcome.code == 0
    plan = (tmp_path / "plan.svg").read_text(encoding="utf-8")
    table = tmp_path / "tape.csv"
    table.write_text(outcome.out, encoding="utf-8")
    empty = read_tape(table)
    assert not empty.readings
    assert all("no value" in row.reason for row in empty.refused)
    table.write_text(filled_in(outcome.out, model), encoding="utf-8")
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--tape", table, "--json")
    document = json.loads(outcome.out)
    jsonschema.validate(document, json.loads(SCHEMA_PATH.read_text(encoding="utf-8")))
    tape = document["tape"]
    ids = [check["dimension"] for check in tape["checks"]]
    assert tape["refused"] == []
    # A box has three lengths, and the plan shows where the two of them are that lie in it.
    assert len(ids) == 3
    assert all(f"{d['value']:.2f}" in plan for d in model["dimensions"] if d["kind"] == "overall")
    # Written to a tenth of a millimetre.
    assert [check["deviation"] for check in tape["checks"]] == pytest.approx(3 * [-0.001], abs=6e-5)
    rows = {
        row["id"]: row
        for row in csv.DictReader(
            io.StringIO((tmp_path / "out" / "dimensions.csv").read_text(encoding="utf-8"))
        )
    }
    assert all(rows[name]["tape_m"] for name in ids)
    assert "Against the tape" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    again = to_document(read_model_json(tmp_path / "out" / "model.json"))
    assert again == document, "nothing is lost on the way back"


def test_wrong_rows_are_named_and_the_others_used(run_cli, room_ply, tmp_path):
    table = tmp_path / "tape.csv"
    table.write_text("dimension,value,unit\nA,5.00,m\nA,five,m\nQQ,2,m\n")
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--tape", table)
    assert outcome.code == 0
    assert "line 3" in outcome.err
    assert "line 4" in outcome.err
    assert "E_n" in outcome.out
    assert "TAPE_ROWS_REFUSED" in outcome.out


def test_a_missing_table_is_told_before_the_fit(run_cli, room_ply, tmp_path):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--tape", tmp_path / "none.csv")
    assert outcome.code == 1
    assert "none.csv" in outcome.err
    assert not (tmp_path / "out").exists()


def test_a_plan_that_is_there_is_kept(run_cli, fitted, tmp_path):
    (tmp_path / "plan.svg").write_text("mine")
    outcome = run_cli("tape-template", fitted / "model.json", "--plan", tmp_path / "plan.svg")
    assert outcome.code == 1
    assert outcome.out == ""
    assert (tmp_path / "plan.svg").read_text() == "mine"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere names of files are text")
def test_a_name_that_is_no_utf_8_is_written_with_replacements(run_cli, room_ply, tmp_path):
    path = os.fsencode(tmp_path) + b"/k\xfcche.ply"
    shutil.copy(room_ply, path)
    outcome = run_cli("fit", os.fsdecode(path), "--out", tmp_path / "out", "--unit", "m")
    assert outcome.code == 0
    document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    assert document["provenance"]["input"]["name"] == "k�che.ply"


def test_the_unit_is_part_of_the_provenance(run_cli, room_ply, tmp_path):
    from indoorfit.io import read_scan, write_ply
    from indoorfit.model import Scan

    write_ply(tmp_path / "cm.ply", Scan(100.0 * read_scan(room_ply).points_m))
    outcome = run_cli("fit", tmp_path / "cm.ply", "--out", tmp_path / "out", "--unit", "cm", "--json")
    assert json.loads(outcome.out)["provenance"]["input"]["unit"] == "cm"


def test_a_batch_is_evaluated_and_calibrated(run_cli, tmp_path):
    manifest = tmp_path / "study.toml"
    manifest.write_text('[[simulate]]\nname = "r"\nplan = "box"\nrooms = 5\npoints = 4000\n')
    outcome = run_cli("evaluate", manifest, "--out", tmp_path / "batch", "--workers", "2")
    assert outcome.code == 0
    assert "[5/5]" in outcome.err
    outcome = run_cli("calibrate", tmp_path / "batch", "--out", tmp_path / "preset.toml")
    assert outcome.code == 0
    assert "5 rooms" in outcome.out
    assert "19 needed" in outcome.out
    from indoorfit import load_config

    assert load_config(tmp_path / "preset.toml").belief.inflation != 1.0
    outcome = run_cli("calibrate", tmp_path / "batch", "--out", tmp_path / "scales.toml", "--scales")
    assert outcome.code == 0
    assert "sensor's scale" in outcome.out
    # By kind, for there is one sensor only.
    assert "  height" in outcome.out
    assert load_config(tmp_path / "scales.toml").type_b.scale_std is not None
    assert run_cli("calibrate", tmp_path / "batch", "--sensor", "none").code == 1
    assert run_cli("calibrate", tmp_path / "batch", "--scales", "--conformal").code == 1
    refused = run_cli("calibrate", tmp_path / "batch", "--out", tmp_path / "c.toml", "--conformal")
    assert refused.code == 1
    assert not (tmp_path / "c.toml").exists()


def test_what_is_no_batch_is_told(run_cli, tmp_path):
    outcome = run_cli("calibrate", tmp_path)
    assert outcome.code == 1
    assert "no finished batch" in outcome.err


HEAD = (
    "config,sensor,room,kind,value_m,std_m,data_std_m,"
    "level,low_m,high_m,reference_m,reference_std_m,error_m,held"
)


@pytest.mark.parametrize(
    "lines",
    [
        (HEAD, "joint,s,r,wall,,0.01,0.01,0.95,1.9,2.1,2.0,0,0,yes"),
        (HEAD, 'joint,s,r,wall,2.0,0.01,0.01,0.95,1.9,2.1,2.0,0,0,"yes'),
        (HEAD, "joint,s,r,wall,2.0,0.01,0.01,,1.9,2.1,2.0,0,0,yes"),
        ("config,low_m", "joint,1.9"),
    ],
    ids=["no value", "an open quote", "no level", "columns"],
)
def test_a_damaged_batch_is_told_and_never_guessed(tmp_path, lines):
    (tmp_path / "batch.json").write_text('{"configs": {"joint": {}}}')
    (tmp_path / "lengths.csv").write_text("\n".join(lines) + "\n")
    for read in (read_lengths, reliability_of):
        with pytest.raises(InputError, match="no finished batch"):
            read(tmp_path)
