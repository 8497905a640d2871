"""Planes that passed each other are put back; pieces of one wall that do not meet have no order."""

import numpy as np
import pytest

from indoorfit.fitting.order import unpassed
from indoorfit.geometry import exposures, shape_from_plan
from indoorfit.model import Shape

HAIR_M = 2e-4


def recessed(n: int) -> tuple[Shape, list[int]]:
    """A hall with n recesses in one wall, and the n - 1 fronts between them."""
    mask = np.ones((2 * n - 1, 2), bool)
    mask[1::2, 1] = False
    shape = shape_from_plan(list(np.arange(2.0 * n)), [0.0, 3.0, 4.0], [mask], [(0.0, 2.5)])
    return shape, [k for k, plane in enumerate(shape.planes) if plane.axis == 1 and plane.offset_m == 3.0]


def shifted(shape: Shape, by_m: dict[int, float]) -> Shape:
    return shape.with_offsets(shape.offsets_m + [by_m.get(k, 0.0) for k in range(len(shape.planes))])


def stepped(depth_m: float) -> tuple[Shape, int, int]:
    """A room one of whose walls steps back by so much, and the two pieces of that wall."""
    mask = np.array([[True, False], [True, True]])
    shape = shape_from_plan([0.0, 2.0, 4.0], [0.0, 3.0, 3.0 + depth_m], [mask], [(0.0, 2.5)])
    front, back = (
        next(k for k, plane in enumerate(shape.planes) if plane.axis == 1 and plane.offset_m == y_m)
        for y_m in (3.0, 3.0 + depth_m)
    )
    return shape, front, back


@pytest.mark.parametrize("n", [3, 15], ids=["14-walls", "62-walls"])
def test_fronts_in_a_row_may_lie_in_any_order(n):
    """Each has its own place to some tenths of a millimetre, before the fit and after it."""
    shape, fronts = recessed(n)
    assert len(fronts) == n - 1
    before = shifted(shape, dict(zip(fronts, np.linspace(0.0, HAIR_M, n - 1), strict=True)))
    after = shifted(shape, dict(zip(fronts, np.linspace(HAIR_M, 0.0, n - 1), strict=True)))
    assert unpassed(before, after, np.full(len(shape.planes), 1000)) is None
    # Nothing is turned inside out: every face keeps its area to what a hair's breadth adds or takes.
    areas_m2 = [[face.area_m2 for face in exposures(one)] for one in (before, after)]
    np.testing.assert_allclose(areas_m2[0], areas_m2[1], atol=2.5 * 2 * HAIR_M)


@pytest.mark.parametrize("depth_m", [HAIR_M, 0.05, 0.2], ids=["hair", "narrow", "wide"])
def test_a_step_that_was_passed_is_put_back_behind_the_better_seen_piece(depth_m):
    shape, front, back = stepped(depth_m)
    points = np.full(len(shape.planes), 1000)
    points[back] = 10
    found = unpassed(shape, shifted(shape, {front: 0.01, back: -depth_m}), points)
    assert found is not None
    assert [k for k, plane in enumerate(found.planes) if plane.status == "inferred"] == [back]
    # Rounding.
    assert found.planes[back].offset_m - found.planes[front].offset_m == pytest.approx(depth_m, abs=1e-12)


def test_planes_in_order_are_left_alone():
    shape, front, _ = stepped(0.2)
    assert unpassed(shape, shifted(shape, {front: 0.1}), np.ones(len(shape.planes), int)) is None
