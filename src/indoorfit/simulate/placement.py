"""Where furniture, windows and an imaginary sensor go in a room."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.model import Shape

from .patches import Box, Patches, shape_patches


@dataclass(frozen=True)
class Hole:
    """A rectangle of a plane that returns nothing: a window, or a gap in the coverage."""

    plane: int
    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]
    """Manhattan frame; the extent along the plane's own axis is ignored."""


def free_box(patches: Patches, box: Box, others: tuple[Box, ...] = ()) -> bool:
    """Whether a box lies inside the room, crosses no wall and overlaps no other box."""
    low_m, high_m = np.array(box.low_m), np.array(box.high_m)
    for other in others:
        if (np.minimum(high_m, other.high_m) - np.maximum(low_m, other.low_m) > 0.0).all():
            return False
    # No wall, floor or ceiling may pass through the open interior; and a floor patch lies below it.
    shrink_m = 1e-6
    crosses = (patches.low_m < high_m - shrink_m) & (patches.high_m > low_m + shrink_m)
    if crosses.all(axis=1).any():
        return False
    centre_m = 0.5 * (low_m + high_m)
    return _floor_below(patches, centre_m) is not None


def _floor_below(patches: Patches, point_m: Float[np.ndarray, " 3"]) -> float | None:
    floors = (patches.axis == 2) & (patches.inward > 0) & (patches.low_m[:, 2] <= point_m[2])
    over = ((patches.low_m <= point_m) & (point_m <= patches.high_m))[:, :2].all(axis=1)
    heights_m = patches.low_m[floors & over, 2]
    return float(heights_m.max()) if len(heights_m) else None


def place_furniture(shape: Shape, n_boxes: int, rng: np.random.Generator) -> tuple[Box, ...]:
    """Boxes standing on the floor, two of three with their back to a wall, the others free.

    Args:
        shape: the room, Manhattan frame.
        n_boxes: how many to place; fewer come back where the room is too small for them.
        rng: decides sizes and places.
    """
    patches = shape_patches(shape)
    boxes: list[Box] = []
    for _ in range(60 * n_boxes):
        if len(boxes) == n_boxes:
            break
        box = _against_wall(patches, rng) if rng.random() < 0.67 else _standing_free(patches, rng)
        if free_box(patches, box, tuple(boxes)):
            boxes.append(box)
    return tuple(boxes)


def _against_wall(patches: Patches, rng: np.random.Generator) -> Box:
    walls = np.flatnonzero(patches.axis < 2)
    areas = patches.areas_m2[walls]
    wall = int(rng.choice(walls, p=areas / areas.sum()))
    axis, along = int(patches.axis[wall]), 1 - int(patches.axis[wall])
    # Desks to wardrobes: depth, width and height of what usually stands at a wall.
    depth_m, width_m = rng.uniform(0.3, 0.7), rng.uniform(0.5, 1.8)
    height_m = rng.uniform(0.6, 1.9)
    low_m, high_m = patches.low_m[wall].copy(), patches.high_m[wall].copy()
    start_m = rng.uniform(low_m[along] - 0.5 * width_m, high_m[along] - 0.5 * width_m)
    low_m[along], high_m[along] = start_m, start_m + width_m
    if patches.inward[wall] > 0:
        high_m[axis] += depth_m
    else:
        low_m[axis] -= depth_m
    floor_m = patches.low_m[patches.axis == 2, 2].min()
    low_m[2], high_m[2] = floor_m, floor_m + height_m
    return Box(tuple(low_m.tolist()), tuple(high_m.tolist()))


def _standing_free(patches: Patches, rng: np.random.Generator) -> Box:
    floors = np.flatnonzero((patches.axis == 2) & (patches.inward > 0))
    areas = patches.areas_m2[floors]
    floor = int(rng.choice(floors, p=areas / areas.sum()))
    size_m = np.array([rng.uniform(0.4, 1.4), rng.uniform(0.4, 1.0), rng.uniform(0.4, 1.2)])
    low_m = rng.uniform(patches.low_m[floor], patches.high_m[floor])
    return Box(tuple(low_m.tolist()), tuple((low_m + size_m).tolist()))


def place_windows(shape: Shape, n_windows: int, rng: np.random.Generator) -> tuple[Hole, ...]:
    """Window holes in the largest wall patches, at most one per patch, 0.4 m or more from its edges."""
    patches = shape_patches(shape)
    order = np.argsort(-np.where(patches.axis < 2, patches.areas_m2, 0.0))
    holes: list[Hole] = []
    for wall in order[: max(2 * n_windows, 1)]:
        low_m, high_m = patches.low_m[wall], patches.high_m[wall]
        along = 1 - int(patches.axis[wall])
        room_m = high_m[along] - low_m[along] - 0.8
        if len(holes) == n_windows or patches.axis[wall] == 2 or room_m < 0.5:
            continue
        width_m = rng.uniform(0.5, min(room_m, 1.8))
        start_m = low_m[along] + 0.4 + rng.uniform(0.0, room_m - width_m)
        hole_low_m, hole_high_m = low_m.copy(), high_m.copy()
        hole_low_m[along], hole_high_m[along] = start_m, start_m + width_m
        hole_low_m[2] = low_m[2] + 0.33 * (high_m[2] - low_m[2])
        hole_high_m[2] = low_m[2] + 0.8 * (high_m[2] - low_m[2])
        holes.append(Hole(int(patches.plane[wall]), tuple(hole_low_m.tolist()), tuple(hole_high_m.tolist())))
    return tuple(holes)


def room_centre_m(shape: Shape) -> Float[np.ndarray, " 3"]:
    """The middle of the largest piece of floor, halfway up to the ceiling: a place to stand."""
    patches = shape_patches(shape)
    floor = int(np.argmax(np.where((patches.axis == 2) & (patches.inward > 0), patches.areas_m2, 0.0)))
    centre_m = 0.5 * (patches.low_m[floor] + patches.high_m[floor])
    ceiling_m = patches.high_m[:, 2].max()
    return np.array([centre_m[0], centre_m[1], 0.5 * (centre_m[2] + ceiling_m)])
