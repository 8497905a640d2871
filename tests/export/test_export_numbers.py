"""Numbers for people and for spreadsheets."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import FLAT, make_result

from indoorfit.export import quantity_text, write_dimensions_csv
from indoorfit.model import Interval, Quantity

LENGTHS = st.floats(0.01, 50.0)
HALVES = st.floats(1e-6, 1.0)


@settings(deadline=None)
@given(value=LENGTHS, below=HALVES, above=HALVES)
def test_printed_interval_is_never_narrower_than_the_computed_one(value, below, above):
    text = quantity_text(Quantity(value, below, Interval(0.95, value - below, value + above)))
    # A millionth of the last of four decimals is what the rounding forgives.
    slack = 1e-10
    assert float(text.low) <= value - below + slack
    assert float(text.high) >= value + above - slack
    if text.half_width is not None:
        assert float(text.half_width) >= max(below, above) - slack
    else:
        assert abs(above - below) > 0.05 * max(below, above)


@pytest.mark.parametrize(
    ("half", "value_text", "half_text"),
    [
        (0.0123, "5.080", "0.013"),
        (0.0012, "5.0800", "0.0012"),
        (0.4, "5.080", "0.400"),
        (2e-6, "5.0800", "0.0001"),
    ],
    ids=["centimetres", "millimetres", "decimetres", "micrometres"],
)
def test_decimals_follow_the_uncertainty(half, value_text, half_text):
    text = quantity_text(Quantity(5.08, half / 2, Interval(0.95, 5.08 - half, 5.08 + half)))
    assert (text.value, text.half_width) == (value_text, half_text)


def test_unknown_ends_are_said():
    text = quantity_text(Quantity(5.08, math.inf, Interval(0.95, -math.inf, 6.0)))
    assert (text.value, text.spread) == ("5.080", "unknown .. 6.000")


def test_csv_gives_every_dimension_back(tmp_path):
    result = make_result(*FLAT)
    write_dimensions_csv(tmp_path / "d.csv", result)
    rows = list(csv.DictReader(io.StringIO((tmp_path / "d.csv").read_bytes().decode(), newline="")))
    assert [row["id"] for row in rows] == [d.id for d in result.dimensions]
    for row, d in zip(rows, result.dimensions, strict=True):
        assert (row["face_from"], row["face_to"], row["wall"]) == (*d.faces, d.wall or "")
        assert (row["kind"], row["room"], row["status"]) == (d.kind, d.room, d.status)
        # Rounded to a nanometre; at 5e6 m float64 adds as much again.
        assert float(row["value_m"]) == pytest.approx(d.quantity.value, abs=1e-9)
        assert float(row["low_m"]) == pytest.approx(d.quantity.interval.low, abs=1e-9)
        assert float(row["high_m"]) == pytest.approx(d.quantity.interval.high, abs=1e-9)
        ends = [[float(row[f"{end}_{axis}_m"]) for axis in "xyz"] for end in ("from", "to")]
        np.testing.assert_allclose(ends, [d.from_m, d.to_m], rtol=0.0, atol=2e-9)


def test_csv_quotes_names_as_rfc_4180_asks(tmp_path):
    result = make_result(*FLAT)
    odd = replace(result.dimensions[0], room='a "b", c\r\nd')
    write_dimensions_csv(tmp_path / "d.csv", replace(result, dimensions=(odd,)))
    content = (tmp_path / "d.csv").read_bytes()
    assert content.count(b"\r\n") == 3
    (row,) = csv.DictReader(io.StringIO(content.decode(), newline=""))
    assert row["room"] == odd.room


def test_csv_leaves_unknown_numbers_empty(tmp_path):
    result = make_result(*FLAT)
    d = result.dimensions[0]
    lost = replace(d, quantity=replace(d.quantity, interval=Interval(0.95, -math.inf, math.inf)))
    write_dimensions_csv(tmp_path / "d.csv", replace(result, dimensions=(lost,)))
    (row,) = csv.DictReader(io.StringIO((tmp_path / "d.csv").read_text()))
    assert (row["low_m"], row["high_m"]) == ("", "")


def test_an_interval_that_is_not_symmetric_stands_in_brackets_behind_its_value():
    skewed = Quantity(5.08, 0.01, Interval(0.95, 5.05, 5.09))
    assert quantity_text(skewed).together == "5.080 (5.050 .. 5.090)"
    even = Quantity(5.08, 0.01, Interval(0.95, 5.06, 5.10))
    assert quantity_text(even).together == "5.080 ± 0.020"
