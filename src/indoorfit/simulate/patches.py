"""Axis-aligned rectangles: the exposed surface of a shape and of boxes, ready to be sampled."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.geometry import exposures
from indoorfit.model import Shape


@dataclass(frozen=True)
class Box:
    """An axis-aligned box in the Manhattan frame, metres."""

    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]

    def contains(
        self, points_m: Float[np.ndarray, "points 3"], margin_m: float
    ) -> Bool[np.ndarray, " points"]:
        """Which points lie in the box grown by a margin."""
        low, high = np.array(self.low_m) - margin_m, np.array(self.high_m) + margin_m
        return np.all((points_m >= low) & (points_m <= high), axis=1)


@dataclass(frozen=True)
class Patches:
    """Rectangles perpendicular to an axis, Manhattan frame, metres."""

    axis: Int[np.ndarray, " patches"]
    inward: Int[np.ndarray, " patches"]
    """+1 or -1: the direction along the axis in which the room lies."""
    low_m: Float[np.ndarray, "patches 3"]
    high_m: Float[np.ndarray, "patches 3"]
    """`low_m` and `high_m` agree along the axis."""
    plane: Int[np.ndarray, " patches"]
    """Index in the shape's planes; -1 for furniture."""
    surface: Int[np.ndarray, " patches"]
    """One number for each differently coloured surface."""

    @property
    def areas_m2(self) -> Float[np.ndarray, " patches"]:
        """Area of each rectangle."""
        size_m = self.high_m - self.low_m
        size_m[np.arange(len(size_m)), self.axis] = 1.0
        return size_m.prod(axis=1)

    def select(self, keep: np.ndarray) -> "Patches":
        """The chosen patches, by mask or index."""
        return Patches(
            self.axis[keep], self.inward[keep], self.low_m[keep], self.high_m[keep],
            self.plane[keep], self.surface[keep],
        )  # fmt: skip


def shape_patches(shape: Shape) -> Patches:
    """The exposed surface of a shape, one patch per grid cell."""
    rows = []
    for exposure in exposures(shape):
        plane = shape.planes[exposure.plane]
        for i, j in np.argwhere(exposure.mask):
            low_m = np.insert([exposure.u_m[i], exposure.v_m[j]], plane.axis, plane.offset_m)
            high_m = np.insert([exposure.u_m[i + 1], exposure.v_m[j + 1]], plane.axis, plane.offset_m)
            rows.append((plane.axis, -plane.outward, low_m, high_m, exposure.plane, exposure.plane))
    return _patches(rows)


def box_patches(boxes: tuple[Box, ...], room: Patches, first_surface: int) -> Patches:
    """The free sides of furniture boxes: not those that touch a plane of the room.

    Args:
        boxes: furniture, Manhattan frame.
        room: the room's patches; a side that lies in one of their planes and within 1 mm of a patch is
            not part of any visible surface.
        first_surface: surface number of the first box.
    """
    rows = []
    for k, box in enumerate(boxes):
        for axis in range(3):
            for sign, corner in ((-1, box.low_m), (1, box.high_m)):
                low_m, high_m = np.array(box.low_m), np.array(box.high_m)
                low_m[axis] = high_m[axis] = corner[axis]
                if not _touches(room, axis, low_m, high_m):
                    rows.append((axis, sign, low_m, high_m, -1, first_surface + k))
    return _patches(rows)


def join(a: Patches, b: Patches) -> Patches:
    """Both lists of patches, one after the other."""
    return Patches(
        *(
            np.concatenate([getattr(a, name), getattr(b, name)])
            for name in ("axis", "inward", "low_m", "high_m", "plane", "surface")
        )
    )


def _touches(
    room: Patches, axis: int, low_m: Float[np.ndarray, " 3"], high_m: Float[np.ndarray, " 3"]
) -> bool:
    touching_m = 1e-3
    centre_m = 0.5 * (low_m + high_m)
    near = (room.axis == axis) & (np.abs(room.low_m[:, axis] - low_m[axis]) < touching_m)
    covered = (room.low_m <= centre_m + touching_m) & (centre_m - touching_m <= room.high_m)
    return bool((near & covered.all(axis=1)).any())


def _patches(rows: list[tuple]) -> Patches:
    if not rows:
        none = np.zeros(0, int)
        return Patches(none, none, np.zeros((0, 3)), np.zeros((0, 3)), none, none)
    axis, inward, low_m, high_m, plane, surface = zip(*rows, strict=True)
    return Patches(
        np.array(axis, int), np.array(inward, int), np.array(low_m, float), np.array(high_m, float),
        np.array(plane, int), np.array(surface, int),
    )  # fmt: skip
