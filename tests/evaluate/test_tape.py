"""Readings find their lengths, and the comparison is what the formulas say."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from indoorfit.evaluate import check_tape, combine, tape_notes
from indoorfit.model import Interval, TapeReading, TapeTable
from indoorfit.pipeline import fit_scan
from synthetic import virtual

Z95 = 1.959963984540054


@pytest.fixture(scope="module")
def model():
    return fit_scan(virtual("L", 1, n_points=30_000, yaw_deg=20, tilt_deg=3).scan)


def tape(*readings):
    return TapeTable("tape.csv", "", tuple(readings), ())


def reading(line=2, value_m=5.0, std_m=0.005, **what):
    return TapeReading(line, value_m, std_m, what.pop("instrument", "tape"), **what)


def test_every_length_is_found_by_its_id(model):
    rows = [
        reading(k, d.quantity.value, dimension=d.id, faces=d.faces)
        for k, d in enumerate(model.dimensions, start=2)
    ]
    verdict = check_tape(model, tape(*rows))
    assert [check.dimension for check in verdict.checks] == [d.id for d in model.dimensions]
    assert not verdict.refused


@pytest.mark.parametrize("turned", [False, True], ids=["as stored", "swapped"])
def test_every_length_is_found_by_faces_and_by_points(model, turned):
    for d in model.dimensions:
        ends = (d.faces, (tuple(d.from_m), tuple(d.to_m)))
        faces, points = (tuple(reversed(e)) if turned else e for e in ends)
        for what in ({"faces": faces}, {"points_m": points}):
            verdict = check_tape(model, tape(reading(2, d.quantity.value, **what)))
            assert not verdict.refused
            found = next(x for x in model.dimensions if x.id == verdict.checks[0].dimension)
            # Two walls of equal length lie between the same planes: either is the same length.
            assert {model.face(f).plane for f in found.faces} == {model.face(f).plane for f in d.faces}


def test_points_need_not_lie_on_the_faces(model):
    rng = np.random.default_rng(0)
    for d in model.dimensions:
        # 8 cm each way is what a click in a viewer or a guess is off by.
        near = [tuple(end + rng.uniform(-0.08, 0.08, 3)) for end in (d.from_m, d.to_m)]
        verdict = check_tape(model, tape(reading(2, d.quantity.value, points_m=(near[0], near[1]))))
        assert verdict.checks, verdict.refused
        # Opposite sides of a room are as long as each other but for rounding.
        assert verdict.checks[0].value_m == pytest.approx(d.quantity.value, abs=1e-12)


REFUSED = {
    "unknown id": ({"dimension": "ZZ"}, "does not have"),
    "unknown face": ({"faces": ("wall-1", "wall-99")}, "does not have"),
    "not opposite": ({"faces": ("wall-1", "wall-2")}, "has none between"),
    "points in the air": ({"points_m": ((50.0, 0.0, 0.0), (60.0, 0.0, 0.0))}, "no two faces"),
    "other faces": ({"dimension": "A", "faces": ("floor-1", "ceiling-1")}, "another fit"),
    "centimetres as metres": ({"dimension": "A", "value_m": 508.0}, "wrong unit"),
    "feet as metres": ({"dimension": "A", "value_m": 5.08 / 0.3048}, "wrong unit"),
    "another scan": ({"dimension": "A", "scan": "kitchen"}, "kitchen"),
}


@pytest.mark.parametrize(("what", "said"), REFUSED.values(), ids=REFUSED.keys())
def test_a_reading_that_fits_nothing_is_named(model, what, said):
    verdict = check_tape(model, tape(reading(7, **{"value_m": 5.08, **what})))
    assert verdict.checks == ()
    assert verdict.refused[0].line == 7
    assert said in verdict.refused[0].reason
    assert [note.code for note in tape_notes(verdict)] == ["TAPE_ROWS_REFUSED"]


def test_a_scan_goes_by_its_name_with_or_without_suffix(model):
    for name in ("L.ply", "L", None):
        assert check_tape(model, tape(reading(2, 5.08, dimension="A", scan=name))).checks


def test_e_n_is_the_formula(model):
    first = model.dimensions[0]
    value_m, interval = first.quantity.value, first.quantity.interval
    off_m, std_m = 0.004, 0.002
    check = check_tape(model, tape(reading(2, value_m + off_m, std_m, dimension=first.id))).checks[0]
    expanded_m = interval.high - value_m
    assert check.deviation_m == pytest.approx(-off_m, abs=1e-12)
    assert check.e_n == pytest.approx(off_m / math.hypot(expanded_m, Z95 * std_m), rel=1e-9)
    assert check.holds == (value_m + off_m <= interval.high)


def test_the_level_of_the_intervals_does_not_change_e_n(model):
    """A normal interval at 80 % and one at 95 % say the same."""
    first = model.dimensions[0]
    value_m = first.quantity.value

    def e_n(level, z):
        interval = Interval(level, value_m - z * 0.001, value_m + z * 0.001)
        changed = replace(first, quantity=replace(first.quantity, interval=interval, intervals=()))
        other = replace(model, dimensions=(changed, *model.dimensions[1:]))
        return check_tape(other, tape(reading(2, value_m + 0.003, dimension=first.id))).checks[0].e_n

    assert e_n(0.8, 1.2815515655446004) == pytest.approx(e_n(0.95, Z95), rel=1e-9)


def test_readings_of_one_instrument_share_its_error():
    same = [reading(k, 5.0 + 0.001 * k) for k in range(4)]
    assert combine(same) == (pytest.approx(5.0015), pytest.approx(0.005))
    scattered = [reading(1, 5.0), reading(2, 5.1)]
    assert combine(scattered)[1] == pytest.approx(0.1 / math.sqrt(2))


def test_instruments_are_weighted_by_their_uncertainty():
    both = [reading(1, 5.0, 0.004), reading(2, 5.01, 0.003, instrument="laser")]
    value_m, std_m = combine(both)
    assert value_m == pytest.approx((5.0 / 16 + 5.01 / 9) / (1 / 16 + 1 / 9))
    assert std_m == pytest.approx(1e-3 / math.sqrt(1 / 16 + 1 / 9))


def test_chi2_of_one_length_is_its_squared_deviation(model):
    first = model.dimensions[0]
    verdict = check_tape(model, tape(reading(2, first.quantity.value + 0.02, dimension=first.id)))
    # chi² = (E_n * 1.96)², by definition of both.
    assert verdict.chi2 == pytest.approx((Z95 * verdict.checks[0].e_n) ** 2, rel=1e-9)
    assert verdict.p_value == pytest.approx(chi2.sf(verdict.chi2, 1), rel=1e-9)


def test_lengths_that_share_a_wall_count_less_than_two(model):
    """The same surprise twice over, through a wall that both share, is less of a surprise than two."""
    shared = [d for d in model.dimensions if d.id in ("A", "D")]
    assert {model.face(f).plane for f in shared[0].faces} == {model.face(f).plane for f in shared[1].faces}
    rows = [reading(k, d.quantity.value + 0.001, 1e-5, dimension=d.id) for k, d in enumerate(shared, 2)]
    both, alone = check_tape(model, tape(*rows)), check_tape(model, tape(rows[0]))
    # 1e-5 m against intervals of a millimetre: the two are one length but for a ten-thousandth.
    assert both.chi2 == pytest.approx(alone.chi2, rel=1e-2)


def test_chi2_of_readings_as_the_model_believes_them_is_what_its_distribution_says(model):
    """Means of chi² over draws from the model's own belief: their expectation is the number of lengths."""
    rng = np.random.default_rng(3)
    own = [d for d in model.dimensions if d.id in ("A", "B", "C", "E")]
    rows = np.zeros((len(own), len(model.shape.planes)))
    for row, d in zip(rows, own, strict=True):
        row[model.face(d.faces[0]).plane], row[model.face(d.faces[1]).plane] = -1.0, 1.0
    covariance = rows @ model.plane_covariance_m2 @ rows.T
    # The intervals' standard deviations, which the check uses, against those of the covariance.
    stds = [(d.quantity.interval.high - d.quantity.value) / Z95 for d in own]
    ratio = np.array(stds) / np.sqrt(np.diag(covariance))
    draws = rng.multivariate_normal(np.zeros(4), covariance * np.outer(ratio, ratio), size=200)
    found = []
    for draw in draws:
        rows = [
            reading(k, d.quantity.value + error_m, 1e-6, dimension=d.id)
            for k, (d, error_m) in enumerate(zip(own, draw, strict=True))
        ]
        found.append(check_tape(model, tape(*rows)).chi2)
    # Mean of 200 draws of chi² with 4 degrees: 4 +- sqrt(8 / 200) = 0.2; intervals are skewed by per cents.
    assert np.mean(found) == pytest.approx(4.0, abs=1.0)


def test_a_contradiction_is_said_and_nothing_is_rescaled(model):
    first = model.dimensions[0]
    verdict = check_tape(model, tape(reading(2, first.quantity.value + 0.05, dimension=first.id)))
    codes = [note.code for note in tape_notes(verdict)]
    assert verdict.p_value < 0.01
    assert codes == ["TAPE_CONTRADICTS"]
    fine = check_tape(model, tape(reading(2, first.quantity.value + 0.004, dimension=first.id)))
    assert tape_notes(fine) == ()
