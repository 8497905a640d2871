"""`indoorfit fit` on good input: streams, exit codes, options."""

import json
import re
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from PIL import Image

from indoorfit import pipeline
from indoorfit.io import SCHEMA_PATH, write_ply
from indoorfit.model import Scan
from indoorfit.pipeline import surveying
from synthetic import virtual


def test_a_fit_writes_its_directory_and_prints_the_table(run_cli, room_ply, tmp_path):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out")
    assert outcome.code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    shown = [float(number) for number in re.findall(r"\d+\.\d+", outcome.out)]
    for dimension in document["dimensions"]:
        # The table shows at least centimetres.
        assert min(abs(number - dimension["value"]) for number in shown) <= 0.005
    assert "floor area" in outcome.out
    assert "thin" in outcome.err, "progress goes to standard error"


def test_without_a_name_the_result_lies_in_the_current_directory(run_cli, room_ply, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_cli("fit", room_ply, "--quiet").code == 0
    assert (tmp_path / f"{room_ply.stem}-room" / "report.html").is_file()


def test_the_options_of_textures_reach_the_files(run_cli, room_ply, tmp_path):
    picture = tmp_path / "p.png"
    Image.new("RGB", (40, 30), (9, 200, 30)).save(picture)
    out = tmp_path / "out"
    outcome = run_cli(
        "fit", room_ply, "--out", out, "--atlas", "--image-format", "jpeg", "--power-of-two", "--fill-gaps",
        "--texture-pixel", "0.05", "--photo", f"wall-2={picture}:0,0,40,0,40,30,0,30",
        "--photo", f"floor-1={picture}:0,0,40,0,40,30,0,30",
    )  # fmt: skip
    assert outcome.code == 0, outcome.err
    assert [path.name for path in (out / "textures").iterdir()] == ["atlas-1.jpg"]
    textures = json.loads((out / "model.json").read_text(encoding="utf-8"))["textures"]
    sources = {face["face"]: face["source"] for face in textures["faces"]}
    assert {face for face, source in sources.items() if source == "photo"} == {"wall-2", "floor-1"}
    assert sources["wall-1"] == "points"
    assert all(face["seen"] + face["filled"] == pytest.approx(1.0) for face in textures["faces"])
    width = textures["images"][0]["width"]
    assert width & (width - 1) == 0
    assert "wall-1" in (out / "report.html").read_text(encoding="utf-8").split("<h2>Textures</h2>")[1]


def test_no_textures_where_none_are_wanted_or_possible(run_cli, room_ply, xyz, tmp_path):
    assert run_cli("fit", room_ply, "--out", tmp_path / "a", "--no-textures").code == 0
    bare = xyz(virtual("box", 1, n_points=10_000).scan.points_m)
    assert run_cli("fit", bare, "--out", tmp_path / "b").code == 0
    for name in ("a", "b"):
        assert not (tmp_path / name / "textures").exists()
        assert "textures" not in json.loads((tmp_path / name / "model.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "options",
    [
        ("--photo", "wall-1=missing.png:0,0,1,0,1,1,0,1"),
        ("--images", "missing"),
        ("--photos", "missing.toml"),
        ("--texture-pixel", "0"),
        ("--no-textures", "--atlas"),
    ],
    ids=lambda options: options[0],
)
def test_wrong_texture_options_are_told_before_the_fit(run_cli, room_ply, tmp_path, options):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", *options)
    assert outcome.code == 1
    assert "Fix:" in outcome.err
    assert "thin:" not in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_camera_images_of_the_simulator_are_put_on_the_faces(run_cli, tmp_path):
    scan, images = tmp_path / "walk.ply", tmp_path / "images"
    options = ("--sensor", "kinect_v1", "--frames", 30, "--pixel-step", 8, "--rgbd", images)
    assert run_cli("simulate", "box", "-o", scan, *options).code == 0
    outcome = run_cli("fit", scan, "--out", tmp_path / "out", "--images", images, "--texture-pixel", 0.05)
    assert outcome.code == 0, outcome.err
    document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    observed = {face["id"] for face in document["faces"] if face["status"] == "observed"}
    textured = document["textures"]["faces"]
    assert {face["face"] for face in textured} >= observed
    assert {face["source"] for face in textured} == {"images"}


def test_json_is_the_only_thing_on_standard_output(run_cli, room_ply, tmp_path):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--json")
    document = json.loads(outcome.out)
    jsonschema.validate(document, json.loads(SCHEMA_PATH.read_text(encoding="utf-8")))
    assert document == json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))


def test_quiet_says_nothing_and_verbose_times_every_stage(run_cli, room_ply, tmp_path):
    assert run_cli("fit", room_ply, "--out", tmp_path / "a", "--quiet").err == ""
    verbose = run_cli("fit", room_ply, "--out", tmp_path / "b", "--verbose").err
    for stage in ("thin", "orient", "segment", "discover", "fit", "solid", "intervals"):
        assert f"{stage} took" in verbose


@pytest.mark.parametrize("level", [0.5, 0.9, 0.999])
def test_level_is_that_of_every_interval(run_cli, room_ply, tmp_path, level):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--level", level, "--json")
    document = json.loads(outcome.out)
    assert document["level"] == level
    assert {d["interval"]["level"] for d in document["dimensions"]} == {level}


def test_options_win_over_the_settings_file(run_cli, room_ply, tmp_path):
    settings = tmp_path / "mine.toml"
    settings.write_text("level = 0.8\nseed = 7\n[joint]\nmax_rounds = 9\n")
    outcome = run_cli(
        "fit", room_ply, "--out", tmp_path / "out", "--config", settings, "--level", "0.9", "--json"
    )
    document = json.loads(outcome.out)
    assert document["level"] == 0.9
    assert document["provenance"]["seed"] == 7
    assert document["provenance"]["config"]["joint"]["max_rounds"] == 9


def test_overwrite_replaces_an_earlier_result(run_cli, room_ply, tmp_path):
    assert run_cli("fit", room_ply, "--out", tmp_path / "out", "--level", "0.8").code == 0
    assert run_cli("fit", room_ply, "--out", tmp_path / "out").code == 1
    assert run_cli("fit", room_ply, "--out", tmp_path / "out", "--overwrite").code == 0
    document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    assert document["level"] == 0.95
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_unit_and_up_are_taken_from_the_command_line(run_cli, tmp_path):
    scan = virtual("box", 2, n_points=20_000).scan
    path = tmp_path / "mm.ply"
    write_ply(path, Scan(1000.0 * scan.points_m[:, [1, 2, 0]], scan.colours))
    outcome = run_cli("fit", path, "--out", tmp_path / "out", "--unit", "mm", "--up", "y", "--json")
    assert outcome.code == 0
    values = sorted(d["value"] for d in json.loads(outcome.out)["dimensions"][:3])
    # 20 000 points of 5 mm on six faces: far below a millimetre.
    assert values == pytest.approx([2.7, 4.0, 5.0], abs=0.001)


def test_a_fit_that_did_not_converge_is_written_and_ends_with_3(run_cli, room_ply, tmp_path):
    settings = tmp_path / "mine.toml"
    # The one round goes to the coarse points; none is left to see whether all of them stand still.
    settings.write_text("[joint]\nmax_rounds = 1\ncoarse_points = 5000\n")
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--config", settings)
    assert outcome.code == 3
    assert (tmp_path / "out" / "model.json").is_file()
    assert "NOT_CONVERGED" in outcome.out + outcome.err
    document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    assert "NOT_CONVERGED" in [warning["code"] for warning in document["warnings"]]


def test_a_room_that_does_not_close_is_written_and_ends_with_3(run_cli, room_ply, tmp_path, monkeypatch):
    closed = surveying.subtract_cubes
    monkeypatch.setattr(surveying, "subtract_cubes", lambda *a: replace(closed(*a), is_closed=False))
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out")
    assert outcome.code == 3
    assert "NOT_CLOSED" in outcome.out + outcome.err
    assert (tmp_path / "out" / "model.json").is_file()


def test_greedy_is_a_method(run_cli, room_ply, tmp_path):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--method", "greedy", "--json")
    assert outcome.code in (0, 3)
    assert json.loads(outcome.out)["method"] == "greedy"


def test_a_program_fault_is_not_dressed_up_as_the_users(run_cli, room_ply, tmp_path, monkeypatch):
    def broken(*_, **__):
        raise RuntimeError("ours")

    monkeypatch.setattr(pipeline, "fit_scan", broken)
    with pytest.raises(RuntimeError, match="ours"):
        run_cli("fit", room_ply, "--out", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_names_with_spaces_and_accents_are_taken(run_cli, tmp_path):
    path = tmp_path / "Größe 1.ply"
    write_ply(path, virtual("box", 3, n_points=10_000).scan)
    outcome = run_cli("fit", path, "--out", tmp_path / "Maße außen")
    assert outcome.code == 0
    document = json.loads((tmp_path / "Maße außen" / "model.json").read_text(encoding="utf-8"))
    assert document["provenance"]["input"]["name"] == "Größe 1.ply"


def test_points_that_are_not_finite_are_dropped_and_counted(run_cli, tmp_path):
    points_m = virtual("box", 4, n_points=20_000).scan.points_m
    points_m[::100] = np.nan
    path = tmp_path / "holes.npy"
    np.save(path, points_m)
    outcome = run_cli("fit", path, "--out", tmp_path / "out")
    assert outcome.code == 0
    assert "Dropped 200 of 20000" in outcome.out + outcome.err


def test_unconverged_chains_write_nothing(run_cli, room_ply, tmp_path):
    settings = tmp_path / "short.toml"
    settings.write_text("[sampler]\nwalkers = 16\ncheck_steps = 20\nmax_steps = 20\n")
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--config", settings, "--sample", "--quiet")
    assert outcome.code == 1
    assert "have not converged" in outcome.err
    assert not (tmp_path / "out").exists()


def test_the_sensor_adds_its_scale_to_every_length(run_cli, room_ply, tmp_path):
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--sensor", "kinect_v1", "--json")
    document = json.loads(outcome.out)
    assert document["noise"]["type_b"]["scale_std"] == 0.004
    assert "Kinect" in document["noise"]["explanation"]
    for dimension in document["dimensions"]:
        budget = dimension["budget"]
        assert budget["scale_std"] == pytest.approx(0.004 * dimension["value"], rel=1e-9)
        assert budget["definition_std"] == pytest.approx(0.002, rel=1e-9)
        assert 1.9 < dimension["coverage_factor"] < 2.2


def test_report_pdf_without_its_library_is_refused_before_the_scan_is_read(run_cli, tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "reportlab", None)
    outcome = run_cli("fit", tmp_path / "absent.ply", "--out", tmp_path / "out", "--pdf")
    assert outcome.code == 1
    assert "pip install 'indoorfit[plan]'" in outcome.err
    assert list(tmp_path.iterdir()) == []
