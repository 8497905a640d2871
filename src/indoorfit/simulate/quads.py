"""Rectangles in any pose, as arrays: what rays are cast against."""

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Bool, Float, Int

Vector = tuple[float, float, float] | Float[np.ndarray, " 3"]


@dataclass(frozen=True)
class Quads:
    """Rectangles ``corner + u * along + v * across`` with 0 <= u <= length and 0 <= v <= width.

    Only the side that the normal points to is seen. Manhattan frame, metres.
    """

    corner_m: Float[np.ndarray, "quads 3"]
    along: Float[np.ndarray, "quads 3"]
    across: Float[np.ndarray, "quads 3"]
    """Unit vectors, perpendicular to each other."""
    size_m: Float[np.ndarray, "quads 2"]
    """Length and width."""
    normal: Float[np.ndarray, "quads 3"]
    plane: Int[np.ndarray, " quads"]
    """Index in the shape's planes, or -1."""
    surface: Int[np.ndarray, " quads"]
    """Index in the scene's surfaces."""
    glass: Bool[np.ndarray, " quads"]

    @property
    def n(self) -> int:
        """Number of rectangles."""
        return len(self.plane)

    def select(self, keep: Bool[np.ndarray, " quads"] | Int[np.ndarray, " kept"]) -> "Quads":
        """The chosen rectangles."""
        return Quads(*(getattr(self, field.name)[keep] for field in fields(self)))

    def corners_m(self) -> Float[np.ndarray, "quads 4 3"]:
        """All four corners."""
        u = self.along * self.size_m[:, :1]
        v = self.across * self.size_m[:, 1:]
        return self.corner_m[:, None] + np.stack([0.0 * u, u, v, u + v], axis=1)


class QuadList:
    """Collects rectangles while a scene is built."""

    def __init__(self) -> None:
        self._rows: list[tuple] = []

    def add(
        self,
        corner_m: Vector,
        u_m: Vector,
        v_m: Vector,
        towards: Vector,
        surface: int,
        plane: int = -1,
        glass: bool = False,
    ) -> None:
        """Append a rectangle by a corner and two perpendicular edges, seen from where `towards` points."""
        u, v = np.asarray(u_m, float), np.asarray(v_m, float)
        size_m = np.array([np.linalg.norm(u), np.linalg.norm(v)])
        # A door as wide as its wall leaves slivers of no width beside it.
        if size_m.min() < 1e-9:
            return
        normal = np.cross(u, v) / size_m.prod()
        normal *= np.sign(normal @ np.asarray(towards, float))
        row = (
            np.asarray(corner_m, float),
            u / size_m[0],
            v / size_m[1],
            size_m,
            normal,
            plane,
            surface,
            glass,
        )
        self._rows.append(row)

    def add_axis_aligned(
        self,
        axis: int,
        low_m: Vector,
        high_m: Vector,
        sign: int,
        surface: int,
        plane: int = -1,
        glass: bool = False,
    ) -> None:
        """Append a rectangle perpendicular to an axis, seen from the side of `sign`."""
        low, high = np.array(low_m, float), np.array(high_m, float)
        eye = np.eye(3)
        first, second = (k for k in range(3) if k != axis)
        u, v = eye[first] * (high - low)[first], eye[second] * (high - low)[second]
        self.add(low, u, v, sign * eye[axis], surface, plane, glass)

    def add_box(
        self, centre_m: Vector, size_m: Vector, yaw_rad: float, surface: int, *, bottom: bool = False
    ) -> None:
        """Append the sides and top (and bottom) of an upright box turned about the vertical."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        half = 0.5 * np.asarray(size_m, float)
        for axis in range(3):
            for sign in (-1, 1):
                if axis == 2 and sign < 0 and not bottom:
                    continue
                first, second = (k for k in range(3) if k != axis)
                u, v = axes[first] * 2 * half[first], axes[second] * 2 * half[second]
                corner = np.asarray(centre_m, float) + sign * axes[axis] * half[axis] - 0.5 * (u + v)
                self.add(corner, u, v, sign * axes[axis], surface)

    def build(self) -> Quads:
        """The rectangles collected so far, as arrays."""
        columns = list(zip(*self._rows, strict=True))
        corner, along, across, size, normal = (np.array(column) for column in columns[:5])
        plane, surface, glass = (np.array(column) for column in columns[5:])
        return Quads(corner, along, across, size, normal, plane, surface, glass)
