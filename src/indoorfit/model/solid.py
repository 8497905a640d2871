"""A room as a closed mesh, and its flat faces as polygons; Manhattan frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True)
class RoomSolid:
    """A closed triangle mesh in the Manhattan frame, outward like any solid."""

    vertices_m: Float[np.ndarray, "vertices 3"]
    triangles: Int[np.ndarray, "triangles 3"]
    """Counter-clockwise as seen from outside."""
    planes: Int[np.ndarray, " triangles"]
    """Index of the plane that each triangle lies on."""
    volume_m3: float
    is_closed: bool
    """Watertight and in one piece."""


@dataclass(frozen=True)
class Polygon:
    """One connected flat piece of a room's surface, Manhattan frame."""

    plane: int
    rings_m: tuple[Float[np.ndarray, "_ 3"], ...]
    """Outer ring first, counter-clockwise as seen from inside the room; holes clockwise."""
    triangles: Int[np.ndarray, " n"]
    """The solid's triangles that make it up."""
    area_m2: float
