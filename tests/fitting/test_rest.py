"""Planes come to rest wherever their points call them, even where no place is a fixed point."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from indoorfit.fitting.rest import Search, called, search_from

LIMIT_M = 1e-3


def rested(calls, start_m, rounds: int) -> tuple[Search, int]:
    """Search until every plane rests; `calls` maps the planes' places to where their points call them."""
    search = search_from(np.array(start_m, float))
    for k in range(1, rounds + 1):
        search = called(search, calls(search.place_m), LIMIT_M)
        if search.rests.all():
            return search, k
    return search, rounds + 1


@given(
    jump_m=st.floats(-0.09, 0.09),
    on_m=st.floats(0.002, 0.1),
    back_m=st.floats(0.002, 0.1),
    start_m=st.floats(-0.1, 0.1),
)
@settings(deadline=None, max_examples=200)
def test_a_plane_called_to_and_fro_rests_where_the_calls_change(jump_m, on_m, back_m, start_m):
    """From below the jump to a place above it, from above to one below it: nothing is a fixed point."""
    search, rounds = rested(
        lambda at_m: np.where(at_m < jump_m, jump_m + on_m, jump_m - back_m), [start_m], 20
    )
    # Three rounds to have the jump between two places at most 0.2 m apart, eight halvings down to a
    # millimetre, one round to see the other end again.
    assert rounds <= 12
    assert abs(search.stay_m[0] - jump_m) <= LIMIT_M
    # One standard deviation of a law that has both places alike.
    expected_m = np.sqrt(0.5 * (on_m**2 + back_m**2))
    assert search.swing_m[0] == pytest.approx(expected_m, abs=LIMIT_M)


@given(share=st.floats(-0.45, 0.9), start_m=st.floats(-0.1, 0.1))
@settings(deadline=None, max_examples=200)
def test_where_following_the_calls_ends_nothing_is_changed(share, start_m):
    """A contraction is followed step by step, to the same end in as many rounds, and leaves no doubt."""
    search, rounds = rested(lambda at_m: share * at_m, [start_m], 200)
    at_m, plain = start_m, 1
    while abs((share - 1.0) * at_m) >= LIMIT_M:
        at_m, plain = share * at_m, plain + 1
    assert rounds == plain
    # Rounding of places added to calls.
    assert search.stay_m[0] == pytest.approx(share * at_m, abs=1e-12)
    assert search.swing_m[0] == 0.0


@given(values_m=st.lists(st.floats(-0.1, 0.1), min_size=2, max_size=30), start_m=st.floats(-0.1, 0.1))
@settings(deadline=None, max_examples=300)
def test_whatever_the_calls_a_plane_comes_to_rest_where_it_can_stay(values_m, start_m):
    """Bounded calls that jump anywhere, as patches come and go."""
    edges_m = np.linspace(-0.1, 0.1, len(values_m) + 1)[1:-1]

    def calls(at_m):
        return np.array(values_m)[np.searchsorted(edges_m, at_m)]

    # At worst every round but the halvings gains a limit's length: 0.2 m of them, and as many again.
    search, rounds = rested(calls, [start_m], 400)
    assert rounds <= 400
    here_m = search.stay_m[0]
    around_m = calls(here_m + np.array([-LIMIT_M, 0.0, LIMIT_M])) - here_m
    if search.swing_m[0] == 0.0:
        assert np.min(np.abs(calls(search.tried_m) - search.tried_m)) < LIMIT_M
    else:
        assert around_m[0] > 0.0 > around_m[-1]


def test_a_bracket_that_another_plane_made_untrue_is_given_up():
    """The first plane's layers lie elsewhere once the second one has come down, as behind a turned frame."""

    def calls(at_m):
        jump_m = 0.05 if at_m[1] > 0.01 else -0.05
        first_m = jump_m + 0.02 if at_m[0] < jump_m else jump_m - 0.02
        return np.array([first_m, 0.6 * at_m[1]])

    search, _ = rested(calls, [0.0, 0.1], 40)
    assert search.rests.all()
    assert abs(search.stay_m[0] + 0.05) <= LIMIT_M
    assert search.swing_m[1] == 0.0


def test_a_plane_that_nothing_calls_keeps_its_place_to_the_bit():
    start_m = [1.0 / 3.0, -0.1]
    search, _ = rested(lambda at_m: np.array([at_m[0], 0.5 * at_m[1]]), start_m, 40)
    assert search.stay_m[0] == start_m[0]
