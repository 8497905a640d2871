"""What holds for scans of every format: dispatch, units, dropped points, sidecars, refusals."""

import hashlib
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import plyfile
import pytest

from indoorfit.errors import ConfigError, InputError, OutputError
from indoorfit.io import (
    frames_path,
    read_frames_json,
    read_scan,
    scan_from_arrays,
    write_frames_json,
    write_ply,
)
from indoorfit.io.units import metres_per_unit
from indoorfit.model import Scan, SensorFrame

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}


def codes(scan: Scan) -> set[str]:
    return {note.code for note in scan.notes}


def room_points(n: int = 5000) -> np.ndarray:
    return np.random.default_rng(5).uniform(0, (6.0, 4.0, 2.6), size=(n, 3))


@pytest.mark.parametrize("unit", METRES)
def test_read_scan_converts_each_unit_to_metres(tmp_path, unit):
    np.save(tmp_path / "scan.npy", room_points() / METRES[unit])
    found = read_scan(tmp_path / "scan.npy", unit=unit)
    # Dividing and multiplying rounds twice: two steps of float64.
    np.testing.assert_allclose(found.points_m, room_points(), rtol=2.0**-51, atol=0.0)
    assert "UNIT_IMPLAUSIBLE" not in codes(found)


@pytest.mark.parametrize("unit", ["mm", "cm", "in"])
@pytest.mark.parametrize("scale", [0.8, 1.0, 1.5])
def test_read_scan_says_which_unit_the_cloud_looks_like(unit, scale):
    points = room_points() * scale / METRES[unit]
    points[:50] *= 300  # one point in a hundred is far out and must not decide
    notes = [note for note in scan_from_arrays(points).notes if note.code == "UNIT_IMPLAUSIBLE"]
    assert f"--unit {unit}" in notes[0].message


def test_read_scan_says_when_a_metre_scan_was_read_as_millimetres():
    notes = [n for n in scan_from_arrays(room_points(), unit="mm").notes if n.code == "UNIT_IMPLAUSIBLE"]
    assert "--unit m." in notes[0].message


def test_unknown_units_are_config_errors():
    with pytest.raises(ConfigError, match="'mile'"):
        metres_per_unit("mile")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_read_scan_drops_and_counts_non_finite_points_with_their_attributes(tmp_path, scan, bad):
    points_m = scan.points_m.copy()
    points_m[[3, 77], [0, 2]] = bad
    write_ply(tmp_path / "scan.ply", replace(scan, points_m=points_m))
    found = read_scan(tmp_path / "scan.ply")
    kept = np.delete(np.arange(200), [3, 77])
    np.testing.assert_array_equal(found.points_m, scan.points_m[kept])
    np.testing.assert_array_equal(found.colours, scan.colours[kept])
    np.testing.assert_array_equal(found.frame_ids, scan.frame_ids[kept])
    assert any("Dropped 2 of 200" in note.message for note in found.notes)


def test_a_few_points_out_of_the_world_are_dropped_and_many_are_an_error():
    points = room_points(1000)
    points[:10] = 1e30
    found = scan_from_arrays(points)
    assert found.n_points == 990
    assert any("10 beyond 1e+08 m" in note.message for note in found.notes)
    points[:11] = 1e30
    with pytest.raises(InputError, match="11 of 1000 points"):
        scan_from_arrays(points)


def test_map_coordinates_survive_writing_and_reading_to_the_bit(tmp_path, scan):
    write_ply(tmp_path / "scan.ply", scan, comment="first line\nGröße")
    found = read_scan(tmp_path / "scan.ply")
    np.testing.assert_array_equal(found.points_m, scan.points_m)
    assert "COORDINATES_COARSE" not in codes(found)


def test_read_scan_says_when_32_bit_map_coordinates_have_lost_digits(tmp_path, scan):
    np.save(tmp_path / "scan.npy", scan.points_m.astype(np.float32))
    assert "COORDINATES_COARSE" in codes(read_scan(tmp_path / "scan.npy"))
    np.save(tmp_path / "scan.npy", room_points().astype(np.float32))
    assert "COORDINATES_COARSE" not in codes(read_scan(tmp_path / "scan.npy"))


def test_read_scan_digests_the_file_and_never_names_its_folder(tmp_path, scan):
    path = tmp_path / "scan.ply"
    write_ply(path, scan)
    found = read_scan(str(path))
    assert found.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert found.name == "scan.ply"


@pytest.mark.parametrize("suffix", [".PLY", ".scan", ""])
def test_read_scan_knows_a_format_by_its_first_bytes(tmp_path, scan, suffix):
    path = tmp_path / f"scan{suffix}"
    write_ply(path, scan)
    assert read_scan(path).n_points == 200


def test_read_scan_knows_numbers_in_a_file_of_unknown_name(tmp_path, scan):
    np.savetxt(tmp_path / "scan.dat", scan.points_m)
    assert read_scan(tmp_path / "scan.dat").n_points == 200


@pytest.mark.parametrize(
    "name", ["scan.e57", "scan.las", "scan.laz", "scan.ptx", "unnamed-las", "unnamed-e57"]
)
def test_read_scan_says_what_to_convert_unsupported_formats_to(tmp_path, name):
    content = {"unnamed-las": b"LASF" + bytes(300), "unnamed-e57": b"ASTM-E57" + bytes(300)}
    (tmp_path / name).write_bytes(content.get(name, b"whatever"))
    with pytest.raises(InputError, match="convert it to PLY"):
        read_scan(tmp_path / name)


def test_read_scan_refuses_paths_that_are_no_scan(tmp_path):
    (tmp_path / "empty.ply").touch()
    (tmp_path / "noise.bin").write_bytes(bytes(range(256)))
    os.mkfifo(tmp_path / "pipe.ply")
    refusals = {
        "absent.ply": "no such file", "": "a directory", "empty.ply": "empty", "noise.bin": "unknown format",
        "pipe.ply": "no regular file",
    }  # fmt: skip
    for name, said in refusals.items():
        with pytest.raises(InputError, match=said):
            read_scan(tmp_path / name)


def test_read_scan_tells_of_a_file_that_may_not_be_read(tmp_path, scan, monkeypatch):
    write_ply(tmp_path / "scan.ply", scan)

    def refuse(*args, **kwargs):
        raise PermissionError(13, "Permission denied")

    # Patched, for the superuser may read everything and tests may run as one.
    monkeypatch.setattr("builtins.open", refuse)
    with pytest.raises(InputError, match=r"scan\.ply: cannot be read: Permission denied"):
        read_scan(tmp_path / "scan.ply")


FRAMES = tuple(
    SensorFrame(i, np.array([0.1 * i, 1 / 3, 1.5]), None if i == 2 else np.eye(3)[[1, 2, 0]])
    for i in range(4)
)


def test_sensor_frames_survive_the_sidecar_and_follow_the_scan(tmp_path, scan):
    path = tmp_path / "scan.ply"
    write_ply(path, scan)
    write_frames_json(frames_path(path), FRAMES)
    assert frames_path(path).name == "scan.frames.json"
    found = read_scan(path)
    for frame, expected in zip(found.frames, FRAMES, strict=True):
        assert frame.id == expected.id
        np.testing.assert_array_equal(frame.position_m, expected.position_m)
        assert (frame.rotation is None) == (expected.rotation is None)
    assert "FRAMES_UNKNOWN" not in codes(found)
    # The positions are in the scan's unit, so both shrink alike.
    shrunk = read_scan(path, unit="cm")
    np.testing.assert_allclose(shrunk.frames[3].position_m, 0.01 * FRAMES[3].position_m, rtol=2.0**-52)


def test_read_scan_counts_points_of_frames_without_a_pose(tmp_path, scan):
    write_ply(tmp_path / "scan.ply", scan)
    write_frames_json(tmp_path / "scan.frames.json", FRAMES[:3])
    notes = [n.message for n in read_scan(tmp_path / "scan.ply").notes if n.code == "FRAMES_UNKNOWN"]
    assert "50 points" in notes[0]


GOOD_FRAME = {"id": 0, "position": [0, 0, 0], "rotation": None}
BAD_SIDECARS = {
    "no json": ("{", "is not JSON"),
    "a list": ("[]", "a list; an object"),
    "no frames": ("{}", "frames is missing"),
    "no position": (json.dumps({"frames": [{"id": 1}]}), r"frames\[0\]\.position is missing"),
    "two numbers": (json.dumps({"frames": [GOOD_FRAME | {"position": [1, 2]}]}), "a list of 2"),
    "a word": (
        json.dumps({"frames": [GOOD_FRAME | {"position": [1, 2, "x"]}]}),
        r"position\[2\] is a string",
    ),
    "nan": (json.dumps({"frames": [GOOD_FRAME | {"position": [1, 2, float("nan")]}]}), "not finite"),
    "id twice": (json.dumps({"frames": [GOOD_FRAME, GOOD_FRAME]}), "second time"),
    "mirror": (json.dumps({"frames": [GOOD_FRAME | {"rotation": np.diag([1, 1, -1]).tolist()}]}), "rotation"),
    "no rotation": (
        json.dumps({"frames": [GOOD_FRAME | {"rotation": np.ones((3, 3)).tolist()}]}),
        "rotation",
    ),
    "deep": ("[" * 100_000, "is not JSON"),
}


@pytest.mark.parametrize(("content", "said"), BAD_SIDECARS.values(), ids=BAD_SIDECARS)
def test_read_frames_json_names_what_is_wrong(tmp_path, content, said):
    (tmp_path / "scan.frames.json").write_text(content)
    with pytest.raises(InputError, match=said):
        read_frames_json(tmp_path / "scan.frames.json")


def test_write_ply_writes_the_same_bytes_twice_and_plyfile_reads_them(tmp_path, scan):
    write_ply(tmp_path / "a.ply", scan, comment="one\ntwo µ")
    write_ply(tmp_path / "b.ply", scan, comment="one\ntwo µ")
    assert (tmp_path / "a.ply").read_bytes() == (tmp_path / "b.ply").read_bytes()
    vertex = plyfile.PlyData.read(str(tmp_path / "a.ply"))["vertex"]
    np.testing.assert_array_equal(vertex["y"], scan.points_m[:, 1])
    np.testing.assert_array_equal(vertex["blue"], scan.colours[:, 2])
    np.testing.assert_array_equal(vertex["frame"], scan.frame_ids)


def test_write_ply_leaves_out_what_the_scan_has_not(tmp_path, scan):
    write_ply(tmp_path / "a.ply", Scan(scan.points_m))
    found = read_scan(tmp_path / "a.ply")
    assert found.colours is None
    assert found.frame_ids is None


def test_write_ply_refuses_frame_ids_beyond_32_bits_and_leaves_nothing(tmp_path, scan):
    with pytest.raises(OutputError, match="32 bits"):
        write_ply(tmp_path / "a.ply", replace(scan, frame_ids=scan.frame_ids + 2**40))
    assert list(tmp_path.iterdir()) == []


REAL_COUNTS = {
    "boiler_room_tls_2cm.ply": 341, "two_rooms_tls_sparse.ply": 52, "office_floor_tls_sparse.ply": 114,
    "office_corner_depth.ply": 185, "room_scan1.pcd": 113, "room_scan2.pcd": 113,
    "oblique_hall_tls_3cm.ply": 648,
}  # fmt: skip


@pytest.mark.parametrize(("name", "thousands"), REAL_COUNTS.items(), ids=REAL_COUNTS)
def test_read_scan_reads_the_real_scans(name, thousands):
    default = Path(__file__).parents[2].parent / "shared" / "data"
    path = Path(os.environ.get("INDOORFIT_REAL_SCANS", default)) / name
    if not path.is_file():
        pytest.skip("real scans absent; set INDOORFIT_REAL_SCANS to their folder")
    found = read_scan(path)
    # Published counts are in thousands.
    assert round(found.n_points / 1000) == thousands
    assert (found.colours is None) == name.endswith(".pcd")
    assert "UNIT_IMPLAUSIBLE" not in codes(found)
