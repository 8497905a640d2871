"""The outline of a room's plan: the union of its floors, seen from above."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.geometry import union
from indoorfit.model import Polygon, Shape

from .plan_cells import NOT_ENCLOSED


def outline_rings(shape: Shape, pieces: Sequence[Polygon]) -> tuple[Float[np.ndarray, "_ 2"], ...]:
    """The outer ring counter-clockwise as seen from above, then those of pillars; the lowest corner first.

    Args:
        shape: the grammar.
        pieces: the polygons of one room.

    Raises:
        InputError: no floor is left of it.
    """
    floors = [p for p in pieces if shape.planes[p.plane].axis == 2 and shape.planes[p.plane].outward < 0]
    if not floors:
        raise InputError(NOT_ENCLOSED)
    corners_m = np.concatenate([ring[:, :2] for piece in floors for ring in piece.rings_m])
    whole = union([[ring[:, :2] for ring in piece.rings_m] for piece in floors])
    rings = [_begun(_straightened(_snapped(ring, corners_m))) for ring in whole]
    return tuple(sorted(rings, key=lambda ring: -float(np.ptp(ring, axis=0).sum())))


def _snapped(
    ring_m: Float[np.ndarray, "corners 2"], corners_m: Float[np.ndarray, "known 2"]
) -> Float[np.ndarray, "corners 2"]:
    """The corners that the floors have: the union rounds them, and others rest on their numbers."""
    distances_m = np.linalg.norm(ring_m[:, None] - corners_m[None], axis=2)
    return corners_m[np.argmin(distances_m, axis=1)]


def _straightened(ring_m: Float[np.ndarray, "corners 2"]) -> Float[np.ndarray, "kept 2"]:
    """Without corners in the middle of a straight side."""
    before, after = ring_m - np.roll(ring_m, 1, axis=0), np.roll(ring_m, -1, axis=0) - ring_m
    turns = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return ring_m[turns > 1e-9 * lengths]


def _begun(ring_m: Float[np.ndarray, "corners 2"]) -> Float[np.ndarray, "corners 2"]:
    return np.roll(ring_m, -min(range(len(ring_m)), key=lambda k: tuple(ring_m[k])), axis=0)
