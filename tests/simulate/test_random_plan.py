"""Random rooms keep their promises whatever the seed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoorfit.errors import ConfigError
from indoorfit.geometry import exposures
from indoorfit.simulate import RandomRoomSettings, random_room


def wall_runs(shape):
    """Straight wall pieces, counted along the floor line: an outline has as many sides as corners."""
    n = 0
    for exposure in exposures(shape):
        if exposure.axis < 2:
            row = np.pad(exposure.mask.any(axis=1).astype(int), 1)
            n += int((np.diff(row) == 1).sum())
    return n


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10_000), half=st.integers(2, 7))
def test_random_room_has_the_walls_and_limits_asked_for(seed, half):
    limits = RandomRoomSettings()
    shape = random_room(np.random.default_rng(seed), 2 * half, limits)
    assert wall_runs(shape) == 2 * half
    low_m, high_m = shape.bounds_m()["cube-0"]
    size_m = high_m - low_m
    assert ((limits.size_m[0] <= size_m[:2]) & (size_m[:2] <= limits.size_m[1])).all()
    for axis in range(2):
        lines_m = np.unique([p.offset_m for p in shape.planes if p.axis == axis])
        # 1e-9 m: the sizes are rounded to the millimetre and summed.
        assert np.diff(lines_m).min() >= limits.min_step_m - 1e-9
    assert min(e.area_m2 for e in exposures(shape)) > 0.0


def test_many_walls_bring_nested_cubes_and_pillars():
    roles = {c.role for seed in range(40) for c in random_room(np.random.default_rng(seed), 14).cubes}
    assert roles == {"room", "notch", "pillar", "part"}


def test_same_seed_gives_the_same_room():
    first, second = (random_room(np.random.default_rng(5), 12) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("n_walls", [2, 7])
def test_impossible_wall_counts_are_refused(n_walls):
    with pytest.raises(ConfigError, match="even number"):
        random_room(np.random.default_rng(0), n_walls)


def test_room_too_small_for_its_walls_is_refused():
    cramped = RandomRoomSettings(size_m=(1.0, 1.2), min_step_m=0.4, min_passage_m=0.7)
    with pytest.raises(ConfigError, match="fewer walls"):
        random_room(np.random.default_rng(0), 14, cramped)
