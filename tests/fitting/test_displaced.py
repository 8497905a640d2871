"""Frames that were registered somewhere else: found, not invented, and doubted where it may be others."""

from dataclasses import replace

import numpy as np
import pytest

from indoorfit.fitting import DisplacedConfig, displaced_shifts
from indoorfit.fitting.displaced import Displacements, doubt_covariance
from indoorfit.fitting.uncertainty import Cells

CONFIG = DisplacedConfig()
SIZE_M = np.array([6.0, 4.0])
NOISE_M = 0.005
SHIFT_M = 0.15


def walls_seen(walls_of_frame, shift_m, seed=0):
    """Points on a room of 6 x 4 m; each frame sees some of the walls '-x', '+x', '-y' and '+y'."""
    rng = np.random.default_rng(seed)
    points, axes, frames = [], [], []
    for frame, walls in enumerate(walls_of_frame):
        for wall in walls:
            axis = "xy".index(wall[1])
            n = 600
            place = rng.uniform(0.0, 1.0, n) * SIZE_M[1 - axis]
            across = (SIZE_M[axis] if wall[0] == "+" else 0.0) + rng.normal(0.0, NOISE_M, n)
            xy = np.empty((n, 2))
            xy[:, axis], xy[:, 1 - axis] = across, place
            points.append(np.column_stack([xy, rng.uniform(0.0, 2.5, n)]) + shift_m[frame])
            axes.append(np.full(n, axis))
            frames.append(np.full(n, frame))
    centres_m = np.array([*(0.5 * SIZE_M), 1.4]) + shift_m
    return np.concatenate(points), np.concatenate(axes), np.concatenate(frames), centres_m


def block(n_frames, moved, axis=0):
    shift_m = np.zeros((n_frames, 3))
    shift_m[moved, axis] = SHIFT_M
    return shift_m


ROUND = [("-x", "-y"), ("-x", "+x"), ("+x", "+y"), ("+y", "-y")] * 5


def test_a_displaced_block_is_found_to_the_noise_of_its_places():
    shift_m = block(20, [4, 5, 6])
    found = displaced_shifts(*walls_seen(ROUND, shift_m), CONFIG)
    moved = np.any(shift_m != 0.0, axis=1)
    # Each at 40 places, whose middle points have a standard error of 1.25 * 5 mm / sqrt(15): five of them.
    np.testing.assert_allclose(found.shifts_m[moved], shift_m[moved], rtol=0.0, atol=0.01)
    assert not found.shifts_m[~moved].any()
    # Frames that see both sides tell which of them moved.
    assert len(found.others_m) == 0


@pytest.mark.parametrize("rms_m", [0.0, 0.02], ids=["exact", "2 cm drift"])
def test_ordinary_drift_moves_no_frame(rms_m):
    shift_m = np.random.default_rng(1).normal(0.0, rms_m, (20, 3))
    assert not displaced_shifts(*walls_seen(ROUND, shift_m), CONFIG).shifts_m.any()


def test_a_thing_before_a_wall_moves_no_frame():
    points_m, axes, frames, centres_m = walls_seen(ROUND, np.zeros((20, 3)))
    # A board of 40 cm, 15 cm before the wall, that every other of the frames sees from its side.
    hidden = (points_m[:, 0] > 5.9) & (points_m[:, 1] < 0.4) & (frames % 8 == 1)
    points_m[hidden, 0] -= 0.15
    assert not displaced_shifts(points_m, axes, frames, centres_m, CONFIG).shifts_m.any()


def test_both_sides_of_a_partition_are_two_surfaces():
    here = walls_seen([("+x",)] * 6, np.zeros((6, 3)))
    there = walls_seen([("-x",)] * 6, np.tile([SIZE_M[0] + 0.12, 0.0, 0.0], (6, 1)), seed=1)
    points_m, axes, frames, centres_m = (
        np.concatenate(pair) for pair in zip(here, (*there[:2], there[2] + 6, there[3]), strict=True)
    )
    assert not displaced_shifts(points_m, axes, frames, centres_m, CONFIG).shifts_m.any()


def test_the_order_of_the_points_does_not_matter():
    points_m, axes, frames, centres_m = walls_seen(ROUND, block(20, [5, 6, 7]))
    order = np.random.default_rng(2).permutation(len(points_m))
    one = displaced_shifts(points_m, axes, frames, centres_m, CONFIG)
    other = displaced_shifts(points_m[order], axes[order], frames[order], centres_m, CONFIG)
    # The solver's tolerance.
    np.testing.assert_allclose(one.shifts_m, other.shifts_m, rtol=0.0, atol=1e-7)


def test_a_group_that_shares_nothing_else_with_the_room_is_doubted():
    # Nobody sees +x and -x at once, and +x is seen by two groups that contradict each other.
    walls = [("-x",)] * 10 + [("+x",)] * 8
    found = displaced_shifts(*walls_seen(walls, block(18, [10, 11, 12])), CONFIG)
    np.testing.assert_allclose(found.shifts_m[10:13, 0], SHIFT_M, atol=0.01)
    assert len(found.others_m) == 1
    # All that saw +x would be 15 cm less far out; those at -x would stay.
    np.testing.assert_allclose(found.others_m[0, 10:, 0], -SHIFT_M, atol=0.03)
    np.testing.assert_allclose(found.others_m[0, :10], 0.0, atol=1e-6)


def test_doubt_moves_a_side_of_the_room_as_a_whole():
    design = np.zeros((6, 6))
    plane = np.array([0, 0, 1, 1, 2, 2])
    design[np.arange(6), 3 + plane] = -1.0
    design[:, 1] = 2.0  # perpendicular to x
    cells = Cells(
        plane=plane,
        design=design,
        centroids_m=np.zeros((6, 3)),
        residuals_m=np.zeros(6),
        variances_m2=np.ones(6),
        counts=np.ones(6, int),
        frames=np.array([0, 0, 1, 1, 1, 1]),
    )
    others_m = np.zeros((1, 2, 3))
    others_m[0, 1, 0] = -SHIFT_M
    covariance = doubt_covariance(cells, Displacements(np.zeros((2, 3)), others_m), 3)
    step, across = np.array([0.0, -1.0, 1.0]), np.array([-1.0, 1.0, 0.0])
    assert step @ covariance @ step == pytest.approx(0.0, abs=1e-12)
    # Half of the cases are off by the whole shift.
    assert across @ covariance @ across == pytest.approx(0.5 * SHIFT_M**2)


def test_frames_are_held_by_more_than_the_places_that_they_saw():
    seen = walls_seen(ROUND, block(20, [4, 5, 6]))
    assert not displaced_shifts(*seen, replace(CONFIG, hold=1e3)).shifts_m.any()


def test_one_frame_alone_is_no_block():
    seen = walls_seen(ROUND, block(20, [5]))
    assert not displaced_shifts(*seen, CONFIG).shifts_m.any()
    assert displaced_shifts(*seen, replace(CONFIG, min_block=1)).shifts_m.any()


def test_where_all_frames_drift_none_is_displaced():
    rng = np.random.default_rng(3)
    drift_m = np.cumsum(rng.normal(0.0, 0.04, (20, 3)), axis=0)
    seen = walls_seen(ROUND, drift_m - drift_m.mean(axis=0))
    assert displaced_shifts(*seen, replace(CONFIG, min_sigmas=0.0)).shifts_m.any()
    assert not displaced_shifts(*seen, CONFIG).shifts_m.any()
