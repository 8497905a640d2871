"""Where surfels of walls crowd there may be a wall, and only there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.discover.candidates import CandidateConfig, candidate_lines
from indoorfit.discover.surfaces import Surfaces

NOTHING = np.zeros((0, 3))


def lines_of(across_m) -> np.ndarray:
    """Seen candidates across x of one grown segment whose surfels have these places, high and wide."""
    rng = np.random.default_rng(1)
    n = len(across_m)
    wall_m = np.column_stack([across_m, rng.uniform(0.0, 4.0, n), rng.uniform(0.0, 2.5, n)])
    surfaces = Surfaces(
        walls_m=(wall_m, NOTHING),
        wall_segments=(np.zeros(n, int), np.zeros(0, int)),
        stray_m=NOTHING,
        ceiling_m=NOTHING,
        vault_m=NOTHING,
        floor_m=NOTHING,
        floor_height_m=0.0,
        ceiling_height_m=2.5,
        pixel_m=0.15,
        noise_m=0.01,
        scatter_m=0.005,
    )
    lines = candidate_lines(surfaces, CandidateConfig())[0]
    return lines.offsets_m[lines.seen]


@given(st.floats(0.1, 0.5), st.integers(60, 1500), st.integers(0, 5))
def test_both_sides_of_a_partition_are_candidates_however_little_one_was_seen(thickness_m, n_far, seed):
    rng = np.random.default_rng(seed)
    near, far = rng.normal(0.0, 0.01, 1500), rng.normal(thickness_m, 0.01, n_far)
    found_m = np.sort(lines_of(np.concatenate([near, far])))
    assert found_m == pytest.approx([0.0, thickness_m], abs=0.01)


@given(st.floats(0.0, 0.04), st.integers(100, 3000), st.integers(0, 20))
def test_the_flank_of_a_noisy_wall_is_no_other_wall(noise_m, n, seed):
    found_m = lines_of(np.random.default_rng(seed).normal(0.0, noise_m, n))
    assert len(found_m) == 1
    # Half a bin and the scatter of a mode.
    assert found_m[0] == pytest.approx(0.0, abs=0.01 + noise_m)
