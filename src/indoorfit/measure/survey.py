"""What there is to measure in a shape: named faces, dimensions, areas, each with its derivatives.

Every dimension is a difference of plane offsets, and areas and volumes are smooth functions of them, so a
value and a gradient over the offsets are all that the interval of a measurand needs.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.model import (
    SIDES,
    Cube,
    DimensionKind,
    FaceKind,
    Polygon,
    RoomSolid,
    Shape,
    Side,
)

from .loops import NOT_ENCLOSED, FloorLoop, floor_loops


@dataclass(frozen=True)
class Measurand:
    """A quantity and its derivative with respect to every plane offset (m, m² or m³ per m)."""

    value: float
    gradient: Float[np.ndarray, " planes"]


@dataclass(frozen=True)
class NamedFace:
    """A polygon with its place in the grammar."""

    id: str
    kind: FaceKind
    room: str
    cube: str
    side: Side
    polygon: Polygon


@dataclass(frozen=True)
class NamedDimension:
    """The distance of two parallel faces, before anything is known of its uncertainty."""

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


def survey(shape: Shape, solids: Sequence[RoomSolid], polygons: Sequence[Sequence[Polygon]]) -> Survey:
    """Name the faces of every room and list what can be measured between them.

    Walls are numbered around the floor, counter-clockwise as seen from above, from its lowest corner.
    Dimensions come as the thesis' table 6-1 has them: extents along x, y and z first, then the walls.

    Args:
        shape: the grammar.
        solids: one per room of the shape.
        polygons: the faces of each of them.
    """
    rooms: list[NamedRoom] = []
    faces: list[NamedFace] = []
    dimensions: list[NamedDimension] = []
    for number, (cube, solid, pieces) in enumerate(zip(shape.rooms, solids, polygons, strict=True), start=1):
        room = f"room-{number}"
        loops = floor_loops(shape, pieces)
        named = _name_faces(shape, room, pieces, loops, faces)
        faces += named
        dimensions += _overall(shape, cube, room, named)
        dimensions += _walls(shape, room, named, loops)
        rooms.append(_room(shape, cube, room, solid, pieces, loops))
    return Survey(tuple(rooms), tuple(faces), tuple(dimensions))


def _name_faces(
    shape: Shape,
    room: str,
    pieces: Sequence[Polygon],
    loops: Sequence[FloorLoop],
    before: Sequence[NamedFace],
) -> list[NamedFace]:
    walls = [edge.wall for loop in loops for edge in loop.edges]
    ordered: list[tuple[Polygon, FaceKind]] = [(piece, "wall") for piece in walls]
    level: tuple[FaceKind, ...] = ("floor", "ceiling")
    for kind in level:
        for piece in pieces:
            if shape.planes[piece.plane].face_class == kind:
                ordered.append((piece, kind))
    owners: dict[int, tuple[Cube, Side]] = {}
    for cube in shape.cubes:
        owners.update({plane: (cube, side) for side, plane in cube.sides.items() if plane is not None})
    counts = Counter(face.kind for face in before)
    named = []
    for piece, kind in ordered:
        counts[kind] += 1
        cube, side = owners[piece.plane]
        named.append(NamedFace(f"{kind}-{counts[kind]}", kind, room, cube.id, side, piece))
    return named


def _difference(shape: Shape, low: int, high: int) -> Measurand:
    gradient = np.zeros(len(shape.planes))
    gradient[high] += 1.0
    gradient[low] -= 1.0
    return Measurand(shape.planes[high].offset_m - shape.planes[low].offset_m, gradient)


def _overall(shape: Shape, cube: Cube, room: str, faces: Sequence[NamedFace]) -> list[NamedDimension]:
    """Extents of the room's cube along x and y, and its height."""
    found = []
    for axis in range(3):
        kind: DimensionKind = "overall" if axis < 2 else "height"
        low, high = cube.sides[SIDES[2 * axis]], cube.sides[SIDES[2 * axis + 1]]
        assert low is not None, "a room has no open side"
        assert high is not None, "a room has no open side"
        ends = [_first_face(faces, plane) for plane in (low, high)]
        # Measured from the middle of the face at the lower end.
        from_m = ends[0].polygon.rings_m[0].mean(axis=0) if axis < 2 else _inner_point(ends[0].polygon)
        to_m = from_m.copy()
        to_m[axis] = shape.planes[high].offset_m
        found.append(
            NamedDimension(
                kind=kind,
                room=room,
                faces=(ends[0].id, ends[1].id),
                wall=None,
                planes=(low, high),
                from_m=from_m,
                to_m=to_m,
                measurand=_difference(shape, low, high),
            )
        )
    return found


def _first_face(faces: Sequence[NamedFace], plane: int) -> NamedFace:
    for face in faces:
        if face.polygon.plane == plane:
            return face
    raise InputError(NOT_ENCLOSED)


def _inner_point(polygon: Polygon) -> Float[np.ndarray, " 3"]:
    """A point of a level polygon away from its edges: the middle of the widest cell of its own grid."""
    ring = polygon.rings_m[0]
    best, widest = ring.mean(axis=0), -1.0
    xs, ys = np.unique(ring[:, 0]), np.unique(ring[:, 1])
    for x0, x1 in pairwise(xs):
        for y0, y1 in pairwise(ys):
            middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2, ring[0, 2]])
            width = min(x1 - x0, y1 - y0)
            if width > widest and _encloses(polygon, middle):
                best, widest = middle, width
    return best


def _encloses(polygon: Polygon, point_m: Float[np.ndarray, " 3"]) -> bool:
    """Even-odd rule over all rings, in plan."""
    inside = False
    for ring in polygon.rings_m:
        following = np.roll(ring, -1, axis=0)
        straddles = (ring[:, 1] > point_m[1]) != (following[:, 1] > point_m[1])
        # Rings are rectilinear: an edge that straddles the height is upright at one x.
        inside ^= bool(np.sum(straddles & (ring[:, 0] > point_m[0])) % 2)
    return inside


def _walls(
    shape: Shape, room: str, faces: Sequence[NamedFace], loops: Sequence[FloorLoop]
) -> list[NamedDimension]:
    """The clear length of every wall, between the walls at its two ends."""
    by_polygon = {id(face.polygon): face for face in faces}
    found = []
    for loop in loops:
        n = len(loop.edges)
        for k, edge in enumerate(loop.edges):
            ends = [loop.edges[k - 1], loop.edges[(k + 1) % n]]
            ends.sort(key=lambda end: shape.planes[end.wall.plane].offset_m)
            planes = (ends[0].wall.plane, ends[1].wall.plane)
            axis = shape.planes[planes[0]].axis
            points = sorted((edge.start_m, edge.end_m), key=lambda point: point[axis])
            middle_m = float(np.mean(edge.wall.rings_m[0][:, 2]))
            from_m, to_m = (np.array([p[0], p[1], middle_m]) for p in points)
            found.append(
                NamedDimension(
                    "wall",
                    room,
                    (by_polygon[id(ends[0].wall)].id, by_polygon[id(ends[1].wall)].id),
                    by_polygon[id(edge.wall)].id,
                    planes,
                    from_m,
                    to_m,
                    _difference(shape, *planes),
                )
            )
    return found


def _room(
    shape: Shape,
    cube: Cube,
    room: str,
    solid: RoomSolid,
    pieces: Sequence[Polygon],
    loops: Sequence[FloorLoop],
) -> NamedRoom:
    """Floor area, volume and perimeter (all walls at the floor, pillars included)."""
    n = len(shape.planes)
    area, volume, perimeter = np.zeros(n), np.zeros(n), np.zeros(n)
    length_m = 0.0
    for piece in pieces:
        # Moving a face outward by dx adds its area times dx.
        volume[piece.plane] += shape.planes[piece.plane].outward * piece.area_m2
    for loop in loops:
        for k, edge in enumerate(loop.edges):
            edge_m = float(np.linalg.norm(edge.end_m - edge.start_m))
            area[edge.wall.plane] += shape.planes[edge.wall.plane].outward * edge_m
            ends = [loop.edges[k - 1].wall.plane, loop.edges[(k + 1) % len(loop.edges)].wall.plane]
            low, high = sorted(ends, key=lambda plane: shape.planes[plane].offset_m)
            perimeter[high] += 1.0
            perimeter[low] -= 1.0
            length_m += edge_m
    floors = [piece.area_m2 for piece in pieces if shape.planes[piece.plane].face_class == "floor"]
    return NamedRoom(
        id=room,
        cube=cube.id,
        solid=solid,
        floor_area=Measurand(float(sum(floors)), area),
        volume=Measurand(solid.volume_m3, volume),
        perimeter=Measurand(length_m, perimeter),
    )
