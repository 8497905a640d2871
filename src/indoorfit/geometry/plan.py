"""From a rectilinear plan to a tree of cubes (thesis 3.2.4, 3.2.5, figure 3-2)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from indoorfit.model import Cube, Plane, PlaneStatus, Role, Shape, Side

_PLAN_SIDES: tuple[Side, ...] = ("-x", "+x", "-y", "+y")


def shape_from_plan(
    x_lines_m: Sequence[float],
    y_lines_m: Sequence[float],
    rooms: Sequence[Bool[np.ndarray, "nx ny"]],
    z_ranges_m: Sequence[tuple[float, float]],
) -> Shape:
    """The cube grammar of rooms that are unions of cells of a rectangular grid.

    The room is the bounding box of its cells; each connected piece of what is missing becomes a notch
    (a pillar if it touches no outer side), and what is missing from a notch's own bounding box becomes
    a `part`, and so on until nothing is missing: "largest first, then the complement, recursively".

    Args:
        x_lines_m: nx + 1 increasing grid lines, Manhattan frame, metres.
        y_lines_m: ny + 1 increasing grid lines.
        rooms: one mask of cells per room, each connected and not empty.
        z_ranges_m: floor and ceiling height of each room.

    Returns:
        a shape with one plane for every wall, floor and ceiling; all planes `observed`.
    """
    builder = _ShapeBuilder(np.asarray(x_lines_m, float), np.asarray(y_lines_m, float))
    for mask, z_range_m in zip(rooms, z_ranges_m, strict=True):
        builder.add_room(np.asarray(mask, bool), z_range_m)
    return Shape(tuple(builder.planes), tuple(builder.cubes))


class _ShapeBuilder:
    """Collects planes and cubes while the plan is carved up."""

    def __init__(self, x_lines_m: Float[np.ndarray, " nx1"], y_lines_m: Float[np.ndarray, " ny1"]):
        self.lines_m = (x_lines_m, y_lines_m)
        self.planes: list[Plane] = []
        self.cubes: list[Cube] = []

    def add_room(self, mask: Bool[np.ndarray, "nx ny"], z_range_m: tuple[float, float]) -> None:
        """Append one room and everything taken away from it."""
        floor = self._plane(2, -1, z_range_m[0])
        ceiling = self._plane(2, 1, z_range_m[1])
        self._carve(mask, parent=None, parent_box=None, depth=0, z_planes=(floor, ceiling))

    def _plane(self, axis: int, outward: int, offset_m: float, status: PlaneStatus = "observed") -> int:
        self.planes.append(Plane(axis, outward, float(offset_m), status))
        return len(self.planes) - 1

    def _carve(
        self,
        mask: Bool[np.ndarray, "nx ny"],
        parent: str | None,
        parent_box: tuple[int, int, int, int] | None,
        depth: int,
        z_planes: tuple[int | None, int | None],
    ) -> None:
        box = bounding_box(mask)
        sides: dict[Side, int | None] = {}
        for k, side in enumerate(_PLAN_SIDES):
            if parent_box is not None and box[k] == parent_box[k]:
                sides[side] = None
                continue
            sign = 1 if side[0] == "+" else -1
            # Inside and outside change places with every level of the tree.
            outward = sign if depth % 2 == 0 else -sign
            sides[side] = self._plane(k // 2, outward, self.lines_m[k // 2][box[k]])
        sides["-z"], sides["+z"] = z_planes
        cube = Cube(f"cube-{len(self.cubes)}", _role(depth, sides), parent, sides)
        self.cubes.append(cube)
        window = np.zeros_like(mask)
        window[box[0] : box[1], box[2] : box[3]] = True
        for missing in components(window & ~mask):
            self._carve(missing, cube.id, box, depth + 1, (None, None))


def bounding_box(mask: Bool[np.ndarray, "nx ny"]) -> tuple[int, int, int, int]:
    """First and last-plus-one occupied index along x, then along y."""
    along_x = np.flatnonzero(mask.any(axis=1))
    along_y = np.flatnonzero(mask.any(axis=0))
    return int(along_x[0]), int(along_x[-1]) + 1, int(along_y[0]), int(along_y[-1]) + 1


def components(mask: Bool[np.ndarray, "nx ny"]) -> list[Bool[np.ndarray, "nx ny"]]:
    """Edge-connected pieces, ordered by their first cell, so that ids are stable."""
    labels, n = ndimage.label(mask)  # pyright: ignore[reportGeneralTypeIssues]
    return [labels == k for k in range(1, n + 1)]


def _role(depth: int, sides: dict[Side, int | None]) -> Role:
    if depth == 0:
        return "room"
    if depth % 2 == 0:
        return "part"
    enclosed = all(sides[side] is not None for side in _PLAN_SIDES)
    return "pillar" if enclosed else "notch"
