"""Rooms of named plans: the thesis' L and the shapes that structure searches are judged on."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from indoorfit.errors import ConfigError
from indoorfit.geometry import shape_from_plan
from indoorfit.model import Shape

RoomKind = Literal["box", "L", "U", "X", "T", "Z", "stair"]

_MIN_STEP_M = 0.02
"""Shorter walls than this would vanish in any scan; asking for one is a mistake."""

Rectangle = tuple[float, float, float, float]
"""x from, x to, y from, y to in metres."""


@dataclass(frozen=True)
class _Defaults:
    length_m: float
    width_m: float
    notch_length_m: float
    notch_width_m: float


# L is the thesis' room (table 6-1); U and X are the rooms on which other systems were compared.
_DEFAULTS: dict[str, _Defaults] = {
    "box": _Defaults(5.0, 4.0, 0.0, 0.0),
    "L": _Defaults(5.08, 3.20, 0.33, 1.50),
    "U": _Defaults(6.0, 4.0, 1.6, 1.4),
    "X": _Defaults(6.0, 5.5, 1.5, 1.2),
    "T": _Defaults(6.0, 4.5, 1.8, 1.6),
    "Z": _Defaults(6.0, 4.5, 2.0, 1.5),
    "stair": _Defaults(5.5, 4.5, 2.1, 1.8),
}


def room_shape(
    kind: RoomKind | str,
    *,
    length_m: float | None = None,
    width_m: float | None = None,
    height_m: float = 2.70,
    notch_length_m: float | None = None,
    notch_width_m: float | None = None,
) -> Shape:
    """A room of a named plan.

    Args:
        kind: `box`; `L` one corner notch; `U` a notch in the middle of the long +y side; `X` a cross
            with four different corner notches; `T` two notches at the corners of the +y side; `Z` two
            notches at opposite corners; `stair` a corner notch of three steps (nested cubes).
        length_m: clear extent along x; None takes the default of the kind.
        width_m: clear extent along y.
        height_m: clear extent along z.
        notch_length_m: extent of the (largest) notch along x.
        notch_width_m: extent of the (largest) notch along y.

    Returns:
        Manhattan frame: the room's low corner is the origin, the floor z = 0.

    Raises:
        ConfigError: the kind is unknown, or the notches leave no room.
    """
    if kind not in _DEFAULTS:
        raise ConfigError(
            f"simulate: unknown room '{kind}'; need one of {', '.join(_DEFAULTS)}. Fix: choose one of these."
        )
    base = _DEFAULTS[kind]
    length_m = base.length_m if length_m is None else length_m
    width_m = base.width_m if width_m is None else width_m
    notch = (
        base.notch_length_m if notch_length_m is None else notch_length_m,
        base.notch_width_m if notch_width_m is None else notch_width_m,
    )
    if min(length_m, width_m, height_m) < _MIN_STEP_M:
        raise ConfigError(
            f"simulate {kind}: a room of {length_m:g} x {width_m:g} x {height_m:g} m; every size must be "
            f"at least {_MIN_STEP_M:g} m. Fix: sizes are in metres."
        )
    cuts = _cuts(kind, length_m, width_m, *notch)
    _check(kind, cuts, length_m, width_m)
    return plan_minus_rectangles(length_m, width_m, height_m, cuts)


def plan_minus_rectangles(length_m: float, width_m: float, height_m: float, cuts: list[Rectangle]) -> Shape:
    """The shape of a rectangle from the origin with other rectangles taken away, metres."""
    x_lines = np.unique([0.0, length_m] + [x for cut in cuts for x in cut[:2]])
    y_lines = np.unique([0.0, width_m] + [y for cut in cuts for y in cut[2:]])
    mask = np.ones((len(x_lines) - 1, len(y_lines) - 1), bool)
    for x0, x1, y0, y1 in cuts:
        i0, i1 = np.searchsorted(x_lines, (x0, x1))
        j0, j1 = np.searchsorted(y_lines, (y0, y1))
        mask[i0:i1, j0:j1] = False
    return shape_from_plan(x_lines.tolist(), y_lines.tolist(), [mask], [(0.0, height_m)])


def _cuts(kind: str, length_m: float, width_m: float, nx: float, ny: float) -> list[Rectangle]:
    if kind == "box":
        return []
    if kind == "L":
        return [(length_m - nx, length_m, width_m - ny, width_m)]
    if kind == "U":
        middle = 0.5 * (length_m - nx)
        return [(middle, middle + nx, width_m - ny, width_m)]
    if kind == "T":
        # A quarter shorter on the right, so that the two sides cannot be confused.
        return [
            (0.0, nx, width_m - ny, width_m),
            (length_m - 0.75 * nx, length_m, width_m - ny * 0.9, width_m),
        ]
    if kind == "Z":
        return [(0.0, nx, width_m - ny, width_m), (length_m - 0.8 * nx, length_m, 0.0, 0.9 * ny)]
    if kind == "X":
        return [
            (0.0, nx, 0.0, ny),
            (length_m - 0.8 * nx, length_m, 0.0, 1.2 * ny),
            (0.0, 1.1 * nx, width_m - 0.75 * ny, width_m),
            (length_m - 0.6 * nx, length_m, width_m - 0.9 * ny, width_m),
        ]
    # Three steps of a third each: the union of strips that get shorter as they go up.
    return [
        (length_m - nx * (3 - k) / 3, length_m, width_m - ny * (k + 1) / 3, width_m - ny * k / 3)
        for k in reversed(range(3))
    ]


def _check(kind: str, cuts: list[Rectangle], length_m: float, width_m: float) -> None:
    for x0, x1, y0, y1 in cuts:
        if min(x1 - x0, y1 - y0) < _MIN_STEP_M:
            raise ConfigError(
                f"simulate {kind}: a notch of {x1 - x0:g} x {y1 - y0:g} m; both must be at least "
                f"{_MIN_STEP_M:g} m. Fix: raise notch_length_m and notch_width_m, or ask for a box."
            )
        inside = min(x0, y0, length_m - x1, width_m - y1) >= -1e-9
        if not inside or x1 - x0 > length_m - _MIN_STEP_M or y1 - y0 > width_m - _MIN_STEP_M:
            raise _no_room(kind, length_m, width_m)
    if kind in ("T", "Z", "X"):
        _check_pairs(kind, cuts, length_m, width_m)


def _check_pairs(kind: str, cuts: list[Rectangle], length_m: float, width_m: float) -> None:
    for k, a in enumerate(cuts):
        for b in cuts[k + 1 :]:
            overlap_x = min(a[1], b[1]) - max(a[0], b[0])
            overlap_y = min(a[3], b[3]) - max(a[2], b[2])
            if overlap_x > -_MIN_STEP_M and overlap_y > -_MIN_STEP_M:
                raise _no_room(kind, length_m, width_m)


def _no_room(kind: str, length_m: float, width_m: float) -> ConfigError:
    return ConfigError(
        f"simulate {kind}: the notches leave no connected room in {length_m:g} x {width_m:g} m. "
        "Fix: lower notch_length_m or notch_width_m, or make the room larger."
    )
