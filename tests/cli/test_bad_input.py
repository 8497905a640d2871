"""Bad input: one clear message, the exit code of the contract, and nothing left behind."""

import re
from pathlib import Path

import numpy as np
import pytest

from indoorfit.io import write_ply
from indoorfit.pipeline import outputs
from synthetic import virtual


def tree(folder: Path) -> dict[str, bytes]:
    """Every file below a folder with its bytes, hidden ones too."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else b""
        for path in sorted(folder.rglob("*"))
    }


@pytest.fixture
def refused(run_cli, tmp_path):
    """Run `fit` on bad input and check all that the contract says of errors; returns the message."""

    def run(scan, *options, says: tuple[str, ...] = (), names: str | None = None) -> str:
        before = tree(tmp_path)
        outcome = run_cli("fit", scan, "--out", tmp_path / "out", "--quiet", *options)
        assert outcome.code == 1
        assert outcome.out == ""
        *notes, message = outcome.err.strip().splitlines()
        assert message.startswith("indoorfit: ")
        # Before it, at most what the reader noticed (COLOURS_MISSING: ...), which may explain the refusal.
        assert all(re.match(r"[A-Z_]+: ", note) for note in notes), f"one message, not {notes}"
        assert "Traceback" not in outcome.err
        assert "Fix:" in message, "says what to do"
        if names is not None:
            assert names in message, "names the file"
        for word in says:
            assert word in message
        assert tree(tmp_path) == before, "nothing is left behind"
        return message

    return run


def test_missing_file(refused, tmp_path):
    refused(tmp_path / "nowhere.ply", says=("no such file",), names="nowhere.ply")


def test_directory_in_place_of_a_file(refused, tmp_path):
    (tmp_path / "folder").mkdir()
    refused(tmp_path / "folder", says=("directory",), names="folder")


@pytest.mark.parametrize("name", ["scan.blend", "scan.e57", "scan.las"])
def test_unknown_format(refused, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(bytes(range(256)) * 4)
    refused(path, names=name)


@pytest.mark.parametrize("name", ["empty.ply", "empty.pcd", "empty.xyz", "empty.npy"])
def test_empty_file(refused, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"")
    refused(path, says=("empty",), names=name)


HEADER = (
    b"ply\nformat ascii 1.0\nelement vertex %d\n"
    b"property float x\nproperty float y\nproperty float z\nend_header\n"
)


def test_empty_cloud(refused, tmp_path):
    path = tmp_path / "none.ply"
    path.write_bytes(HEADER % 0)
    refused(path, says=("0 points",), names="none.ply")


def test_three_points(refused, tmp_path):
    path = tmp_path / "three.ply"
    path.write_bytes(HEADER % 3 + b"0 0 0\n1 0 0\n0 1 0\n")
    refused(path, says=("3 points",), names="three.ply")


def test_a_few_points_are_no_room(refused, xyz):
    refused(xyz(np.random.default_rng(0).uniform(0, 4, (50, 3))), says=("voxels",))


def test_all_points_on_one_plane(refused, xyz):
    rng = np.random.default_rng(1)
    flat = rng.uniform(0, 1, (20_000, 3)) * (5.0, 3.0, 0.0) + rng.normal(0, 0.003, (20_000, 3))
    refused(xyz(flat), says=("one plane",))


def test_all_points_on_an_oblique_plane(refused, xyz):
    rng = np.random.default_rng(2)
    u, v = rng.uniform(0, 4, (2, 20_000))
    refused(xyz(np.column_stack([u, v, 0.3 * u + 0.7 * v])), says=("one plane",))


def test_all_points_on_one_line(refused, xyz):
    refused(xyz(np.linspace(0, 10, 5_000)[:, None] * (1.0, 0.0, 0.0)))


def test_all_points_in_one_place(refused, xyz):
    refused(xyz(np.full((5_000, 3), 1.5)))


def test_a_cloud_without_floor(refused, tmp_path):
    path = tmp_path / "no-floor.ply"
    write_ply(path, virtual("L", 3, n_points=20_000, missing_planes=(0,)).scan)
    refused(path, says=("floor",))


def test_walls_alone(refused, tmp_path):
    path = tmp_path / "walls.ply"
    write_ply(path, virtual("box", 4, n_points=20_000, missing_planes=(0, 1)).scan)
    refused(path, says=("floor",))


def test_a_ball(refused, xyz):
    directions = np.random.default_rng(5).normal(size=(20_000, 3))
    refused(xyz(2 * directions / np.linalg.norm(directions, axis=1, keepdims=True)), says=("perpendicular",))


def test_noise(refused, xyz):
    refused(xyz(np.random.default_rng(6).uniform(0, 3, (20_000, 3))))


@pytest.mark.parametrize("value", [np.nan, np.inf], ids=["nan", "inf"])
def test_not_a_number_everywhere(refused, tmp_path, value):
    path = tmp_path / "nan.npy"
    np.save(path, np.full((1000, 3), value))
    refused(path, says=("finite",), names="nan.npy")


@pytest.mark.parametrize("share", [0.3, 0.97])
def test_truncated_binary_file(refused, room_ply, tmp_path, share):
    path = tmp_path / "cut.ply"
    content = room_ply.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    refused(path, names="cut.ply")


def test_truncated_header(refused, room_ply, tmp_path):
    path = tmp_path / "cut.ply"
    path.write_bytes(room_ply.read_bytes()[:60])
    refused(path, names="cut.ply")


@pytest.mark.parametrize("promised", [101, 10**6, 10**15])
def test_header_that_promises_more_than_the_file_holds(refused, tmp_path, promised):
    path = tmp_path / "promise.ply"
    rows = "".join(f"{k % 10} {k // 10} 0\n" for k in range(100))
    path.write_bytes(HEADER % promised + rows.encode())
    refused(path, says=("100",), names="promise.ply")


def test_binary_header_that_promises_more_than_fits_in_memory(refused, room_ply, tmp_path):
    path = tmp_path / "promise.ply"
    path.write_bytes(room_ply.read_bytes().replace(b"vertex 8000", b"vertex 2000000000000", 1))
    refused(path, names="promise.ply")


def test_coordinates_of_1e9_metres(refused, tmp_path):
    path = tmp_path / "far.npy"
    np.save(path, virtual("box", 7, n_points=10_000).scan.points_m + 1e9)
    message = refused(path, names="far.npy")
    assert "1e+09" in message


def test_millimetres_read_as_metres_are_guessed(run_cli, tmp_path):
    """A room of 5000 x 4000 x 2700 m is no error by itself, but a warning must name the likelier unit."""
    path = tmp_path / "mm.npy"
    np.save(path, virtual("box", 8, n_points=20_000).scan.points_m * 1000)
    outcome = run_cli("fit", path, "--out", tmp_path / "out")
    assert outcome.code in (0, 1, 3)
    assert "Traceback" not in outcome.err
    assert "--unit mm" in outcome.out + outcome.err


def test_missing_colours_are_a_note_and_no_error(run_cli, xyz, tmp_path):
    path = xyz(virtual("box", 9, n_points=20_000).scan.points_m)
    outcome = run_cli("fit", path, "--out", tmp_path / "out")
    assert outcome.code == 0
    assert "COLOURS_MISSING" in outcome.out + outcome.err
    assert (tmp_path / "out" / "model.glb").is_file()


def test_output_directory_that_exists(refused, room_ply, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("keep")
    refused(room_ply, says=("exists already", "--overwrite"), names="out")


def test_output_directory_of_someone_else_is_not_overwritten(refused, room_ply, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("keep")
    refused(room_ply, "--overwrite", says=("not empty",), names="out")


def test_output_that_is_a_file(refused, room_ply, tmp_path):
    (tmp_path / "out").write_text("keep")
    refused(room_ply, "--overwrite", says=("no directory",), names="out")


def test_output_that_cannot_be_written(run_cli, room_ply, tmp_path):
    (tmp_path / "file").write_text("keep")
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "file" / "below" / "out", "--quiet")
    assert outcome.code == 1
    assert "Fix:" in outcome.err
    assert "file" in outcome.err
    assert len(outcome.err.strip().splitlines()) == 1
    assert tree(tmp_path) == {"file": b"keep"}


def test_a_place_that_cannot_be_written_is_said_before_the_scan_is_read(run_cli, tmp_path):
    (tmp_path / "file").write_text("keep")
    outcome = run_cli("fit", tmp_path / "nowhere.ply", "--out", tmp_path / "file" / "out")
    assert outcome.code == 1
    assert "nowhere.ply" not in outcome.err


def test_a_disk_that_is_full_leaves_nothing(run_cli, room_ply, tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(outputs, "write_vrml", full)
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "deep" / "out", "--quiet")
    assert outcome.code == 1
    assert "No space left" in outcome.err
    assert tree(tmp_path) == {}


def test_an_interrupt_leaves_nothing(run_cli, room_ply, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(outputs, "write_vrml", interrupted)
    outcome = run_cli("fit", room_ply, "--out", tmp_path / "out", "--quiet")
    assert outcome.code == 130
    assert tree(tmp_path) == {}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("colour = 1\n", "colour"),
        ("[joint]\nmax_round = 3\n", "max_round"),
        ("[joint]\nmax_rounds = 'three'\n", "max_rounds"),
        ("[joint]\nmax_rounds = 2.5\n", "max_rounds"),
        ("[thin]\nvoxel_m = true\n", "voxel_m"),
        ("level = 'high'\n", "level"),
        ("level = 95\n", "level"),
        ("level = nan\n", "level"),
        ("method = 'magic'\n", "method"),
        ("seed = -1\n", "seed"),
        ("joint = 3\n", "joint"),
        ("[orient]\nup = 'w'\n", "up"),
        ("not toml at all", "TOML"),
    ],
    ids=[
        "unknown-key", "unknown-nested-key", "text-for-a-number", "fraction-for-a-count",
        "truth-for-a-number", "text-for-a-level", "percent", "nan", "unknown-method",
        "negative-seed", "number-for-a-table", "unknown-axis", "not-toml",
    ],
)  # fmt: skip
def test_bad_settings(refused, room_ply, tmp_path, text, said):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    message = refused(room_ply, "--config", path, says=(said,))
    assert "level" in said or "seed" in said or "mine.toml" in message


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[thin]\nvoxel_m = -1.0\n", "voxel_m"),
        ("[thin]\ntarget_voxels = 0\n", "target_voxels"),
        ("[joint]\nmax_rounds = 0\n", "max_rounds"),
        ("[joint]\ncoarse_points = 0\n", "coarse_points"),
        ("[surfels]\nneighbours = 0\n", "neighbours"),
        ("[joint.association]\npatch_m = 0.0\n", "patch_m"),
        ("[discover.labels]\nceiling_inside = 1.5\n", "ceiling_inside"),
    ],
    ids=["voxel", "target", "rounds", "coarse", "neighbours", "patch", "probability"],
)
def test_impossible_values_of_settings_are_refused_by_name(refused, room_ply, tmp_path, text, said):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    refused(room_ply, "--config", path, says=(said,))


def test_missing_settings_file(refused, room_ply, tmp_path):
    refused(room_ply, "--config", tmp_path / "none.toml", names="none.toml")


@pytest.mark.parametrize("level", ["95", "1.0", "0.2", "-1"])
def test_bad_level(refused, room_ply, level):
    refused(room_ply, f"--level={level}", says=("level",))


USAGE = [
    [],
    ["fit"],
    ["dance"],
    ["fit", "--out", "out"],
    ["fit", "scan.ply", "--out", "out", "--method", "magic"],
    ["fit", "scan.ply", "--out", "out", "--level", "high"],
    ["fit", "scan.ply", "--out", "out", "--unit", "cubit"],
    ["fit", "scan.ply", "--out", "out", "--up", "w"],
    ["fit", "scan.ply", "--out", "out", "--seed", "1.5"],
    ["fit", "scan.ply", "--out", "out", "--colour"],
    ["simulate", "igloo", "-o", "scan.ply"],
    ["simulate", "box"],
    ["info"],
]


@pytest.mark.parametrize("arguments", USAGE, ids=lambda a: "-".join(a).replace(".", "") or "nothing")
def test_usage_errors_end_with_2(run_cli, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    outcome = run_cli(*arguments)
    assert outcome.code == 2
    assert outcome.out == "", "usage errors go to standard error"
    assert outcome.err.strip()
    assert "Traceback" not in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_directory_in_place_of_a_model(run_cli, tmp_path):
    done = run_cli("convert", str(tmp_path), "-o", str(tmp_path / "a.stl"))
    assert done.code == 1
    assert "is a directory" in done.err
    assert "model.json" in done.err


def test_unknown_key_in_the_settings(refused, room_ply, tmp_path):
    settings = tmp_path / "bad.toml"
    settings.write_text("nonsense_key = 3\n")
    refused(room_ply, "--config", str(settings), says=("unknown keys (nonsense_key)", "bad.toml"))
