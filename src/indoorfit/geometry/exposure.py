"""Which parts of a shape's planes are surface: the tree of cubes evaluated on its own grid."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.model import Cube, Shape, side_axis, side_sign


@dataclass(frozen=True)
class Exposure:
    """The visible part of one plane, as cells of a grid spanned by the other two axes."""

    plane: int
    axis: int
    u_m: Float[np.ndarray, " nu1"]
    """Grid lines along the first of the two other axes (x before y before z), Manhattan frame."""
    v_m: Float[np.ndarray, " nv1"]
    mask: Bool[np.ndarray, "nu nv"]

    def contains(
        self, points_m: Float[np.ndarray, "points 3"], margin_m: float = 0.0
    ) -> Bool[np.ndarray, " points"]:
        """Whether points, projected onto the plane, lie on it at least `margin_m` from its edges.

        Args:
            points_m: Manhattan frame, metres.
            margin_m: the mask shrinks by this much on every side; negative values let it grow.
        """
        first, second = (axis for axis in range(3) if axis != self.axis)
        u_m, v_m = points_m[:, first], points_m[:, second]
        if margin_m == 0.0:
            return self._lookup(u_m, v_m)
        # The grid is rectilinear, so testing the corners of a square of side 2 * margin suffices
        # unless an arm is thinner than that; the centre then decides as well.
        tests = [self._lookup(u_m + du, v_m + dv) for du in _ends(margin_m) for dv in _ends(margin_m)]
        if margin_m < 0.0:
            return np.logical_or.reduce([*tests, self._lookup(u_m, v_m)])
        return np.logical_and.reduce([*tests, self._lookup(u_m, v_m)])

    def _lookup(
        self, u_m: Float[np.ndarray, " points"], v_m: Float[np.ndarray, " points"]
    ) -> Bool[np.ndarray, " points"]:
        i = np.searchsorted(self.u_m, u_m, side="right")
        j = np.searchsorted(self.v_m, v_m, side="right")
        return np.pad(self.mask, 1)[i, j]

    @property
    def area_m2(self) -> float:
        """Visible area of the plane."""
        return float(np.diff(self.u_m) @ self.mask @ np.diff(self.v_m))


def _ends(margin_m: float) -> tuple[float, float]:
    return (-abs(margin_m), abs(margin_m))


def exposures(shape: Shape) -> tuple[Exposure, ...]:
    """The visible part of every plane of a shape, in the order of `shape.planes`.

    A plane that has been swallowed by other cubes has an empty mask.
    """
    bounds_m = shape.bounds_m()
    found: dict[int, Exposure] = {}
    for room in shape.rooms:
        tree = _tree(shape, room)
        corners_m = np.concatenate([bounds_m[cube.id] for cube in tree])
        lines_m = [np.unique(corners_m[:, axis]) for axis in range(3)]
        inside = _solid(shape, room, bounds_m, lines_m)
        claimed: dict[tuple[int, float], Bool[np.ndarray, "nu nv"]] = {}
        for cube in tree:
            for k, exposure in _cube_exposures(shape, cube, bounds_m, lines_m, inside).items():
                # Steps may lie over each other and end in one place: what the first has is the first's.
                place = exposure.axis, shape.planes[k].offset_m
                own = exposure.mask & ~claimed.get(place, np.zeros_like(exposure.mask))
                claimed[place] = own | claimed.get(place, own)
                # A platform's side may continue a wall: then one plane bounds two cubes.
                found[k] = replace(exposure, mask=own | found[k].mask if k in found else own)
    return tuple(found[k] for k in range(len(shape.planes)))


def room_of_planes(shape: Shape) -> dict[int, str]:
    """The id of the room cube that each plane belongs to."""
    return {
        plane: room.id
        for room in shape.rooms
        for cube in _tree(shape, room)
        for plane in cube.sides.values()
        if plane is not None
    }


def _tree(shape: Shape, root: Cube) -> list[Cube]:
    cubes = [root]
    for child in shape.children(root.id):
        cubes += _tree(shape, child)
    return cubes


def _cells(bounds_m: Float[np.ndarray, "2 3"], lines_m: list[Float[np.ndarray, " _"]]) -> tuple[slice, ...]:
    """The grid cells that a box covers; its corners are grid lines by construction."""
    index: list[Int[np.ndarray, " 2"]] = [np.searchsorted(lines_m[a], bounds_m[:, a]) for a in range(3)]
    return tuple(slice(int(low), int(high)) for low, high in index)


def _solid(
    shape: Shape,
    cube: Cube,
    bounds_m: dict[str, Float[np.ndarray, "2 3"]],
    lines_m: list[Float[np.ndarray, " _"]],
) -> Bool[np.ndarray, "nx ny nz"]:
    """Cube minus its children, from the leaves (thesis 3.2.5)."""
    solid = np.zeros([len(line) - 1 for line in lines_m], bool)
    solid[_cells(bounds_m[cube.id], lines_m)] = True
    for child in shape.children(cube.id):
        solid &= ~_solid(shape, child, bounds_m, lines_m)
    return solid


def _cube_exposures(
    shape: Shape,
    cube: Cube,
    bounds_m: dict[str, Float[np.ndarray, "2 3"]],
    lines_m: list[Float[np.ndarray, " _"]],
    inside: Bool[np.ndarray, "nx ny nz"],
) -> dict[int, Exposure]:
    found: dict[int, Exposure] = {}
    parent = next((other for other in shape.cubes if other.id == cube.parent), None)
    around = np.ones_like(inside) if parent is None else _solid(shape, parent, bounds_m, lines_m)
    # Beyond the grid there is neither room nor cube, and everything that a room is taken from.
    own = np.pad(_solid(shape, cube, bounds_m, lines_m), 1)
    around = np.pad(around, 1, constant_values=parent is None)
    inside = np.pad(inside, 1)
    for side, index in cube.sides.items():
        if index is None:
            continue
        axis = side_axis(side)
        k = int(np.searchsorted(lines_m[axis], bounds_m[cube.id][int(side_sign(side) > 0), axis]))
        # The surface is where the cube's own solid ends and what it was taken from begins; another cube
        # may have a side at the same place, which must not be claimed.
        inner, outer = (k, k + 1) if side_sign(side) > 0 else (k + 1, k)
        surface = _layer(own, axis, inner) & _layer(around, axis, outer)
        is_room = _layer(inside, axis, inner) != _layer(inside, axis, outer)
        surface = surface & is_room
        u_m, v_m = (lines_m[a] for a in range(3) if a != axis)
        found[index] = Exposure(index, axis, u_m, v_m, surface)
    return found


def _layer(mask: Bool[np.ndarray, "nx ny nz"], axis: int, k: int) -> Bool[np.ndarray, "nu nv"]:
    """The k-th layer of a padded grid along an axis, without the padding of the other two."""
    return np.moveaxis(mask, axis, 0)[k, 1:-1, 1:-1]
