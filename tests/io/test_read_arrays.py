"""NPY and NPZ files, and arrays given by the caller."""

import io
import re
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from indoorfit.errors import InputError
from indoorfit.io import read_scan, scan_from_arrays


def test_read_npy_reads_plain_coloured_and_structured_arrays(tmp_path, scan):
    coloured = np.hstack([scan.points_m, scan.colours])
    structured = np.zeros(
        200, dtype=[(n, "f8") for n in "xyz"] + [(n, "u1") for n in "rgb"] + [("tag", "U4")]
    )
    for axis, name in enumerate("xyz"):
        structured[name] = scan.points_m[:, axis]
    for channel, name in enumerate("rgb"):
        structured[name] = scan.colours[:, channel]
    for array in (scan.points_m, np.asfortranarray(scan.points_m), coloured, structured):
        np.save(tmp_path / "scan.npy", array)
        found = read_scan(tmp_path / "scan.npy")
        np.testing.assert_array_equal(found.points_m, scan.points_m)
        if array is coloured or array is structured:
            np.testing.assert_array_equal(found.colours, scan.colours)


@pytest.mark.parametrize("points_key", ["points", "xyz"])
@pytest.mark.parametrize("colours_key", ["colors", "colours", "rgb"])
def test_read_npz_reads_all_known_keys(tmp_path, scan, points_key, colours_key):
    arrays = {points_key: scan.points_m, colours_key: scan.colours / 255, "frame": scan.frame_ids}
    np.savez_compressed(tmp_path / "scan.npz", **arrays)
    found = read_scan(tmp_path / "scan.npz")
    np.testing.assert_array_equal(found.points_m, scan.points_m)
    np.testing.assert_array_equal(found.colours, scan.colours)
    np.testing.assert_array_equal(found.frame_ids, scan.frame_ids)


def test_read_npz_reads_the_only_array_whatever_its_name(tmp_path, scan):
    np.savez(tmp_path / "scan.npz", scan.points_m)
    np.testing.assert_array_equal(read_scan(tmp_path / "scan.npz").points_m, scan.points_m)


def npy_with_shape(shape: str) -> bytes:
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}"
    header = header.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode() + bytes(240)


def zipped(name: str, content: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(name, content)
    return buffer.getvalue()


def pickled() -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.array([[object(), 1, 2]], dtype=object), allow_pickle=True)
    return buffer.getvalue()


BAD_FILES = {
    "a trillion rows": ("npy", npy_with_shape("(1000000000000, 3)"), "not a readable"),
    "a trillion zipped rows": (
        "npz",
        zipped("points.npy", npy_with_shape("(1000000000000, 3)")),
        "24000000000000",
    ),
    "negative rows": ("npy", npy_with_shape("(-4, 3)"), "not a readable"),
    "four columns": ("npy", npy_with_shape("(7, 4)"), re.escape("(7, 4)")),
    "a bare number": ("npy", npy_with_shape("()"), re.escape("shape ()")),
    "pickled": ("npy", pickled(), "pickled objects"),
    "pickled in archive": ("npz", zipped("points.npy", pickled()), "pickled objects"),
    "no points key": ("npz", zipped("a.npy", b"") + b"", "not a readable"),
    "text in archive": ("npz", zipped("readme.txt", b"hello"), "'points' is needed"),
    "damaged archive": ("npz", b"PK\x03\x04" + bytes(60), "not a readable"),
}


@pytest.mark.parametrize(("kind", "content", "said"), BAD_FILES.values(), ids=BAD_FILES)
def test_read_arrays_refuses_hostile_files(tmp_path, kind, content, said):
    path = tmp_path / f"scan.{kind}"
    path.write_bytes(content)
    with pytest.raises(InputError, match=said):
        read_scan(path)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), kind=st.sampled_from(["npy", "npz"]))
def test_read_arrays_meets_damage_with_an_input_error_or_a_cloud(tmp_path, scan, data, kind):
    path = tmp_path / f"scan.{kind}"
    if kind == "npy":
        np.save(path, scan.points_m)
    else:
        np.savez_compressed(path, points=scan.points_m, colours=scan.colours)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, min(len(content) - 1, 250)))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        found = read_scan(path)
    except InputError:
        return
    assert np.isfinite(found.points_m).all()


@pytest.mark.parametrize("kind", ["f8", "f4", "i4", ">f8", "list"])
def test_scan_from_arrays_takes_any_real_numbers_and_copies_them(kind):
    points = np.random.default_rng(3).integers(0, 6, size=(50, 3))
    given_points = points.tolist() if kind == "list" else points.astype(kind)
    found = scan_from_arrays(given_points, colours=np.full((50, 4), 0.5), frame_ids=range(50))
    np.testing.assert_array_equal(found.points_m, points)
    assert found.points_m.dtype == np.float64
    assert found.colours.shape == (50, 3)
    if kind == "f8":
        given_points[:] = -1
        np.testing.assert_array_equal(found.points_m, points)


POINTS = np.random.default_rng(4).uniform(0, 5, size=(30, 3))
BAD_ARRAYS = {
    "flat": ({"points": np.zeros(30)}, "shape"),
    "four columns": ({"points": np.zeros((30, 4))}, "shape"),
    "ragged": ({"points": [[1.0, 2.0, 3.0], [1.0]]}, "different length"),
    "complex": ({"points": POINTS + 1j}, "complex"),
    "words": ({"points": [["a", "b", "c"]] * 30}, "real numbers"),
    "empty": ({"points": np.zeros((0, 3))}, "0 points"),
    "three points": ({"points": POINTS[:3]}, "3 points"),
    "all nan": ({"points": POINTS * np.nan}, "none of the 30 points has finite"),
    "far away": ({"points": POINTS + 1e9}, "beyond 1e"),
    "few colours": ({"points": POINTS, "colours": np.zeros((29, 3))}, "colours"),
    "negative colours": ({"points": POINTS, "colours": np.full((30, 3), -1)}, "-1"),
    "few frames": ({"points": POINTS, "frame_ids": np.zeros(29, int)}, "frame_ids"),
    "float frames": ({"points": POINTS, "frame_ids": np.zeros(30)}, "integers"),
}


@pytest.mark.parametrize(("arguments", "said"), BAD_ARRAYS.values(), ids=BAD_ARRAYS)
def test_scan_from_arrays_refuses_what_is_no_cloud(arguments, said):
    with pytest.raises(InputError, match=said):
        scan_from_arrays(**arguments)
