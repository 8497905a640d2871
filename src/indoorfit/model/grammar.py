"""The cube grammar: ``shape ::= cube minus { shape }`` (thesis 3.2.4 and 3.2.5).

A shape is a tree of cubes and a list of planes. Every side of a cube is either one of the planes or
open ("infinite" in the thesis). The planes carry the parameters, so two cubes share a parameter only
where they share a physical wall. All coordinates are in the Manhattan frame.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

Side = Literal["-x", "+x", "-y", "+y", "-z", "+z"]
"""A side of a cube, named by its direction as seen from the cube's centre."""

SIDES: tuple[Side, ...] = ("-x", "+x", "-y", "+y", "-z", "+z")

Role = Literal["room", "notch", "pillar", "step", "platform", "beam", "opening", "part"]
"""What a cube stands for. A `part` is a nested cube: taken away from a notch, hence room again.
Cubes with one free z-face: a `beam` hangs from the ceiling between two sides of its own, a `platform`
stands on the floor with two or more, and a `step` is a level of floor or ceiling that ends at walls."""

PlaneStatus = Literal["observed", "inferred"]

FaceClass = Literal["front", "back", "left", "right", "floor", "ceiling"]

OPEN_MARGIN_M = 1.0
"""How far an open side lies outside its parent. It carries no parameter and leaves no trace in the
solid; a metre keeps it far from every tolerance without hurting the conditioning of the boolean."""


def side_axis(side: Side) -> int:
    """0, 1 or 2 for x, y or z."""
    return "xyz".index(side[1])


def side_sign(side: Side) -> int:
    """+1 or -1."""
    return 1 if side[0] == "+" else -1


@dataclass(frozen=True)
class Plane:
    """One flat piece of wall, floor or ceiling: the points q with ``q[axis] == offset_m``."""

    axis: int
    """0, 1 or 2: the Manhattan axis that the plane is perpendicular to."""
    outward: int
    """+1 or -1: the direction along `axis` that leaves the room through this plane."""
    offset_m: float
    """Manhattan frame, metres."""
    status: PlaneStatus = "observed"
    """`inferred` planes have no points of their own."""

    @property
    def face_class(self) -> FaceClass:
        """The thesis' name for the plane, by its outward direction (Table 3-1)."""
        names: tuple[FaceClass, ...] = ("left", "right", "back", "front", "floor", "ceiling")
        return names[2 * self.axis + (self.outward > 0)]


@dataclass(frozen=True)
class Cube:
    """A box of the grammar; which planes bound it, not where they are."""

    id: str
    """``cube-0``, ``cube-1``, ... in the order of the shape."""
    role: Role
    parent: str | None
    """The cube that this one is taken away from; None for a room."""
    sides: Mapping[Side, int | None]
    """For each of the six sides the index of its plane in the shape, or None where it is open."""

    @property
    def open_sides(self) -> tuple[Side, ...]:
        """The sides that lie beyond the parent."""
        return tuple(side for side in SIDES if self.sides[side] is None)


@dataclass(frozen=True)
class Shape:
    """A whole model: one tree of cubes per room, over a common list of planes."""

    planes: tuple[Plane, ...]
    cubes: tuple[Cube, ...]
    """Parents before their children."""

    @property
    def offsets_m(self) -> Float[np.ndarray, " planes"]:
        """The plane offsets as a vector, Manhattan frame."""
        return np.array([plane.offset_m for plane in self.planes])

    def with_offsets(self, offsets_m: Float[np.ndarray, " planes"]) -> "Shape":
        """The same tree over moved planes."""
        planes = tuple(
            replace(plane, offset_m=float(offset))
            for plane, offset in zip(self.planes, offsets_m, strict=True)
        )
        return replace(self, planes=planes)

    def children(self, cube_id: str) -> tuple[Cube, ...]:
        """The cubes taken away from this one."""
        return tuple(cube for cube in self.cubes if cube.parent == cube_id)

    @property
    def rooms(self) -> tuple[Cube, ...]:
        """The roots of the trees."""
        return tuple(cube for cube in self.cubes if cube.parent is None)

    def bounds_m(self) -> dict[str, Float[np.ndarray, "2 3"]]:
        """Low and high corner of every cube, open sides set a margin outside the parent.

        Returns:
            by cube id, Manhattan frame, metres. Equal planes give bitwise equal numbers, which the
            boolean operations rely on.
        """
        bounds: dict[str, Float[np.ndarray, "2 3"]] = {}
        for cube in self.cubes:
            corners = np.empty((2, 3))
            for side, plane in cube.sides.items():
                end = int(side_sign(side) > 0)
                axis = side_axis(side)
                if plane is not None:
                    corners[end, axis] = self.planes[plane].offset_m
                else:
                    assert cube.parent is not None, "a room has no open side"
                    outer = bounds[cube.parent][end, axis]
                    corners[end, axis] = outer + side_sign(side) * OPEN_MARGIN_M
            bounds[cube.id] = corners
        return bounds
