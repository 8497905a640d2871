"""Which parts of a shape's planes are surface: boxes first, then the corners that oblique walls cut off."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.model import Cube, Plane, Shape

from .boxes import box_exposures, room_of_planes
from .exposure import Corner, Exposure


def exposures(shape: Shape) -> tuple[Exposure, ...]:
    """The visible part of every plane of a shape, in the order of `shape.planes`.

    A plane that has been swallowed by other cubes has an empty mask.
    """
    found = box_exposures(shape.squared)
    homes = room_of_planes(shape) if shape.oblique else {}
    corners = {cube.front: corner_of(shape, cube) for cube in shape.cubes if cube.front is not None}
    for cube in shape.cubes:
        if cube.between is None or cube.front is None:
            continue
        corner = corners[cube.front]
        found[cube.front] = _front(shape, cube, corner, found, homes)
        for k, other in corners.items():
            # Two that meet in the place of a wall each end where the other begins.
            if k != cube.front and homes[k] == homes[cube.front] and not other.floor:
                ends_m = _behind(shape.planes[cube.front], corner, other)
                found[cube.front] = _shortened(found[cube.front], ends_m)
        for k, other in found.items():
            if homes.get(k) != homes[cube.front] or shape.planes[k].oblique:
                continue
            if other.axis < 2:
                found[k] = _shortened(other, corner.chord_m(other.axis, shape.planes[k].offset_m))
            elif _at_corner(other, corner):
                found[k] = replace(other, corners=(*other.corners, corner))
    return tuple(found[k] for k in range(len(shape.planes)))


def corner_of(shape: Shape, cube: Cube) -> Corner:
    """The triangle between an oblique wall and the corner that it cuts off."""
    front, between = cube.front, cube.between
    assert front is not None, "only a cube with a yaw of its own cuts a corner off"
    assert between is not None, "only a cube with a yaw of its own cuts a corner off"
    ends_m = [shape.corner_m(front, other) for other in between]
    return Corner(np.stack([*ends_m, shape.corner_m(*between)]), cube.sides["+x"] is not None)


def _at_corner(level: Exposure, corner: Corner) -> bool:
    """Whether a floor or ceiling lies where the triangle is, or before it where the triangle adds to it."""
    if corner.floor:
        place_m = _past(corner, np.append(corner.corners_m[2], 0.0))
        return bool(replace(level, corners=()).contains(place_m[None]).any())
    u_m, v_m = level.u_m.tolist(), level.v_m.tolist()
    # Several levels may meet behind one wall.
    return any(
        corner.area_in_m2((u_m[i], v_m[j]), (u_m[i + 1], v_m[j + 1])) > 0.0
        for i, j in np.argwhere(level.mask).tolist()
    )


def _behind(plane: Plane, corner: Corner, other: Corner) -> tuple[float, float]:
    """The stretch of an oblique wall, along it, that lies in the corner that another one cuts off."""
    own_m = plane.to_own(np.column_stack([corner.corners_m, np.zeros(3)]))[:2, 1]
    ends_m = [own_m[0] + share * (own_m[1] - own_m[0]) for share in other.share_of(*corner.corners_m[:2])]
    return float(min(ends_m)), float(max(ends_m))


def _shortened(wall: Exposure, ends_m: tuple[float, float]) -> Exposure:
    """A wall without the stretch between two places on it."""
    low_m, high_m = ends_m
    if not low_m < high_m:
        return wall
    u_m, mask = _refined(wall.u_m, wall.mask, np.array([low_m, high_m]))
    middles_m = 0.5 * (u_m[1:] + u_m[:-1])
    return replace(wall, u_m=u_m, mask=mask & ~((middles_m > low_m) & (middles_m < high_m))[:, None])


def _refined(
    u_m: Float[np.ndarray, " nu1"], mask: Bool[np.ndarray, "nu nv"], further_m: Float[np.ndarray, " n"]
) -> tuple[Float[np.ndarray, " finer1"], Bool[np.ndarray, "finer nv"]]:
    inner_m = further_m[(further_m > u_m[0]) & (further_m < u_m[-1])]
    finer_m = np.union1d(u_m, inner_m)
    middles_m = 0.5 * (finer_m[1:] + finer_m[:-1])
    return finer_m, mask[np.searchsorted(u_m, middles_m) - 1]


def _front(
    shape: Shape, cube: Cube, corner: Corner, found: dict[int, Exposure], homes: dict[int, str]
) -> Exposure:
    """The oblique wall itself, in its own axes: between its ends, as high as the walls that it runs between.

    Where steps meet it, it is seen above them: on each stretch as the walls are that it took the corner from.
    """
    assert cube.front is not None, "only a cube with a yaw of its own has a front"
    plane = shape.planes[cube.front]
    room = next(other for other in shape.rooms if other.id == homes[cube.front])
    bounds_m = shape.squared.bounds_m()
    own_m = plane.to_own(np.column_stack([corner.corners_m, np.zeros(3)]))
    ends_m = np.sort(own_m[:2, 1])
    boxes_m = np.concatenate([box for box in bounds_m.values()])
    crossings_m = _crossings(boxes_m, corner.corners_m[0], corner.corners_m[1], own_m[:2, 1])
    u_m = np.unique(np.concatenate([ends_m, crossings_m]))
    v_m = np.unique(boxes_m[:, 2])
    # Just before the wall: for a notch that is still room, for the edge of a notch beyond the notch's wall.
    before_m = plane.offset_m - 1e-6
    middles_m = 0.5 * (u_m[1:] + u_m[:-1])
    mask = np.zeros((len(u_m) - 1, len(v_m) - 1), bool)
    for j, z_m in enumerate(0.5 * (v_m[1:] + v_m[:-1])):
        places_m = np.column_stack(
            [np.full(len(middles_m), before_m), middles_m, np.full(len(middles_m), z_m)]
        )
        if corner.floor:
            # The notch was solid here; the room beyond its edge tells how high the opened corner is.
            beyond_m = np.append(corner.corners_m[2], z_m)
            places_m = np.tile(plane.to_own(_past(corner, beyond_m)[None]), (len(middles_m), 1))
        mask[:, j] = _inside(shape.squared, room, bounds_m, plane.from_own(places_m))
    return Exposure(cube.front, 0, u_m, v_m, mask)


def _past(corner: Corner, apex_m: Float[np.ndarray, " 3"]) -> Float[np.ndarray, " 3"]:
    """A place a little further out than the tip of the triangle."""
    away = corner.corners_m[2] - corner.corners_m[:2].mean(axis=0)
    return apex_m + 1e-6 * np.append(away / np.linalg.norm(away), 0.0)


def _crossings(
    boxes_m: Float[np.ndarray, "corners 3"],
    start_m: Float[np.ndarray, " 2"],
    end_m: Float[np.ndarray, " 2"],
    along_m: Float[np.ndarray, " 2"],
) -> Float[np.ndarray, " n"]:
    """Where an oblique wall crosses the lines of the boxes' sides, along the wall."""
    shares = [(np.unique(boxes_m[:, axis]) - start_m[axis]) / (end_m - start_m)[axis] for axis in (0, 1)]
    inner = np.concatenate(shares)
    inner = inner[(inner > 1e-9) & (inner < 1.0 - 1e-9)]
    return along_m[0] + inner * (along_m[1] - along_m[0])


def _inside(
    shape: Shape,
    cube: Cube,
    bounds_m: dict[str, Float[np.ndarray, "2 3"]],
    points_m: Float[np.ndarray, "points 3"],
) -> Bool[np.ndarray, " points"]:
    """Whether points lie in a cube minus its children."""
    low_m, high_m = bounds_m[cube.id]
    inside = np.all((points_m > low_m) & (points_m < high_m), axis=1)
    for child in shape.children(cube.id):
        inside &= ~_inside(shape, child, bounds_m, points_m)
    return inside
