"""The ISPRS measures on boxes small enough to work out by hand."""

import numpy as np
import pytest

from indoorfit.errors import ConfigError
from indoorfit.evaluate import accuracy_m, completeness, correctness, isprs_curves
from indoorfit.geometry import shape_from_plan
from indoorfit.model import FitResult
from indoorfit.pipeline import truth_result
from indoorfit.simulate import scan_frame

LENGTH_M, WIDTH_M, HEIGHT_M = 5.0, 4.0, 2.5


def box(x_m: tuple[float, float] = (0.0, LENGTH_M), floor_m: float = 0.0) -> FitResult:
    shape = shape_from_plan(list(x_m), [0.0, WIDTH_M], [np.ones((1, 1), bool)], [(floor_m, HEIGHT_M)])
    return truth_result(shape, scan_frame(0.3, 0.02, 0.5, (2.0, 1.0, 0.0)), {}, 0)


def test_a_model_measured_against_itself_is_perfect_at_every_buffer():
    curves = isprs_curves(box(), box())
    assert set(curves.completeness) == {1.0}
    assert set(curves.correctness) == {1.0}
    np.testing.assert_allclose(curves.accuracy_m, 0.0, atol=1e-12)


def test_a_wall_8_cm_further_out_counts_from_a_buffer_of_8_cm_on():
    reference, source = box(), box((0.0, LENGTH_M + 0.08))
    walls = ("wall",)
    curves = isprs_curves(source, reference, (0.0, 0.07, 0.09), walls)
    # Of the reference's walls only the moved end is away from the source, except that the corners' strips
    # lie on the source's side walls: at b = 0 those are points of measure zero, at 7 cm strips of 7 cm.
    wall_m2 = 2 * HEIGHT_M * (LENGTH_M + WIDTH_M)
    end_m2 = WIDTH_M * HEIGHT_M
    assert curves.completeness[0] == pytest.approx(1 - end_m2 / wall_m2, abs=1e-9)
    # Cells of 5 cm, judged by their middles: the strip of 7 cm holds one cell of 5 cm at either end.
    near_m2 = 2 * 0.05 * HEIGHT_M
    assert curves.completeness[1] == pytest.approx(1 - (end_m2 - near_m2) / wall_m2, abs=1e-9)
    assert curves.completeness[2] == 1.0
    # The source is 8 cm longer on both sides as well.
    source_m2 = 2 * HEIGHT_M * (LENGTH_M + 0.08 + WIDTH_M)
    beyond_m2 = 2 * 0.08 * HEIGHT_M
    # Cells of the 5.08 m side are 5.08 / 102 m, so that at b = 0 up to one column more or less counts.
    assert curves.correctness[0] == pytest.approx(
        1 - (end_m2 + beyond_m2) / source_m2, abs=0.05 * 2 * HEIGHT_M / source_m2
    )
    assert curves.correctness[2] == 1.0


def test_a_room_half_as_long_has_its_completeness_and_is_correct():
    reference, source = box(), box((0.0, 2.5))
    whole_m2 = 2 * (LENGTH_M * WIDTH_M + LENGTH_M * HEIGHT_M + WIDTH_M * HEIGHT_M)
    # One end wall and half of floor, ceiling and both sides; strips near the source's inner wall are the
    # reference's own already.
    shared_m2 = WIDTH_M * HEIGHT_M + LENGTH_M * WIDTH_M + LENGTH_M * HEIGHT_M
    # The buffer of 0.1 m reaches two rows of cells further along floor, ceiling and sides.
    reached_m2 = 0.1 * 2 * (WIDTH_M + HEIGHT_M)
    assert completeness(source, reference, 0.1) == pytest.approx(
        (shared_m2 + reached_m2) / whole_m2, abs=1e-9
    )
    # All of the source lies on the reference but its inner wall, less two rows of cells along its rim.
    inner_m2 = (WIDTH_M - 0.2) * (HEIGHT_M - 0.2)
    source_m2 = 2 * (2.5 * WIDTH_M + 2.5 * HEIGHT_M + WIDTH_M * HEIGHT_M)
    assert correctness(source, reference, 0.1) == pytest.approx(1 - inner_m2 / source_m2, abs=1e-9)


def test_accuracy_is_the_median_of_what_the_cut_off_leaves():
    reference, raised = box(), box(floor_m=0.03)
    # The raised floor alone is 3 cm from every sample on the reference's floor.
    assert accuracy_m(raised, reference, 0.10, ("floor",)) == pytest.approx(0.03, abs=1e-12)
    assert np.isnan(accuracy_m(raised, reference, 0.02, ("floor",)))
    # With all faces most of the area is not away at all: floor 20 of 85 m2.
    assert accuracy_m(raised, reference, 0.10) == pytest.approx(0.0, abs=1e-12)


def test_measures_grow_with_the_buffer():
    curves = isprs_curves(box((0.03, LENGTH_M + 0.1)), box())
    for shares in (curves.completeness, curves.correctness):
        assert (np.diff(shares) >= 0.0).all()
    assert curves.completeness[-1] > curves.completeness[0]


def test_a_spacing_that_is_not_positive_is_refused():
    with pytest.raises(ConfigError, match="spacing_m"):
        isprs_curves(box(), box(), spacing_m=0.0)
