"""Holes in the coverage of a room: unseen floor and ceiling with room all around."""

import numpy as np
from jaxtyping import Bool, Float, Int

from .evidence import Evidence

_NOTHING, _WALL, _SURFACE = 0, 1, 2
_SEEN = 0.5
"""A cell or a border counts as seen from half of its area on."""


def enclosed(evidence: Evidence) -> Bool[np.ndarray, "nx ny"]:
    """Cells from which one meets a wall, or floor or ceiling, whichever way one goes.

    A camera that is carried through a room may never look straight up or down in its middle. What is not
    seen there has one cause, while what is not seen beside a room or beyond a door has no end in sight on
    some side. Cells around which there are walls only are pillars, and not counted.
    """
    seen = np.maximum(evidence.ceiling, evidence.floor) >= _SEEN
    met = [
        np.moveaxis(_first_met(np.moveaxis(seen, axis, 0), np.moveaxis(walls, axis, 0), up), 0, axis)
        for axis, walls in enumerate(evidence.walls)
        for up in (False, True)
    ]
    ends = np.all([one != _NOTHING for one in met], axis=0)
    return ends & (seen | np.any([one == _SURFACE for one in met], axis=0))


def _first_met(
    seen: Bool[np.ndarray, "n m"], walls: Float[np.ndarray, "n1 m"], up: bool
) -> Int[np.ndarray, "n m"]:
    """What ends the way from every cell along the first axis."""
    if up:
        return _first_met(seen[::-1], walls[::-1], False)[::-1]
    met = np.full(seen.shape, _NOTHING)
    for k in range(len(seen)):
        beyond = np.where(seen[k - 1], _SURFACE, met[k - 1]) if k else met[0]
        met[k] = np.where(walls[k] >= _SEEN, _WALL, beyond)
    return met
