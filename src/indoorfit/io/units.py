"""Units of length, and whether a cloud's size can be that of a room."""

from typing import Literal, get_args

import numpy as np
from jaxtyping import Float

from ..errors import ConfigError
from ..model import Note

Unit = Literal["m", "cm", "mm", "ft", "in"]

_METRES: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254}
_NAMES = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "ft": "feet", "in": "inches"}

SMALLEST_ROOM_M = 1.0
LARGEST_ROOM_M = 100.0
"""Outside of these the longest side of a room is more likely a wrong unit than a room."""

_TYPICAL_ROOM_M = np.array([2.7, 4.0, 6.0])
"""Height and plan of a common room: what the guess of a unit is measured against."""

_MAX_SAMPLES = 100_000


def metres_per_unit(unit: str) -> float:
    """Length of one unit in metres (international foot and inch).

    Raises:
        ConfigError: the unit is none of `Unit`.
    """
    if unit not in _METRES:
        raise ConfigError(f"unit: got {unit!r}; needed is one of {', '.join(get_args(Unit))}.")
    return _METRES[unit]


def robust_extents_m(points_m: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, " 3"]:
    """Widths between the 2.5 % and 97.5 % points of each axis, metres, smallest first.

    Two outliers in a hundred do not move them; a room's walls hold far more of its points than that.
    """
    # Every k-th point is enough for a percentile, and keeps the check below a hundredth of a second.
    sample = points_m[:: max(1, len(points_m) // _MAX_SAMPLES)]
    low, high = np.percentile(sample, [2.5, 97.5], axis=0)
    return np.sort(high - low)


def implausible_unit_note(points_m: Float[np.ndarray, "points 3"], unit: str) -> Note | None:
    """A note where the cloud is smaller or larger than a room, with the unit that would fit.

    Feet taken for metres give a hall, which is plausible: only errors of ten and more show.

    Args:
        points_m: metres, as converted from `unit`; at least one point.
        unit: the unit that was assumed.
    """
    extents_m = robust_extents_m(points_m)
    if SMALLEST_ROOM_M <= extents_m[2] <= LARGEST_ROOM_M:
        return None
    found = " x ".join(f"{extent:.4g}" for extent in extents_m[::-1])
    head = f"Read as {_NAMES[unit]}, the cloud spans {found} m; a room spans 1 to 100 m."
    best = _likeliest_unit(extents_m / _METRES[unit])
    if best == unit:
        return Note("UNIT_IMPLAUSIBLE", f"{head} No other unit fits better: check the file's unit.")
    return Note("UNIT_IMPLAUSIBLE", f"{head} This looks like {_NAMES[best]}: try --unit {best}.")


def _likeliest_unit(extents: Float[np.ndarray, " 3"]) -> str:
    """The unit in which the extents (file units, smallest first) are nearest to a common room's."""

    def misfit(unit: str) -> float:
        sides_m = np.maximum(extents * _METRES[unit], 1e-12)
        # Capped, for a scan of one wall has one extent near zero that says nothing.
        return float(np.minimum(np.abs(np.log(sides_m / _TYPICAL_ROOM_M)), 2.0).sum())

    return min(_METRES, key=misfit)
