"""Where a plane comes to rest: the place at which the points stop calling it on and begin to call it back."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

_STUBBORN = 0.5
"""A call back that is weaker than this share of the call before dies out by itself; another one is halved."""


@dataclass(frozen=True)
class Search:
    """What the rounds so far have told of every plane; offsets in metres.

    In each round the points that a plane claims at its place call it to another one. The fit is a fixed
    point of that: a place to which its own points call it. Where the claims jump, because a layer of points
    or a patch comes into reach or leaves it, there need not be one: from either side of the jump the points
    call to the other, and following them goes on for ever. There is then still exactly one kind of place at
    which a plane can stay: that where the calls change from "on" to "back". The calls are bounded, so it
    exists, and two places between which they change are halved until it is found. It is the fixed point of
    the calls made upper semicontinuous, and where they are continuous the fixed point itself.

    Source: Kakutani 1941, Duke Math. J. 8; Filippov 1988, "Differential equations with discontinuous
    right-hand sides", section 4; the halving is Dekker's guard of an iteration with a bracket.
    """

    place_m: Float[np.ndarray, " planes"]
    """Where each plane is to be tried next."""
    tried_m: Float[np.ndarray, " planes"]
    """Where it was tried last; not a number before the first round."""
    call_m: Float[np.ndarray, " planes"]
    """By how much it was called away from there."""
    low_m: Float[np.ndarray, " planes"]
    """The largest place known to call upwards, minus infinity if none is."""
    high_m: Float[np.ndarray, " planes"]
    """The smallest place known to call downwards, infinity if none is."""
    rests: Bool[np.ndarray, " planes"]
    """Whether the plane is where it can stay, within the limit."""
    stay_m: Float[np.ndarray, " planes"]
    """Where it is put if the rounds end here: between the two places at which the calls change."""
    swing_m: Float[np.ndarray, " planes"]
    """How far from there its points call it, in the root mean square over both sides; 0 where they do not:
    one standard deviation of a law in which both places are alike."""


def search_from(offsets_m: Float[np.ndarray, " planes"]) -> Search:
    """Nothing is known yet.

    Args:
        offsets_m: where the planes begin.
    """
    n = len(offsets_m)
    return Search(
        place_m=offsets_m,
        tried_m=np.full(n, np.nan),
        call_m=np.zeros(n),
        low_m=np.full(n, -np.inf),
        high_m=np.full(n, np.inf),
        rests=np.zeros(n, bool),
        stay_m=offsets_m,
        swing_m=np.zeros(n),
    )


def called(search: Search, fitted_m: Float[np.ndarray, " planes"], limit_m: float) -> Search:
    """What is known after the planes were tried at `place_m` and their points called them to other offsets.

    Args:
        search: before.
        fitted_m: where the points claimed at `search.place_m` call the planes.
        limit_m: shorter ways are none.
    """
    at_m, before_m = search.place_m, search.call_m
    call_m = fitted_m - at_m
    up, down = call_m > 0.0, call_m < 0.0
    # An end that a call contradicts is forgotten: other planes have moved, and points with them.
    low_m = np.where(up, at_m, np.where(down & (search.low_m >= at_m), -np.inf, search.low_m))
    high_m = np.where(down, at_m, np.where(up & (search.high_m <= at_m), np.inf, search.high_m))
    known = np.isfinite(low_m) & np.isfinite(high_m)
    from_m, to_m = np.where(known, low_m, at_m), np.where(known, high_m, at_m)
    # Once the ends are close, from one to the other: that shows whether both are still up to date.
    close = to_m - from_m <= limit_m
    inner_m = np.where(close, np.where(up, to_m, from_m), 0.5 * (from_m + to_m))
    near = np.abs(call_m) < limit_m
    back = call_m * before_m < 0.0
    beyond = (fitted_m <= low_m) | (fitted_m >= high_m)
    halved = known & ~near & (beyond | (back & (np.abs(call_m) > _STUBBORN * np.abs(before_m))))
    changes = ~near & back & (np.abs(at_m - search.tried_m) <= limit_m)
    place_m = np.where(halved, inner_m, fitted_m)
    stay_m = np.where(changes, 0.5 * (at_m + search.tried_m), place_m)
    both_m = np.hypot(fitted_m - stay_m, search.tried_m + before_m - stay_m) / np.sqrt(2.0)
    return Search(
        place_m=place_m,
        tried_m=at_m,
        call_m=call_m,
        low_m=low_m,
        high_m=high_m,
        rests=near | changes,
        stay_m=stay_m,
        swing_m=np.where(near, 0.0, np.where(changes, both_m, np.abs(call_m))),
    )
