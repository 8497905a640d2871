"""What a survey lists: faces, dimensions and rooms, named but without uncertainty."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from indoorfit.model import DimensionKind, FaceKind, PlaneStatus, Polygon, RoomSolid, Shape, Side


@dataclass(frozen=True)
class Measurand:
    """A quantity and its derivative with respect to every parameter of the shape (m, m² or m³ per m)."""

    value: float
    gradient: Float[np.ndarray, " parameters"]
    """In the order of `Shape.parameters`: plane offsets, then the yaws of oblique planes (per rad)."""


@dataclass(frozen=True)
class NamedFace:
    """A polygon with its place in the grammar."""

    id: str
    kind: FaceKind
    room: str
    cube: str
    side: Side
    polygon: Polygon
    status: PlaneStatus
    """Of its plane, unless that was seen on other faces only."""


@dataclass(frozen=True)
class NamedDimension:
    """The distance of two faces, before anything is known of its uncertainty."""

    kind: DimensionKind
    room: str
    faces: tuple[str, str]
    wall: str | None
    planes: tuple[int, int]
    from_m: Float[np.ndarray, " 3"]
    """Manhattan frame."""
    to_m: Float[np.ndarray, " 3"]
    measurand: Measurand


@dataclass(frozen=True)
class NamedRoom:
    """A room with its derived quantities."""

    id: str
    cube: str
    solid: RoomSolid
    floor_area: Measurand
    volume: Measurand
    perimeter: Measurand


@dataclass(frozen=True)
class Survey:
    """Everything measurable, in the order in which it is reported."""

    rooms: tuple[NamedRoom, ...]
    faces: tuple[NamedFace, ...]
    dimensions: tuple[NamedDimension, ...]


def distance(shape: Shape, low: int, high: int) -> Measurand:
    """The distance of two parallel planes, by their indices."""
    gradient = np.zeros(len(shape.parameters))
    gradient[high] += 1.0
    gradient[low] -= 1.0
    return Measurand(shape.planes[high].offset_m - shape.planes[low].offset_m, gradient)


def triangles_of(
    solid: RoomSolid, piece: Polygon
) -> tuple[Float[np.ndarray, "triangles 3"], Float[np.ndarray, " triangles"]]:
    """Middles and areas of the triangles that make up a face."""
    corners_m = solid.vertices_m[solid.triangles[piece.triangles]]
    sides_m = corners_m[:, 1:] - corners_m[:, :1]
    areas_m2 = 0.5 * np.linalg.norm(np.cross(sides_m[:, 0], sides_m[:, 1]), axis=1)
    return corners_m.mean(axis=1), areas_m2
