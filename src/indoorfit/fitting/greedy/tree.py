"""The cube grammar while it grows."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from indoorfit.model import SIDES, Cube, Plane, PlaneStatus, Role, Shape, Side, side_axis, side_sign


@dataclass
class CubeTree:
    """Collects planes and cubes, parents before children; mutable while the fit runs."""

    planes: list[Plane] = field(default_factory=list)
    cubes: list[Cube] = field(default_factory=list)
    depths: dict[str, int] = field(default_factory=dict)

    def add_room(self, bounds_m: Float[np.ndarray, "2 3"], status: Mapping[Side, PlaneStatus]) -> str:
        """The largest cube; its six planes are the only ones of floor and ceiling (thesis 3.2)."""
        sides: dict[Side, int | None] = {}
        for side in SIDES:
            axis, sign = side_axis(side), side_sign(side)
            sides[side] = self._plane(Plane(axis, sign, float(bounds_m[int(sign > 0), axis]), status[side]))
        return self._cube("room", None, sides)

    def add_part(self, parent: str, offsets_m: Mapping[Side, float]) -> str:
        """A cube to be taken away from `parent`, bounded by walls on some sides and open on the others.

        Floor and ceiling are the first cube's: the z scale is preserved (3.2.5), and as every cube of the
        tree has it, the z sides are open, which gives the same solid without a second plane on top of one.
        """
        depth = self.depths[parent] + 1
        sides: dict[Side, int | None] = dict.fromkeys(SIDES)
        for side, offset_m in offsets_m.items():
            # Inside and outside change places with every level of the tree.
            outward = side_sign(side) * (-1 if depth % 2 else 1)
            sides[side] = self._plane(Plane(side_axis(side), outward, offset_m))
        role: Role = "part" if depth % 2 == 0 else "pillar" if len(offsets_m) == 4 else "notch"
        return self._cube(role, parent, sides)

    def shape(self) -> Shape:
        """The tree as it stands."""
        return Shape(tuple(self.planes), tuple(self.cubes))

    def _plane(self, plane: Plane) -> int:
        self.planes.append(plane)
        return len(self.planes) - 1

    def _cube(self, role: Role, parent: str | None, sides: dict[Side, int | None]) -> str:
        cube = Cube(f"cube-{len(self.cubes)}", role, parent, sides)
        self.cubes.append(cube)
        self.depths[cube.id] = 0 if parent is None else self.depths[parent] + 1
        return cube.id
