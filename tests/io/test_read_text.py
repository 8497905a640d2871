"""Plain text: separators, headers and column orders."""

import numpy as np
import pytest

from indoorfit.errors import InputError
from indoorfit.io import read_scan


def lines_of(scan, template: str, separator: str) -> list[str]:
    """One line per point; the template names x y z r g b (bytes), R G B (unit scale), i and n."""
    rows = []
    for (x, y, z), (r, g, b) in zip(scan.points_m, scan.colours, strict=True):
        values = {"x": repr(float(x)), "y": repr(float(y)), "z": repr(float(z)), "i": "-0.25", "n": "0.5"}
        values |= {"r": str(r), "g": str(g), "b": str(b)}
        values |= {"R": repr(float(r) / 255), "G": repr(float(g) / 255), "B": repr(float(b) / 255)}
        rows.append(separator.join(values[key] for key in template))
    return rows


@pytest.mark.parametrize("separator", [" ", "   ", "\t", ",", ", ", ";"], ids=repr)
@pytest.mark.parametrize(
    "template", ["xyzrgb", "xyzRGB", "xyzirgb", "xyzrgbi", "xyznnnrgb", "xyzrgbnnn", "xyziRGB"]
)
def test_read_text_finds_colours_in_every_order(tmp_path, scan, template, separator):
    (tmp_path / "scan.xyz").write_text("\n".join(lines_of(scan, template, separator)))
    found = read_scan(tmp_path / "scan.xyz")
    np.testing.assert_array_equal(found.points_m, scan.points_m)
    np.testing.assert_array_equal(found.colours, scan.colours)


@pytest.mark.parametrize("template", ["xyz", "xyzi", "xyzin", "xyzini"])
def test_read_text_without_colours_says_so(tmp_path, scan, template):
    (tmp_path / "scan.txt").write_text("\n".join(lines_of(scan, template, " ")))
    found = read_scan(tmp_path / "scan.txt")
    np.testing.assert_array_equal(found.points_m, scan.points_m)
    assert found.colours is None
    assert "COLOURS_MISSING" in {note.code for note in found.notes}


HEADERS = {
    "csv": "b,g,r,i,z,y,x",
    "quoted": '"B","G","R","Intensity","Z","Y","X"',
    "long names and units": "blue,green,red,intensity,z [m],y [m],x [m]",
    "cloudcompare": "//B G R Intensity Z Y X",
    "hash": "# b, g, r, intensity, z, y, x",
}


@pytest.mark.parametrize("header", HEADERS.values(), ids=HEADERS)
def test_read_text_obeys_header_names(tmp_path, scan, header):
    rows = lines_of(scan, "bgrizyx", ",")
    (tmp_path / "scan.csv").write_text("\r\n".join([header, *rows]))
    found = read_scan(tmp_path / "scan.csv")
    np.testing.assert_array_equal(found.points_m, scan.points_m)
    np.testing.assert_array_equal(found.colours, scan.colours)


def test_read_text_takes_frames_by_name(tmp_path, scan):
    rows = [f"{line},{frame}" for line, frame in zip(lines_of(scan, "xyz", ","), scan.frame_ids, strict=True)]
    (tmp_path / "scan.csv").write_text("\n".join(["x,y,z,frame", *rows]))
    np.testing.assert_array_equal(read_scan(tmp_path / "scan.csv").frame_ids, scan.frame_ids)


def test_read_text_skips_remarks_and_blank_lines_anywhere(tmp_path, scan):
    rows = lines_of(scan, "xyzrgb", " ")
    mixed = ["# Größe 測量", "", *rows[:99], "// a remark", "  ", rows[99] + " # bent", *rows[100:], "", "#"]
    (tmp_path / "scan.xyz").write_bytes("\n".join(mixed).encode())
    np.testing.assert_array_equal(read_scan(tmp_path / "scan.xyz").points_m, scan.points_m)


def test_read_text_understands_decimal_commas_between_semicolons(tmp_path, scan):
    rows = [line.replace(".", ",") for line in lines_of(scan, "xyzrgb", ";")]
    (tmp_path / "scan.csv").write_text("\n".join(["X;Y;Z;R;G;B", *rows]))
    np.testing.assert_array_equal(read_scan(tmp_path / "scan.csv").points_m, scan.points_m)


def test_read_text_checks_the_point_count_of_pts_files(tmp_path, scan):
    rows = lines_of(scan, "xyzirgb", " ")
    path = tmp_path / "scan.pts"
    path.write_text("\n".join(["200", *rows]))
    np.testing.assert_array_equal(read_scan(path).points_m, scan.points_m)
    path.write_text("\n".join(["200", *rows[:150]]))
    with pytest.raises(InputError, match=r"promises 200 .* holds 150"):
        read_scan(path)


def test_read_text_says_which_of_two_possible_orders_it_took(tmp_path, scan):
    rows = [f"{line} 7" for line in lines_of(scan, "xyzrgb", " ")]
    (tmp_path / "scan.txt").write_text("\n".join(rows))
    assert "COLUMNS_ASSUMED" in {note.code for note in read_scan(tmp_path / "scan.txt").notes}


FAULTS = {
    "word": ("1 2 three", r"line 103: .*'three'"),
    "short": ("1 2", "line 103: found 2 values; 3 are"),
    "long": ("1 2 3 4", "line 103: found 4 values; 3 are"),
    "underscore": ("1_0 2 3", "line 103"),
}


@pytest.mark.parametrize(("line", "said"), FAULTS.values(), ids=FAULTS)
def test_read_text_names_the_malformed_line(tmp_path, scan, line, said):
    rows = lines_of(scan, "xyz", " ")
    (tmp_path / "scan.xyz").write_text("\n".join(["# remark", "", *rows[:100], line, *rows[100:]]))
    with pytest.raises(InputError, match=rf"scan\.xyz, {said}"):
        read_scan(tmp_path / "scan.xyz")


CONTENTS = {
    "header of another width": ("x,y,z,w\n1,2,3\n", "3 values under a header of 4"),
    "two headers": ("ncols 4\nnrows 5\n1 2 3\n", "line 2"),
    "two columns": ("1 2\n", "2 values"),
    "only remarks": ("# nothing\n\n", "0 points"),
    "binary": ("1 2 3\0\n", "binary"),
    "prose": ("Dear sir,\nI write to you\n", "line 2"),
}


@pytest.mark.parametrize(("content", "said"), CONTENTS.values(), ids=CONTENTS)
def test_read_text_refuses_what_is_no_cloud(tmp_path, content, said):
    (tmp_path / "scan.txt").write_text(content)
    with pytest.raises(InputError, match=said):
        read_scan(tmp_path / "scan.txt")
