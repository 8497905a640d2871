"""Tables of readings: every row with content is either a reading or named with its line."""

import random

import pytest

from indoorfit.errors import InputError
from indoorfit.io import read_tape
from indoorfit.io import tape as tape_module

HEADER = "scan,dimension,face_1,face_2,value,unit,std_mm,instrument,reading,remark\n"


def table(tmp_path, text, name="tape.csv"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_tape(path)


def one(tmp_path, row):
    """The only reading, or the only reason, of a table with one row."""
    found = table(tmp_path, HEADER + row + "\n")
    assert len(found.readings) + len(found.refused) == 1
    return found.readings[0] if found.readings else found.refused[0].reason


@pytest.mark.parametrize(
    ("value", "unit", "metres"),
    [
        ("5.08", "m", 5.08),
        ("508", "cm", 5.08),
        ("5080", "mm", 5.08),
        ("10", "ft", 3.048),
        ("100", "in", 2.54),
    ],
)
def test_values_are_converted_to_metres(tmp_path, value, unit, metres):
    assert one(tmp_path, f",A,,,{value},{unit},,,,").value_m == pytest.approx(metres, rel=1e-15)


def test_uncertainty_is_the_instruments_unless_it_is_given(tmp_path):
    assert one(tmp_path, ",A,,,5,m,,,,").std_m == 0.005
    assert one(tmp_path, ",A,,,5,m,,tape,,").std_m == 0.005
    assert one(tmp_path, ",A,,,5,m,,laser,,").std_m == 0.0015
    assert one(tmp_path, ",A,,,5,m,2,laser,,").std_m == 0.002


DAMAGE = {
    "no value": (",A,,,,m,,,,", "no value"),
    "no unit": (",A,,,5.08,,,,,", "no unit"),
    "wrong unit": (",A,,,5.08,yards,,,,", "unit"),
    "text in a number": (",A,,,5.08m,m,,,,", "a number is needed"),
    "decimal comma": (',A,,,"5,08",m,,,,', "a number is needed"),
    "underscore": (",A,,,5_08,m,,,,", "a number is needed"),
    "not a number": (",A,,,nan,m,,,,", "finite"),
    "infinite": (",A,,,inf,m,,,,", "finite"),
    "negative": (",A,,,-5.08,m,,,,", "above 0"),
    "zero": (",A,,,0,m,,,,", "above 0"),
    "longer than any room": (",A,,,5080,m,,,,", "up to 1000 m"),
    "nothing measured": (",,,,5.08,m,,,,", "what was measured"),
    "one face": (",,wall-1,,5.08,m,,,,", "two"),
    "the same face twice": (",,wall-1,wall-1,5.08,m,,,,", "two faces"),
    "unknown instrument": (",A,,,5.08,m,,ruler,,", "tape or laser"),
    "bad uncertainty": (",A,,,5.08,m,-1,,,", "std_mm"),
    "bad count": (",A,,,5.08,m,,,1.5,", "reading"),
    "too few values": (",A,5.08,m", "4 values"),
    "too many values": (",A,,,5.08,m,,,,,,,", "13 values"),
    "lost quote": (',A,,,5.08,m,,,,"remark', "no row of a table"),
    "separators only": (",,,,,,,,,", "separators"),
    "zero byte": (",A,,,5.08,m,,,,\0", "zero byte"),
    "endless line": (",A,,,5.08,m,,,," + 9000 * "x", "bytes long"),
}


@pytest.mark.parametrize(("row", "reason"), DAMAGE.values(), ids=DAMAGE.keys())
def test_damage_is_named(tmp_path, row, reason):
    assert reason in one(tmp_path, row)


def test_text_that_is_not_utf_8_costs_its_row_only(tmp_path):
    found = table(tmp_path, HEADER.encode() + b",A,,,5,m,,,,k\xfcche\n,B,,,5,m,,,,\n")
    assert [reading.line for reading in found.readings] == [3]
    assert [(row.line, "UTF-8" in row.reason) for row in found.refused] == [(2, True)]


def test_of_a_thousand_rows_each_is_a_reading_or_named(tmp_path):
    rng = random.Random(0)
    sound = [f",D{k},,,{rng.uniform(0.3, 9):.3f},m,,laser,,fine" for k in range(400)]
    copies = rng.sample(sound, 100)
    broken = [rng.choice(list(DAMAGE.values()))[0] for _ in range(500)]
    rows = sound + broken
    rng.shuffle(rows)
    rows += copies
    found = table(tmp_path, HEADER + "\n".join(rows) + "\n")
    lines = {reading.line for reading in found.readings} | {row.line for row in found.refused}
    assert lines == set(range(2, 1002))
    assert len(found.readings) == 400
    assert {rows[reading.line - 2] for reading in found.readings} == set(sound)
    assert sum("repeats line" in row.reason for row in found.refused) == 100


def test_blank_lines_and_remarks_keep_the_line_numbers(tmp_path):
    found = table(tmp_path, "# of Monday\n\n" + HEADER + "\n# corridor\n,A,,,5,m,,,,\n,B,,,x,m,,,,\n")
    assert [reading.line for reading in found.readings] == [6]
    assert [row.line for row in found.refused] == [7]


def test_repeated_readings_are_kept_and_copies_are_not(tmp_path):
    rows = [",A,,,5.081,m,,,,", ",A,,,5.083,m,,,,", ",A,,,5.081,m,,,,", ",B,,,2,m,,,1,", ",B,,,2,m,,,2,"]
    rows += [",B,,,2.1,m,,,2,"]
    found = table(tmp_path, HEADER + "\n".join(rows))
    assert [reading.line for reading in found.readings] == [2, 3, 5, 6]
    assert [row.line for row in found.refused] == [4, 7]


def test_semicolons_come_with_decimal_commas(tmp_path):
    found = table(tmp_path, "dimension;value;unit;std_mm\nA;5,08;m;1,5\n")
    assert found.readings[0].value_m == 5.08
    assert found.readings[0].std_m == pytest.approx(0.0015)


def test_a_byte_order_mark_is_no_part_of_the_header(tmp_path):
    assert table(tmp_path, b"\xef\xbb\xbfdimension,value,unit\r\nA,5,m\r\n").readings[0].dimension == "A"


def test_two_points_may_name_a_length(tmp_path):
    text = "x1_m,y1_m,z1_m,x2_m,y2_m,z2_m,value,unit\n0,1,1,5,1,1,5,m\n0,1,1,5,1,,5,m\n"
    found = table(tmp_path, text)
    assert found.readings[0].points_m == ((0.0, 1.0, 1.0), (5.0, 1.0, 1.0))
    assert "z2_m" in found.refused[0].reason


def test_toml_says_the_same_as_csv(tmp_path):
    text = """
    unit = "cm"
    instrument = "laser"
    [[reading]]
    dimension = "A"
    value = 508.1
    [[reading]]
    faces = ["wall-1", "wall-3"]
    value = 3.2
    unit = "m"
    [[reading]]
    points_m = [[0, 1, 1], [5, 1, 1]]
    value = "five"
    [[reading]]
    dimension = "B"
    value = true
    [[reading]]
    dimension = "B"
    length = 5
    value = 5
    """
    found = table(tmp_path, text, "tape.toml")
    assert [(r.line, r.value_m, r.std_m) for r in found.readings] == [(4, 5.081, 0.0015), (7, 3.2, 0.0015)]
    assert found.readings[1].faces == ("wall-1", "wall-3")
    assert [row.line for row in found.refused] == [11, 14, 17]


@pytest.mark.parametrize(
    ("content", "name", "said"),
    [
        (b"", "a.csv", "header"),
        (b"dimension,value\nA,5\n", "a.csv", "line 1"),
        (b"dimension,value,unit,colour\n", "a.csv", "colour"),
        (b"reading = 3", "a.toml", "[[reading]]"),
        (b"x = = 1", "a.toml", "not TOML"),
        (b"speed = 3\n[[reading]]\n", "a.toml", "speed"),
    ],
    ids=["empty", "no unit column", "unknown column", "no tables", "no toml", "unknown key"],
)
def test_what_is_no_table_at_all_is_refused(tmp_path, content, name, said):
    with pytest.raises(InputError) as caught:
        table(tmp_path, content, name)
    assert said in str(caught.value)
    assert name in str(caught.value)
    assert "Fix:" in str(caught.value)


def test_a_huge_file_is_refused_unread(tmp_path, monkeypatch):
    monkeypatch.setattr(tape_module, "MAX_BYTES", 100)
    with pytest.raises(InputError, match="not the scan"):
        table(tmp_path, HEADER + 20 * ",A,,,5,m,,,,\n")


def test_a_missing_file_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_tape(tmp_path / "none.csv")
