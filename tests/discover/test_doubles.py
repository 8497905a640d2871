"""One wall that was seen twice is one wall; a step whose riser was seen is a step."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.discover.candidates import CandidateConfig, Lines
from indoorfit.discover.doubles import doubles
from indoorfit.discover.labelling import LabelConfig
from indoorfit.discover.outline import n_corners
from indoorfit.discover.overrides import PlanOverrides, WallStretch
from indoorfit.discover.planning import find_plan
from indoorfit.discover.rooms import RoomConfig
from indoorfit.discover.surfaces import Surfaces

SCATTER_M = 0.05
PRICE = 3.8
"""Half the logarithm of 2000 patches: a living room."""


def lines_at(offsets_m) -> Lines:
    offsets_m = np.asarray(offsets_m, float)
    return Lines(offsets_m, np.ones(len(offsets_m), bool), np.arange(len(offsets_m)))


def stepped(apart_m: float, riser: float, mask=None):
    """Arguments of `doubles` for a wall with one step in it, of whose riser a share was seen."""
    mask = np.array([[True, False], [True, True]]) if mask is None else mask
    lines = lines_at([0.0, 2.0, 4.0]), lines_at([0.0, 3.0, 3.0 + apart_m])
    seen = np.ones((3, 2)), np.ones((2, 3))
    seen[0][1, 1] = riser
    forced = np.zeros((3, 2), bool), np.zeros((2, 3), bool)
    return [mask], lines, seen, forced, SCATTER_M, PRICE, LabelConfig()


def test_the_riser_decides_where_the_distance_does_not():
    # Two walls at three standard deviations: 2.25 nats of the 3.8 that a position costs.
    assert doubles(*stepped(3.0 * SCATTER_M, riser=0.0)) == [(1, 1, 2)]
    assert doubles(*stepped(3.0 * SCATTER_M, riser=1.0)) == []


@pytest.mark.parametrize(("apart", "found"), [(1.0, [(1, 1, 2)]), (6.0, [])])
def test_the_distance_decides_where_it_is_clear(apart, found):
    """In standard deviations, whether the riser was seen or not."""
    for riser in (0.0, 1.0):
        assert doubles(*stepped(apart * SCATTER_M, riser)) == found


@given(apart_m=st.floats(0.01, 0.5), riser=st.floats(0.0, 1.0), nearer=st.floats(0.1, 1.0))
def test_what_is_one_wall_is_one_still_when_it_is_nearer_or_less_was_seen(apart_m, riser, nearer):
    if doubles(*stepped(apart_m, riser)):
        assert doubles(*stepped(nearer * apart_m, nearer * riser))


def test_the_two_sides_of_something_thin_are_not_one_wall():
    """They face opposite ways."""
    pillar = np.ones((3, 3), bool)
    pillar[1, 1] = False
    lines = lines_at([0.0, 1.0, 3.0, 4.0]), lines_at([0.0, 1.5, 1.55, 3.0])
    seen = np.zeros((4, 3)), np.zeros((3, 4))
    forced = np.zeros((4, 3), bool), np.zeros((3, 4), bool)
    assert doubles([pillar], lines, seen, forced, SCATTER_M, PRICE, LabelConfig()) == []


def test_the_second_corner_of_a_wall_that_was_seen_twice_is_no_riser():
    """Both walls of a corner were seen twice: the nook between the four lines is no room."""
    rooms, lines, seen, forced, *rest = stepped(3.0 * SCATTER_M, riser=1.0)
    x_m = np.array([0.0, 4.0 - 3.0 * SCATTER_M, 4.0])
    more_on_the_last = np.repeat([0, 1, 2], [5, 1, 5])
    x = Lines(x_m, np.ones(3, bool), more_on_the_last)
    assert doubles(rooms, (x, lines[1]), seen, forced, *rest) == [(1, 1, 2)]
    # Of as much as was seen of the other wall, it is a wall of its own.
    assert doubles(rooms, (replace(x, surfel_line=np.arange(3)), lines[1]), seen, forced, *rest) == []


def test_surfels_between_two_layers_are_no_riser():
    rooms, lines, seen, forced, *rest = stepped(3.0 * SCATTER_M, riser=1.0)
    x = replace(lines[0], seen=np.array([True, False, True]))
    assert doubles(rooms, (x, lines[1]), seen, forced, *rest) == [(1, 1, 2)]


def test_a_forced_wall_is_never_joined_to_another():
    arguments = list(stepped(SCATTER_M, riser=0.0))
    arguments[3][1][0, 1] = True
    assert doubles(*arguments) == []


@given(
    counts=st.lists(st.integers(1, 20), min_size=3, max_size=8),
    first=st.integers(0, 6),
    stray=st.integers(0, 5),
)
def test_joined_lines_keep_every_surfel(counts, first, stray):
    first = min(first, len(counts) - 2)
    surfels = np.concatenate([np.repeat(np.arange(len(counts)), counts), np.full(stray, -1)])
    lines = Lines(np.arange(len(counts), dtype=float), np.ones(len(counts), bool), surfels)
    joined = lines.joined([(first, first + 1)])
    both = counts[first] + counts[first + 1]
    expected = [*counts[:first], both, *counts[first + 2 :]]
    found = joined.surfel_line
    np.testing.assert_array_equal(np.bincount(found[found >= 0]), expected)
    assert np.sum(found == -1) == stray
    # Where more was seen.
    kept = int(joined.offsets_m[first])
    assert counts[kept] == max(counts[first : first + 2])
    assert np.all(np.diff(joined.offsets_m) > 0)


def room_with_step(apart_m: float, riser: bool) -> Surfaces:
    """4 m by 3 m and 2.5 m high; from the middle on one wall is farther away."""
    step_m = 0.05
    every = np.arange(step_m / 2, 4.0, step_m)
    up_m = np.arange(step_m / 2, 2.5, step_m)

    def wall(axis: int, at_m: float, low_m: float, high_m: float) -> np.ndarray:
        along_m = np.arange(low_m + step_m / 2, high_m, step_m)
        u, z = (grid.ravel() for grid in np.meshgrid(along_m, up_m))
        across = np.full(len(u), at_m)
        return np.column_stack([across, u, z] if axis == 0 else [u, across, z])

    x_walls = [wall(0, 0.0, 0.0, 3.0), wall(0, 4.0, 0.0, 3.0 + apart_m)]
    if riser:
        x_walls.append(wall(0, 2.0, 3.0, 3.0 + apart_m))
    y_walls = [wall(1, 0.0, 0.0, 4.0), wall(1, 3.0, 0.0, 2.0), wall(1, 3.0 + apart_m, 2.0, 4.0)]
    x, y = (grid.ravel() for grid in np.meshgrid(every, every))
    own = (y < 3.0) | ((x > 2.0) & (y < 3.0 + apart_m))
    level_m = np.column_stack([x[own], y[own], np.zeros(own.sum())])
    labels = [np.repeat(np.arange(len(walls)), [len(w) for w in walls]) for walls in (x_walls, y_walls)]
    return Surfaces(
        walls_m=(np.concatenate(x_walls), np.concatenate(y_walls)),
        wall_segments=(labels[0], labels[1]),
        stray_m=np.zeros((0, 3)),
        ceiling_m=level_m + np.array([0.0, 0.0, 2.5]),
        vault_m=np.zeros((0, 3)),
        floor_m=level_m,
        floor_height_m=0.0,
        ceiling_height_m=2.5,
        pixel_m=2 * step_m,
        noise_m=0.005,
        scatter_m=0.005,
    )


def corners_of(surfaces: Surfaces, forced: tuple[WallStretch, ...] = ()) -> int:
    overrides = PlanOverrides(forced=forced)
    plan = find_plan(surfaces, (), 50.0, CandidateConfig(), LabelConfig(), RoomConfig(), overrides)
    return n_corners(plan.inside)


def test_in_a_drifted_scan_a_step_whose_riser_was_seen_is_a_step():
    drifted = {"scatter_m": SCATTER_M}
    assert corners_of(replace(room_with_step(0.15, riser=True), **drifted)) == 6
    assert corners_of(replace(room_with_step(0.15, riser=False), **drifted)) == 4


def test_in_a_good_scan_a_step_is_one_without_its_riser_too():
    assert corners_of(room_with_step(0.15, riser=False)) == 6
