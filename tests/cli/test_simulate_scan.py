"""`simulate` with the virtual scanner: what it writes, that it repeats, and what it refuses."""

import json

import jsonschema
import numpy as np
import pytest
from PIL import Image

from indoorfit import io
from indoorfit.errors import OutputError
from indoorfit.io import SCHEMA_PATH, read_frames_json, read_model_json, read_scan

QUICK = ["--frames", 6, "--pixel-step", 16]


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def test_random_scene_comes_with_a_valid_truth(run_cli, tmp_path):
    arguments = ["--walls", 10, "--floor-step", "--beam", "--bookcase", "--tilt", 3, "--yaw", 40]
    assert run_cli("simulate", "random", "-o", tmp_path / "s.ply", *QUICK, *arguments).code == 0
    assert files(tmp_path) == ["s.ply", "s.truth.json"]
    document = json.loads((tmp_path / "s.truth.json").read_text(encoding="utf-8"))
    jsonschema.validate(document, json.loads(SCHEMA_PATH.read_text(encoding="utf-8")))
    assert document["method"] == "truth"
    scan = read_scan(tmp_path / "s.ply")
    assert sorted(set(scan.frame_ids)) == list(range(6))
    assert scan.frames == ()
    # The up direction of the truth is the one that was asked for: a tilt of 3 degrees.
    up = np.array(document["frame"]["R_manhattan_scan"])[2]
    # Rounding only.
    assert np.degrees(np.arccos(up[2])) == pytest.approx(3.0, abs=1e-9)


def test_scene_that_was_written_is_scanned_to_the_same_bytes(run_cli, tmp_path):
    same = [*QUICK, "--seed", 7, "--registration", "2cm", "--sensor-poses", "--yaw", 10]
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
    for suffix in ("toml", "json"):
        scene = tmp_path / f"scene.{suffix}"
        arguments = ["--glass-wall", "--write-scene", scene, "--overwrite"]
        assert run_cli("simulate", "random", "-o", tmp_path / "a" / "s.ply", *same, *arguments).code == 0
        again = ["--scene", scene, "--overwrite"]
        assert run_cli("simulate", "scene", "-o", tmp_path / "b" / "s.ply", *same, *again).code == 0
        for name in ("s.ply", "s.truth.json", "s.frames.json"):
            assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    other = ["--scene", scene, *QUICK, "--seed", 8, "--registration", "2cm", "--yaw", 10]
    assert run_cli("simulate", "scene", "-o", tmp_path / "c" / "s.ply", *other).code == 0
    assert (tmp_path / "c" / "s.ply").read_bytes() != (tmp_path / "a" / "s.ply").read_bytes()


def test_preset_plan_is_scanned_with_a_sensor(run_cli, tmp_path):
    arguments = ["--sensor", "tls", "--stations", 2, "--pixel-step", 16, "--exact", "--furniture", 2]
    assert run_cli("simulate", "L", "-o", tmp_path / "s.ply", *arguments).code == 0
    truth = read_model_json(tmp_path / "s.truth.json")
    assert round(truth.dimensions[0].quantity.value, 9) == 5.08
    observed = [face for face in truth.faces if face.status == "observed"]
    # An exact sensor and no drift: rounding only.
    assert max(face.rms_m for face in observed) < 1e-9
    assert set(read_scan(tmp_path / "s.ply").frame_ids) == {0, 1}


def test_sensor_poses_are_read_with_the_scan_and_do_not_outlive_it(run_cli, tmp_path):
    path = tmp_path / "s.ply"
    assert run_cli("simulate", "box", "-o", path, "--sensor", "kinect_v1", *QUICK, "--sensor-poses").code == 0
    assert len(read_frames_json(tmp_path / "s.frames.json")) == len(read_scan(path).frames) == 6
    # Without --overwrite the old poses are in the way, with it they go: they are not those of the new scan.
    path.unlink()
    (tmp_path / "s.truth.json").unlink()
    assert run_cli("simulate", "box", "-o", path, "--points", 500).code == 1
    assert run_cli("simulate", "box", "-o", path, "--points", 500, "--overwrite").code == 0
    assert files(tmp_path) == ["s.ply", "s.truth.json"]


def test_frame_ids_can_be_left_out(run_cli, tmp_path):
    path = tmp_path / "s.ply"
    assert run_cli("simulate", "random", "-o", path, *QUICK, "--no-frame-ids").code == 0
    assert read_scan(path).frame_ids is None


def test_rgbd_frames_hold_the_points_of_the_scan(run_cli, tmp_path):
    arguments = ["--sensor", "tof_camera", "--rgbd", tmp_path / "rgbd", "--registration", "5mm", *QUICK]
    for _ in range(2):
        assert run_cli("simulate", "U", "-o", tmp_path / "s.ply", *arguments, "--overwrite").code == 0
    depth = [np.asarray(Image.open(path)) for path in sorted((tmp_path / "rgbd" / "depth").iterdir())]
    assert len(depth) == 6
    scan = read_scan(tmp_path / "s.ply")
    counts = np.bincount(scan.frame_ids)
    assert [int((image > 0).sum()) for image in depth] == counts.tolist()
    assert files(tmp_path) == ["rgbd", "s.ply", "s.truth.json"]


def test_oblique_wall_is_in_the_truth(run_cli, tmp_path):
    arguments = ["--walls", 4, "--oblique", "--scale-error", 0.004]
    assert run_cli("simulate", "random", "-o", tmp_path / "s.ply", *QUICK, *arguments).code == 0
    truth = read_model_json(tmp_path / "s.truth.json")
    notes = {note.code: note.message for note in truth.notes}
    # Four walls and the one across a corner.
    assert len([face for face in truth.faces if face.kind == "wall"]) == 5
    assert len(truth.shape.oblique) == 1
    assert "1.004" in notes["SCALE_ERROR"]


def test_sensor_and_scene_of_ones_own(run_cli, tmp_path):
    sensor = tmp_path / "mine.toml"
    sensor.write_text(
        'kind = "camera"\ncolumns = 64\nrows = 48\nwidth_rad = 1.4\nheight_rad = 1.1\n'
        "min_m = 0.2\nmax_m = 8.0\n"
    )
    scene = tmp_path / "room.toml"
    scene.write_text(
        "[[rooms]]\nx_lines_m = [0.0, 2.0, 5.0]\ny_lines_m = [0.0, 3.0, 4.0]\ncells = ['#.', '##']\n"
    )
    arguments = ["--scene", scene, "--sensor", sensor, "--pixel-step", 1, "--frames", 12]
    assert run_cli("simulate", "scene", "-o", tmp_path / "s.ply", *arguments).code == 0
    truth = read_model_json(tmp_path / "s.truth.json")
    assert sum(face.kind == "wall" for face in truth.faces) == 6
    assert [round(d.quantity.value, 9) for d in truth.dimensions[:3]] == [5.0, 4.0, 2.7]


REFUSED = {
    "sampling-of-a-scan": (["random", "--points", 1000], "--points"),
    "frames-without-a-sensor": (["box", "--frames", 5], "--frames"),
    "walls-of-a-preset": (["box", "--sensor", "tls", "--walls", 6], "--walls"),
    "length-of-a-random-room": (["random", "--length", 4], "--length"),
    "odd-walls": (["random", "--walls", 7], "even"),
    "walls-and-rooms": (["random", "--walls", 8, "--rooms", 2], "--rooms"),
    "no-room": (["random", "--rooms", 0], "rooms"),
    "flat-room": (["random", "--height", 1], "high"),
    "no-frames": (["random", "--frames", 0], "frames"),
    "stations-of-a-camera": (["random", "--stations", 2], "--frames"),
    "frames-of-a-scanner": (["random", "--sensor", "tls", "--frames", 2], "--stations"),
    "unknown-sensor": (["random", "--sensor", "eye"], "kinect_v1"),
    "no-scene-given": (["scene"], "--scene"),
    "missing-scene": (["scene", "--scene", "nothing.toml"], "nothing.toml"),
    "scene-suffix": (["random", "--write-scene", "scene.yaml"], ".toml"),
    "one-name-twice": (["random", "--write-scene", "s.truth.json"], "same name"),
    "no-directory-for-images": (["random", "--rgbd", "no/where"], "no"),
    "shares": (["random", "--jump-share", 1.5], "share"),
    "pixel-step": (["random", "--pixel-step", 0], "step"),
    "seed": (["random", "--seed=-1"], "seed"),
}


@pytest.mark.parametrize(("arguments", "said"), REFUSED.values(), ids=REFUSED.keys())
def test_contradictions_are_refused_and_leave_nothing(run_cli, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    short = [] if {"--frames", "--stations"} & set(arguments) or arguments[0] != "random" else ["--frames", 2]
    outcome = run_cli("simulate", *arguments, *short, "-o", "s.ply")
    assert outcome.code == 1, outcome.err
    assert "Fix:" in outcome.err
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_failure_at_the_last_file_leaves_everything_as_it_was(run_cli, tmp_path, monkeypatch):
    arguments = ["simulate", "random", "-o", tmp_path / "s.ply", *QUICK, "--rgbd", tmp_path / "rgbd"]
    assert run_cli(*arguments).code == 0
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}

    def fails(path, *_, **__):
        raise OutputError(f"{path}: cannot be written: disk full. Fix: make room.")

    monkeypatch.setattr(io, "write_ply", fails)
    outcome = run_cli(*arguments, "--seed", 3, "--overwrite")
    assert outcome.code == 1
    assert f"{tmp_path / 's.ply'}: cannot" in outcome.err
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_directory_of_someone_else_is_never_replaced(run_cli, tmp_path):
    (tmp_path / "rgbd").mkdir()
    (tmp_path / "rgbd" / "thesis.tex").write_text("mine")
    arguments = ["-o", tmp_path / "s.ply", *QUICK, "--rgbd", tmp_path / "rgbd", "--overwrite"]
    assert run_cli("simulate", "random", *arguments).code == 1
    assert files(tmp_path / "rgbd") == ["thesis.tex"]
    assert files(tmp_path) == ["rgbd"]
