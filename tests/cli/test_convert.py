"""One command from model.json to any format."""

import json

import pytest

from indoorfit.files import FormatName
from indoorfit.pipeline import FORMATS


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    from indoorfit.io import write_model_json
    from synthetic import truth_of, virtual

    path = tmp_path_factory.mktemp("model") / "model.json"
    write_model_json(path, truth_of(virtual("L", 1, n_points=1000, yaw_deg=20)))
    return path


def test_every_name_has_a_format_and_suffixes_are_all_different():
    assert list(FORMATS) == list(FormatName.__args__)
    assert len({item.suffix for item in FORMATS.values()}) == len(FORMATS)


def test_all_formats_at_once_by_suffix(run_cli, model, tmp_path):
    paths = [tmp_path / f"room{item.suffix}" for item in FORMATS.values()]
    outcome = run_cli("convert", model, *(word for path in paths for word in ("-o", path)))
    assert (outcome.code, outcome.err) == (0, "")
    # OBJ brings its materials along.
    assert {path.name for path in tmp_path.iterdir()} == {*(path.name for path in paths), "room.mtl"}
    assert "mtllib room.mtl" in (tmp_path / "room.obj").read_text()


def test_the_format_may_be_named(run_cli, model, tmp_path):
    assert run_cli("convert", model, "-o", tmp_path / "room.json", "--format", "cityjson").code == 0
    assert json.loads((tmp_path / "room.json").read_text())["type"] == "CityJSON"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "room.foo"], ".ifc"),
        (["-o", "room"], "--format"),
        (["-o", "room.glb", "--scale", "50"], "plans"),
        (["-o", "room.pdf", "--scale", "0"], "--scale"),
        (["-o", "nowhere/room.glb"], "nowhere"),
        (["-o", "room.glb", "-o", "room.glb"], "same name"),
        (["-o", "room.glb", "-o", "taken.ifc"], "--overwrite"),
        (["-o", "room.glb", "-o", "taken.obj"], "--overwrite"),
        ([], "-o room.ifc"),
    ],
    ids=["suffix", "none", "scale", "zero", "folder", "twice", "exists", "beside", "nothing"],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(
    run_cli, model, tmp_path, monkeypatch, arguments, said
):
    monkeypatch.chdir(tmp_path)
    for name in ("taken.ifc", "taken.mtl"):
        (tmp_path / name).write_text("mine")
    outcome = run_cli("convert", model, *arguments)
    assert outcome.code in (1, 2)
    assert said in outcome.err
    assert "Traceback" not in outcome.err
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {
        "taken.ifc": "mine",
        "taken.mtl": "mine",
    }


def test_existing_files_are_replaced_with_overwrite(run_cli, model, tmp_path):
    for name in ("room.obj", "room.mtl"):
        (tmp_path / name).write_text("old")
    assert run_cli("convert", model, "-o", tmp_path / "room.obj", "--overwrite").code == 0
    assert all((tmp_path / name).read_text() != "old" for name in ("room.obj", "room.mtl"))


def test_no_model_is_the_users_error(run_cli, tmp_path):
    (tmp_path / "model.json").write_text('{"schema": "other"}')
    for name in ("model.json", "absent.json"):
        outcome = run_cli("convert", tmp_path / name, "-o", tmp_path / "room.glb")
        assert outcome.code == 1
        assert name in outcome.err


def test_a_missing_library_is_told_before_anything_is_written(run_cli, model, tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "ezdxf", None)
    outcome = run_cli("convert", model, "-o", tmp_path / "room.glb", "-o", tmp_path / "plan.dxf")
    assert outcome.code == 1
    assert "pip install 'indoorfit[plan]'" in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_fit_writes_further_formats(run_cli, room_ply, tmp_path):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--format", "x3d", "cityjson", "-q")
    assert outcome.code == 0
    assert {"model.x3d", "model.city.json", "model.glb"} <= {p.name for p in (tmp_path / "out").iterdir()}
