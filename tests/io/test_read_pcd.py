"""PCD: the three encodings, packed colours, padding, and the LZF codec."""

import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from indoorfit.errors import InputError
from indoorfit.io import read_scan
from indoorfit.io.lzf import lzf_decompress


def lzf_compress(data: bytes) -> bytes:
    """A plain LZF encoder: the longest of the last matches of three bytes, else literals."""
    out, literals, at = bytearray(), bytearray(), 0
    seen: dict[bytes, int] = {}

    def flush():
        for start in range(0, len(literals), 32):
            run = literals[start : start + 32]
            out.append(len(run) - 1)
            out.extend(run)
        literals.clear()

    while at < len(data):
        key = data[at : at + 3]
        match = seen.get(key) if len(key) == 3 else None
        seen[key] = at
        if match is None or at - match > 8192:
            literals.append(data[at])
            at += 1
            continue
        length = 3
        while length < 264 and at + length < len(data) and data[match + length] == data[at + length]:
            length += 1
        flush()
        distance, code = at - match - 1, length - 2
        out.append(min(code, 7) << 5 | distance >> 8)
        if code >= 7:
            out.append(code - 7)
        out.append(distance & 255)
        at += length
    flush()
    return bytes(out)


@settings(deadline=None)
@given(
    st.lists(st.binary(max_size=40), max_size=12).map(lambda parts: b"".join(p * (len(p) % 9) for p in parts))
)
def test_lzf_decompress_inverts_compression(data):
    assert lzf_decompress("scan", lzf_compress(data), len(data)) == data


@pytest.mark.parametrize(
    ("packed", "original"),
    [(b"\x02abc", b"abc"), (b"\x00a\xe0\x00\x00", b"a" * 10), (b"\x01ab\x40\x01", b"ababab")],
    ids=["literals", "long-overlap", "pattern"],
)
def test_lzf_decompress_follows_the_format_notes(packed, original):
    # Worked by hand from liblzf's description, so that encoder and decoder cannot share a mistake.
    assert lzf_decompress("scan", packed, len(original)) == original


@settings(deadline=None)
@given(st.binary(max_size=200), st.integers(0, 4000))
def test_lzf_decompress_meets_damage_with_an_input_error(data, n_out):
    try:
        assert len(lzf_decompress("scan", data, n_out)) == n_out
    except InputError:
        return


def header(fields: str, sizes: str, types: str, counts: str, n: int, data: str, shape: str = "") -> bytes:
    size = shape or f"WIDTH {n}\nHEIGHT 1"
    return (
        f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\n"
        f"TYPE {types}\nCOUNT {counts}\n{size}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA {data}\n"
    ).encode()


LAYOUT = ("x y z _ rgb _", "4 4 4 1 4 1", "F F F U F U", "1 1 1 4 1 12")


def packed_rgb(scan) -> np.ndarray:
    red, green, blue = scan.colours.T.astype(np.uint32)
    return (red << 16 | green << 8 | blue).astype(np.uint32)


def local_points(scan) -> np.ndarray:
    return (scan.points_m - scan.points_m.min(axis=0)).astype(np.float32)


def write_pcd(path, scan, data):
    """As PCL writes an XYZRGB cloud: 32 bytes per point with padding; compressed without padding."""
    points, rgb, n = local_points(scan), packed_rgb(scan), scan.n_points
    if data == "binary":
        rows = np.zeros(n, dtype=[("p", "<f4", 3), ("_", "u1", 4), ("rgb", "<u4"), ("__", "u1", 12)])
        rows["p"], rows["rgb"] = points, rgb
        path.write_bytes(header(*LAYOUT, n, data) + rows.tobytes())
    elif data == "binary_compressed":
        block = points.T.tobytes() + rgb.tobytes()
        packed = lzf_compress(block)
        path.write_bytes(header(*LAYOUT, n, data) + struct.pack("<II", len(packed), len(block)) + packed)
    else:
        shown = rgb.view(np.float32) if data == "ascii float" else rgb
        lines = "".join(f"{x!s} {y!s} {z!s} {c!s}\n" for (x, y, z), c in zip(points, shown, strict=True))
        kind = "U" if data == "ascii uint" else "F"
        path.write_bytes(
            header("x y z rgb", "4 4 4 4", f"F F F {kind}", "1 1 1 1", n, "ascii") + lines.encode()
        )


ENCODINGS = ["binary", "binary_compressed", "ascii float", "ascii uint", "ascii integers under F"]


@pytest.mark.parametrize("data", ENCODINGS)
def test_read_pcd_gives_the_same_cloud_in_every_encoding(tmp_path, scan, data):
    write_pcd(tmp_path / "scan.pcd", scan, data)
    found = read_scan(tmp_path / "scan.pcd")
    # str of a float32 reads back as the same float32, not as the same float64: half a float32 step.
    np.testing.assert_allclose(found.points_m, local_points(scan), rtol=2.0**-24, atol=0.0)
    np.testing.assert_array_equal(found.colours, scan.colours)


@pytest.mark.parametrize("data", ENCODINGS)
def test_read_pcd_refuses_a_truncated_file_with_both_counts(tmp_path, scan, data):
    path = tmp_path / "scan.pcd"
    write_pcd(path, scan, data)
    path.write_bytes(path.read_bytes()[:-300])
    with pytest.raises(InputError, match=r"promises \d+ .* holds \d+|row \d+ of 200"):
        read_scan(path)


def test_read_pcd_reads_separate_channels_doubles_and_frames(tmp_path, scan):
    rows = np.zeros(200, dtype=[("p", "<f8", 3), ("c", "u1", 3), ("frame", "<u2")])
    rows["p"], rows["c"], rows["frame"] = scan.points_m, scan.colours, scan.frame_ids
    head = header("x y z r g b frame", "8 8 8 1 1 1 2", "F F F U U U U", "1 1 1 1 1 1 1", 200, "binary")
    (tmp_path / "scan.pcd").write_bytes(head + rows.tobytes())
    found = read_scan(tmp_path / "scan.pcd")
    np.testing.assert_array_equal(found.points_m, scan.points_m)
    np.testing.assert_array_equal(found.colours, scan.colours)
    np.testing.assert_array_equal(found.frame_ids, scan.frame_ids)


PLAIN = ("x y z", "4 4 4", "F F F", "1 1 1")
HOSTILE = {
    "a trillion points": header(*PLAIN, 10**12, "binary") + bytes(12),
    "a trillion ascii points": header(*PLAIN, 10**12, "ascii") + b"1 2 3\n",
    "a trillion compressed points": header(*PLAIN, 10**12, "binary_compressed") + bytes(12),
    "a compressed bomb": header(*PLAIN, 3 * 10**8, "binary_compressed")
    + struct.pack("<II", 9, 36 * 10**8)
    + bytes(9),
    "negative points": header(*PLAIN, 9, "binary").replace(b"POINTS 9", b"POINTS -9"),
    "points against width": header(*PLAIN, 9, "binary", "WIDTH 4\nHEIGHT 3") + bytes(144),
    "unknown encoding": header(*PLAIN, 9, "base64"),
    "size of 3": header("x y z", "3 4 4", "F F F", "1 1 1", 9, "binary"),
    "count of 0": header("x y z", "4 4 4", "F F F", "0 1 1", 9, "binary"),
    "fields missing": header("x y", "4 4 4", "F F F", "1 1 1", 9, "binary"),
    "no data line": header(*PLAIN, 9, "binary").replace(b"DATA", b"data"),
    "no z": header("x y w", "4 4 4", "F F F", "1 1 1", 9, "binary") + bytes(108),
    "compressed sizes missing": header(*PLAIN, 9, "binary_compressed"),
    "no points": header(*PLAIN, 0, "binary"),
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE)
def test_read_pcd_refuses_hostile_files(tmp_path, content):
    (tmp_path / "scan.pcd").write_bytes(content)
    with pytest.raises(InputError, match=r"scan\.pcd"):
        read_scan(tmp_path / "scan.pcd")


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data(), encoding=st.sampled_from(ENCODINGS))
def test_read_pcd_meets_damage_with_an_input_error_or_a_cloud(tmp_path, scan, data, encoding):
    path = tmp_path / "scan.pcd"
    write_pcd(path, scan, encoding)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, 400))] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        found = read_scan(path)
    except InputError:
        return
    assert np.isfinite(found.points_m).all()
