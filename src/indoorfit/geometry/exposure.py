"""The visible part of one plane."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from .planar import shared_area, union


@dataclass(frozen=True)
class Corner:
    """The triangle between an oblique wall and the corner that it cuts off, seen from above."""

    corners_m: Float[np.ndarray, "3 2"]
    """The wall's two ends, then the corner; Manhattan frame, counter-clockwise or not."""
    floor: bool
    """Whether there is floor and ceiling in the triangle: behind the edge of a notch that is cut off."""

    def contains(
        self, xy_m: Float[np.ndarray, "points 2"], margin_m: float = 0.0
    ) -> Bool[np.ndarray, " points"]:
        """Whether points lie in the triangle, at least `margin_m` from the oblique wall.

        The other two sides are limits of nothing: beyond them the plane goes on, or there is no room.
        """
        inside = np.ones(len(xy_m), bool)
        for start, direction, least_m in zip(self.corners_m, self._inward, (margin_m, 0.0, 0.0), strict=True):
            inside &= (xy_m - start) @ direction >= least_m
        return inside

    def chord_m(self, axis: int, at_m: float) -> tuple[float, float]:
        """The stretch of a line of constant x or y that lies in the triangle; empty (0, 0) if none does."""
        tip_m, far_m = float(self.corners_m[2, axis]), float(self.corners_m[1 - axis, axis])
        share = (at_m - far_m) / (tip_m - far_m)
        # The tip's own lines are sides of the triangle, whatever rounding says.
        if not 0.0 <= share <= 1.0 + 1e-9:
            return 0.0, 0.0
        start_m, side_m = float(self.corners_m[2, 1 - axis]), float(self.corners_m[axis, 1 - axis])
        end_m = start_m + min(share, 1.0) * (side_m - start_m)
        return min(start_m, end_m), max(start_m, end_m)

    def share_of(
        self, start_m: Float[np.ndarray, " 2"], end_m: Float[np.ndarray, " 2"]
    ) -> tuple[float, float]:
        """Where a segment is in the triangle, 0 at its start and 1 at its end; empty (0, 0) if nowhere."""
        low, high = 0.0, 1.0
        for tail_m, inward in zip(self.corners_m, self._inward, strict=True):
            before, after = float((start_m - tail_m) @ inward), float((end_m - tail_m) @ inward)
            if max(before, after) <= 0.0:
                return 0.0, 0.0
            if before < 0.0:
                low = max(low, before / (before - after))
            elif after < 0.0:
                high = min(high, before / (before - after))
        return (low, high) if low < high else (0.0, 0.0)

    @property
    def _inward(self) -> Float[np.ndarray, "3 2"]:
        """Unit vectors across the sides, into the triangle; the first side is the oblique wall."""
        sides = np.roll(self.corners_m, -1, axis=0) - self.corners_m
        turn = np.sign(sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0])
        return turn * np.stack([-sides[:, 1], sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1)[:, None]

    @property
    def area_m2(self) -> float:
        """Of the whole triangle."""
        return self.area_in_m2((-np.inf, -np.inf), (np.inf, np.inf))

    def area_in_m2(self, low_m: tuple[float, float], high_m: tuple[float, float]) -> float:
        """Area of the part of the triangle that lies in a rectangle."""
        ring = self.corners_m
        for axis, (low, high) in enumerate(zip(low_m, high_m, strict=True)):
            ring = _clipped(_clipped(ring, axis, low, 1.0), axis, high, -1.0)
        if len(ring) < 3:
            return 0.0
        x, y = (ring - ring[0]).T
        return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def _clipped(
    ring: Float[np.ndarray, "corners 2"], axis: int, at_m: float, sign: float
) -> Float[np.ndarray, "kept 2"]:
    """The part of a convex polygon on one side of an axis-parallel line (Sutherland and Hodgman 1974)."""
    kept: list[Float[np.ndarray, " 2"]] = []
    beyond = sign * (ring[:, axis] - at_m)
    for k, start in enumerate(ring):
        end, far = ring[(k + 1) % len(ring)], beyond[(k + 1) % len(ring)]
        if beyond[k] >= 0.0:
            kept.append(start)
        if beyond[k] * far < 0.0:
            kept.append(start + beyond[k] / (beyond[k] - far) * (end - start))
    return np.array(kept).reshape(-1, 2)


@dataclass(frozen=True)
class Exposure:
    """The visible part of one plane, as cells of a grid spanned by the other two axes."""

    plane: int
    axis: int
    """In the plane's own axes, as all places here; these are the Manhattan ones for all but oblique planes
    (`Plane.to_own`)."""
    u_m: Float[np.ndarray, " nu1"]
    """Grid lines along the first of the two other axes (x before y before z)."""
    v_m: Float[np.ndarray, " nv1"]
    mask: Bool[np.ndarray, "nu nv"]
    corners: tuple[Corner, ...] = ()
    """Of floors and ceilings: where oblique walls cut corners off."""

    def contains(
        self, points_m: Float[np.ndarray, "points 3"], margin_m: float = 0.0
    ) -> Bool[np.ndarray, " points"]:
        """Whether points, projected onto the plane, lie on it at least `margin_m` from its edges.

        Args:
            points_m: the plane's own axes, metres.
            margin_m: the mask shrinks by this much on every side; negative values let it grow.
        """
        first, second = (axis for axis in range(3) if axis != self.axis)
        u_m, v_m = points_m[:, first], points_m[:, second]
        inside = self._in_cells(u_m, v_m, margin_m)
        for corner in self.corners:
            if corner.floor:
                inside |= corner.contains(points_m[:, :2], margin_m)
            else:
                inside &= ~corner.contains(points_m[:, :2], -margin_m)
        return inside

    def _in_cells(
        self, u_m: Float[np.ndarray, " points"], v_m: Float[np.ndarray, " points"], margin_m: float
    ) -> Bool[np.ndarray, " points"]:
        mask = np.pad(self.mask, 1)
        # The grid is rectilinear, so testing the corners of a square of side 2 * margin suffices
        # unless an arm is thinner than that; the centre then decides as well.
        ways = ((0, 0),) if margin_m == 0.0 else ((-1, -1), (-1, 1), (1, -1), (1, 1), (0, 0))
        i, j = (
            {way: np.searchsorted(lines_m, at_m + way * margin_m, side="right") for way in {*sum(ways, ())}}
            for lines_m, at_m in ((self.u_m, u_m), (self.v_m, v_m))
        )
        tests = [mask[i[way], j[other]] for way, other in ways]
        return (np.logical_or if margin_m < 0.0 else np.logical_and).reduce(tests)

    @property
    def area_m2(self) -> float:
        """Visible area of the plane."""
        area_m2 = float(np.diff(self.u_m) @ self.mask @ np.diff(self.v_m))
        area_m2 += sum(corner.area_m2 for corner in self.corners if corner.floor)
        cut = [corner.corners_m for corner in self.corners if not corner.floor]
        if cut:
            cells = [_rectangle(self.u_m[i : i + 2], self.v_m[j : j + 2]) for i, j in np.argwhere(self.mask)]
            # Of two that meet in the place of a wall, each reaches behind the other.
            area_m2 -= sum(shared_area(union([[ring] for ring in cut]), [cell]) for cell in cells)
        return area_m2


def _rectangle(u_m: Float[np.ndarray, " 2"], v_m: Float[np.ndarray, " 2"]) -> Float[np.ndarray, "4 2"]:
    """Its corners, counter-clockwise."""
    return np.array([[u_m[0], v_m[0]], [u_m[1], v_m[0]], [u_m[1], v_m[1]], [u_m[0], v_m[1]]])
