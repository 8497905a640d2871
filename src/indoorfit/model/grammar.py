"""The cube grammar: ``shape ::= cube minus { shape }`` (thesis 3.2.4 and 3.2.5).

A shape is a tree of cubes and a list of planes. Every side of a cube is either one of the planes or
open ("infinite" in the thesis). The planes carry the parameters, so two cubes share a parameter only
where they share a physical wall. All coordinates are in the Manhattan frame.

A wall across a corner is the front of a cube with a yaw of its own (an Atlanta world: Schindler and Dellaert
2004). It is as wide and as deep as the corner between the two walls that it runs between.
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

BEYOND_M = 0.02
"""How far the open sides of a cube with a yaw of its own lie beyond the walls of its corner: less than the
thinnest notch, of which there is more behind such a wall than that."""


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
    yaw_rad: float = 0.0
    """How far the plane's own axes are turned about z; other than 0 only for oblique walls, which are
    perpendicular to their own x axis and have the room before them (`axis` 0, `outward` +1)."""
    doubt_m: float = 0.0
    """Standard uncertainty of the place of an inferred plane, as far as it is a guess: 0 for those that
    stand where floor or ceiling end."""

    @property
    def oblique(self) -> bool:
        """Whether the plane has a direction of its own."""
        return self.yaw_rad != 0.0

    @property
    def normal(self) -> Float[np.ndarray, " 3"]:
        """Unit vector along the plane's axis, Manhattan frame."""
        if self.oblique:
            return np.array([np.cos(self.yaw_rad), np.sin(self.yaw_rad), 0.0])
        return np.eye(3)[self.axis]

    @property
    def turn_normal(self) -> Float[np.ndarray, " 3"]:
        """Derivative of an oblique plane's normal with respect to its yaw."""
        return np.array([-np.sin(self.yaw_rad), np.cos(self.yaw_rad), 0.0])

    @property
    def R_own_manhattan(self) -> Float[np.ndarray, "3 3"]:
        """From the Manhattan axes to the plane's own."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    def to_own(self, points_m: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
        """Points from the Manhattan axes to the plane's own: the same array for all but oblique planes."""
        return points_m @ self.R_own_manhattan.T if self.oblique else points_m

    def from_own(self, points_m: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 3"]:
        """Points from the plane's own axes to the Manhattan ones."""
        return points_m @ self.R_own_manhattan if self.oblique else points_m

    @property
    def face_class(self) -> FaceClass:
        """The thesis' name for the plane, by its outward direction (Table 3-1), or the nearest to it."""
        names: tuple[FaceClass, ...] = ("left", "right", "back", "front", "floor", "ceiling")
        if self.oblique:
            return (names[1], names[3], names[0], names[2])[round(self.yaw_rad / (0.5 * np.pi)) % 4]
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
    between: tuple[int, int] | None = None
    """Of a cube with a yaw of its own: the planes of the two walls whose corner it cuts off."""

    @property
    def front(self) -> int | None:
        """The oblique plane of a cube with a yaw of its own; None for all others."""
        if self.between is None:
            return None
        return self.sides["-x"] if self.sides["-x"] is not None else self.sides["+x"]

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

    @property
    def oblique(self) -> tuple[int, ...]:
        """Indices of the planes with a yaw of their own."""
        return tuple(k for k, plane in enumerate(self.planes) if plane.oblique)

    @property
    def parameters(self) -> Float[np.ndarray, " parameters"]:
        """All plane offsets (m), then the yaws of the oblique planes (rad)."""
        return np.append(self.offsets_m, [self.planes[k].yaw_rad for k in self.oblique])

    def yaw_parameter(self, plane: int) -> int:
        """Where in `parameters` the yaw of an oblique plane stands."""
        return len(self.planes) + self.oblique.index(plane)

    def with_parameters(self, parameters: Float[np.ndarray, " parameters"]) -> "Shape":
        """The same tree over moved and turned planes."""
        planes = list(self.with_offsets(parameters[: len(self.planes)]).planes)
        for k, yaw_rad in zip(self.oblique, parameters[len(planes) :], strict=True):
            planes[k] = replace(planes[k], yaw_rad=float(yaw_rad))
        return replace(self, planes=tuple(planes))

    @property
    def squared(self) -> "Shape":
        """The same rooms with square corners in place of oblique walls; the planes keep their numbers."""
        if not self.oblique:
            return self
        return replace(self, cubes=tuple(cube for cube in self.cubes if cube.between is None))

    def corner_m(self, first: int, second: int) -> Float[np.ndarray, " 2"]:
        """Where two upright planes that are not parallel meet, x and y."""
        ends = (self.planes[first], self.planes[second])
        return np.linalg.solve(
            np.stack([plane.normal[:2] for plane in ends]), np.array([plane.offset_m for plane in ends])
        )

    def yaw_of(self, cube: Cube) -> float:
        """How far a cube's own axes are turned about z; 0 for all but those behind oblique walls."""
        return 0.0 if cube.front is None else self.planes[cube.front].yaw_rad

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
            by cube id, metres, Manhattan frame; for a cube with a yaw of its own (`yaw_of`) that frame turned
            by it. Equal planes give bitwise equal numbers, which the boolean operations rely on.
        """
        bounds: dict[str, Float[np.ndarray, "2 3"]] = {}
        for cube in self.cubes:
            if cube.between is not None:
                assert cube.parent is not None, "a room has no yaw of its own"
                bounds[cube.id] = self._behind_oblique_m(cube, bounds[cube.parent])
                continue
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

    def _behind_oblique_m(self, cube: Cube, parent_m: Float[np.ndarray, "2 3"]) -> Float[np.ndarray, "2 3"]:
        """The box behind an oblique wall, in its own axes: it holds the corner that the wall cuts off.

        Its open sides are beyond the two walls of that corner, by too little to reach anything else.
        """
        front, between = cube.front, cube.between
        assert front is not None, "an oblique cube has a front"
        assert between is not None, "an oblique cube lies between two walls"
        plane = self.planes[front]
        xy_m = [self.corner_m(front, other) for other in between] + [self.corner_m(*between)]
        own_m = plane.to_own(np.column_stack([xy_m, np.zeros(3)]))
        corners = np.array([own_m.min(axis=0) - BEYOND_M, own_m.max(axis=0) + BEYOND_M])
        corners[0 if cube.sides["-x"] is not None else 1, 0] = plane.offset_m
        corners[:, 2] = parent_m[:, 2] + np.array([-OPEN_MARGIN_M, OPEN_MARGIN_M])
        return corners
