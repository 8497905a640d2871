"""Which parts of a shape's planes are surface: the tree of boxes evaluated on its own grid."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.model import Cube, Shape, side_axis, side_sign

from .exposure import Exposure


def box_exposures(shape: Shape) -> dict[int, Exposure]:
    """The visible part of every plane that is a side of some cube; none may have a yaw of its own."""
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
    return found


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
