"""Planes that passed each other are put back; pieces of one wall that do not meet have no order."""

import numpy as np
import pytest

from indoorfit.fitting import JointConfig, fit_joint, joint
from indoorfit.fitting.order import as_started, unpassed
from indoorfit.geometry import exposures, passed, shape_from_plan
from indoorfit.model import Frame, Scan, Shape

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


def surface_points_m(shape: Shape, rng: np.random.Generator) -> np.ndarray:
    """Points on all faces of a room, 400 to the square metre, 5 mm off."""
    found = []
    for face in exposures(shape):
        plane = shape.planes[face.plane]
        low_m, high_m = np.array([face.u_m[0], face.v_m[0]]), np.array([face.u_m[-1], face.v_m[-1]])
        points_m = rng.uniform(low_m, high_m, (int(400 * np.prod(high_m - low_m)), 2))
        points_m = np.insert(points_m, plane.axis, plane.offset_m, axis=1)
        points_m = points_m[face.contains(points_m)]
        points_m[:, plane.axis] += rng.normal(0.0, 0.005, len(points_m))
        found.append(points_m)
    return np.concatenate(found)


@pytest.mark.parametrize("repairs", [0, 5], ids=["last resort", "plane by plane"])
@pytest.mark.parametrize("depth_m", [0.02, 0.05])
def test_the_fit_keeps_the_order_of_a_step_that_is_seen_the_other_way_round(depth_m, repairs, monkeypatch):
    """The larger piece, which should step back, stands 2 cm before the other one."""
    monkeypatch.setattr(joint, "_MAX_REPAIRS", repairs)
    mask = np.array([[True, False], [True, True]])
    start = shape_from_plan([0.0, 1.5, 4.0], [0.0, 3.0, 3.0 + depth_m], [mask], [(0.0, 2.5)])
    points_m = surface_points_m(start, np.random.default_rng(1))
    back = (np.abs(points_m[:, 1] - 3.0 - depth_m) < 0.02) & (points_m[:, 0] > 1.5)
    points_m[back & (np.abs(points_m[:, 2] - 1.25) < 1.23), 1] -= depth_m + 0.02
    fit = fit_joint(Scan(points_m), Frame(np.eye(3), np.zeros(3)), start, JointConfig(), 0.1)
    assert passed(start, fit.shape) == []
    assert fit.converged
    assert fit.put_back
    assert all(fit.shape.planes[k].status == "inferred" for k in fit.put_back)
    # The outer faces of the other directions are fitted as ever: 3000 points of 5 mm on each, and the turn of
    # the frame.
    across = [k for k, plane in enumerate(start.planes) if plane.axis != 1 and plane.offset_m != 1.5]
    np.testing.assert_allclose(fit.shape.offsets_m[across], start.offsets_m[across], atol=1e-3)


def test_the_last_resort_puts_back_one_direction_and_leaves_the_others():
    shape, front, _ = stepped(0.2)
    after = shifted(shape, {front: 0.3, 0: 0.01, 1: 0.02})
    found = as_started(shape, after)
    for k, plane in enumerate(shape.planes):
        returned = plane.axis == 1
        assert (found.planes[k].status == "inferred") == returned
        assert found.planes[k].offset_m == (plane if returned else after.planes[k]).offset_m
