"""`indoorfit fit --write-registered`: the corrected cloud, or a reason why there is none."""

import numpy as np
import pytest

from indoorfit.errors import OutputError
from indoorfit.io import read_scan, write_frames_json, write_ply
from indoorfit.io.frames import frames_path
from indoorfit.simulate import (
    RandomSceneSettings,
    ScanSettings,
    handheld_path,
    load_sensor,
    random_scene,
    regime,
    virtual_scan,
)


@pytest.fixture(scope="module")
def drift_ply(tmp_path_factory):
    """A small drifted scan with frame ids."""
    rng = np.random.default_rng(4)
    scene = random_scene(rng, RandomSceneSettings(n_walls=4, n_furniture=0, n_windows=0, n_doors=0))
    path = handheld_path(scene, 24, rng, "spin")
    settings = ScanSettings(pixel_step=16)
    virtual = virtual_scan(scene, load_sensor("kinect_v1"), path, regime("2cm"), rng, settings)
    target = tmp_path_factory.mktemp("drift") / "scan.ply"
    write_ply(target, virtual.scan)
    write_frames_json(frames_path(target), virtual.scan.frames)
    return target


def test_the_registered_cloud_has_the_same_columns_and_other_places(run_cli, drift_ply, tmp_path):
    target = tmp_path / "registered.ply"
    outcome = run_cli("fit", drift_ply, "--out", tmp_path / "out", "--write-registered", target)
    assert outcome.code == 0
    before, after = read_scan(drift_ply), read_scan(target)
    np.testing.assert_array_equal(after.colours, before.colours)
    np.testing.assert_array_equal(after.frame_ids, before.frame_ids)
    moved_m = np.linalg.norm(after.points_m - before.points_m, axis=1)
    # 2 cm and 0.4 degrees: between a millimetre and a decimetre for most points.
    assert 1e-3 < np.median(moved_m) < 0.1


def test_a_scan_without_frame_ids_is_refused_before_anything_is_written(run_cli, room_ply, tmp_path):
    target = tmp_path / "registered.ply"
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--write-registered", target)
    assert outcome.code == 1
    assert "no frame ids" in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_other_suffixes_existing_files_and_greedy_are_refused(run_cli, drift_ply, tmp_path):
    out = ("--out", tmp_path / "out")
    assert run_cli("fit", drift_ply, *out, "--write-registered", tmp_path / "a.xyz").code == 1
    (tmp_path / "b.ply").write_text("mine")
    assert run_cli("fit", drift_ply, *out, "--write-registered", tmp_path / "b.ply").code == 1
    assert (tmp_path / "b.ply").read_text() == "mine"
    target = tmp_path / "c.ply"
    assert run_cli("fit", drift_ply, *out, "--method", "greedy", "--write-registered", target).code == 1
    assert not target.exists()


@pytest.mark.parametrize(
    "place", ["no/folder/a.ply", "out/a.ply"], ids=["missing folder", "inside the result"]
)
def test_a_place_that_cannot_hold_it_is_told_before_the_fit(run_cli, drift_ply, tmp_path, monkeypatch, place):
    monkeypatch.setattr("indoorfit.pipeline.fit_scan", lambda *_: pytest.fail("fitted for nothing"))
    outcome = run_cli("fit", drift_ply, "--out", tmp_path / "out", "--write-registered", tmp_path / place)
    assert outcome.code == 1
    assert "a.ply" in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_a_model_that_cannot_be_written_leaves_no_cloud_either(run_cli, drift_ply, tmp_path, monkeypatch):
    def full(*_, **__):
        raise OutputError("room: cannot be written: No space left on device.")

    monkeypatch.setattr("indoorfit.pipeline.write_outputs", full)
    target = tmp_path / "registered.ply"
    assert run_cli("fit", drift_ply, "--out", tmp_path / "out", "--write-registered", target).code == 1
    assert list(tmp_path.iterdir()) == []
