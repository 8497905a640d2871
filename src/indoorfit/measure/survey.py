"""What there is to measure in a shape: named faces, dimensions, areas, each with its derivatives.

Every dimension is a difference of plane offsets, or of corners where walls are oblique, and areas and
volumes are smooth functions of the same parameters, so a value and a gradient over them are all that the
interval of a measurand needs.
"""

from collections import Counter
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from indoorfit.errors import InputError
from indoorfit.model import SIDES, Cube, FaceKind, Polygon, RoomSolid, Shape, Side

from .clear_lengths import clear_length, swept
from .level_dimensions import heights, levels
from .loops import FloorLoop, floor_loops
from .named import Measurand, NamedDimension, NamedFace, NamedRoom, Survey, distance, triangles_of
from .plan_cells import NOT_ENCLOSED, plan_cells


def survey(shape: Shape, solids: Sequence[RoomSolid], polygons: Sequence[Sequence[Polygon]]) -> Survey:
    """Name the faces of every room and list what can be measured between them.

    Walls are numbered around the plan, counter-clockwise as seen from above, from its lowest corner; upright
    faces between two levels are steps, not walls. Dimensions come as the thesis' table 6-1 has them: extents
    along x, y and z first, then the walls; last what the levels of floor and ceiling add.

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
        cells = plan_cells(shape, pieces)
        loops = floor_loops(shape, pieces)
        named = _name_faces(shape, room, pieces, loops, faces)
        faces += named
        by_polygon = {id(face.polygon): face for face in named}
        in_order = [by_polygon[id(piece)] for piece in pieces]
        main, *others = heights(shape, room, in_order, cells)
        plan = [*_overall(shape, cube, room, named), main, *_walls(shape, room, named, loops)]
        dimensions += [*plan, *others, *levels(shape, room, in_order, cells, plan)]
        rooms.append(_room(shape, cube, room, solid, pieces, loops))
    return Survey(tuple(rooms), tuple(faces), tuple(dimensions))


def _name_faces(
    shape: Shape,
    room: str,
    pieces: Sequence[Polygon],
    loops: Sequence[FloorLoop],
    before: Sequence[NamedFace],
) -> list[NamedFace]:
    # A wall around an alcove may meet the plan twice.
    walls = list({id(edge.wall): edge.wall for loop in loops for edge in loop.edges}.values())
    ordered: list[tuple[Polygon, FaceKind]] = [(piece, "wall") for piece in walls]
    level: tuple[FaceKind, ...] = ("floor", "ceiling")
    for kind in level:
        for piece in pieces:
            if shape.planes[piece.plane].face_class == kind:
                ordered.append((piece, kind))
    known = {id(piece) for piece, _ in ordered}
    owners = _owners(shape)
    for piece in pieces:
        if id(piece) not in known:
            ordered.append((piece, "step" if owners[piece.plane][0].id in _level_cubes(shape) else "wall"))
    counts = Counter(face.kind for face in before)
    named = []
    for piece, kind in ordered:
        counts[kind] += 1
        cube, side = owners[piece.plane]
        status = shape.planes[piece.plane].status
        named.append(NamedFace(f"{kind}-{counts[kind]}", kind, room, cube.id, side, piece, status))
    return named


def _owners(shape: Shape) -> dict[int, tuple[Cube, Side]]:
    """The cube that has each plane for a side; of several, the first: the others only continue it."""
    owners: dict[int, tuple[Cube, Side]] = {}
    for cube in shape.cubes:
        for side, plane in cube.sides.items():
            if plane is not None:
                owners.setdefault(plane, (cube, side))
    return owners


def _level_cubes(shape: Shape) -> set[str]:
    """Steps, platforms and beams, and all that is taken away from them."""
    found: set[str] = set()
    for cube in shape.cubes:
        if cube.role in ("step", "platform", "beam") or cube.parent in found:
            found.add(cube.id)
    return found


def _overall(shape: Shape, cube: Cube, room: str, faces: Sequence[NamedFace]) -> list[NamedDimension]:
    """Extents of the room's cube along x and y."""
    found = []
    for axis in range(2):
        low, high = cube.sides[SIDES[2 * axis]], cube.sides[SIDES[2 * axis + 1]]
        assert low is not None, "a room has no open side"
        assert high is not None, "a room has no open side"
        ends = [_first_face(faces, plane) for plane in (low, high)]
        if ends[0] is None or ends[1] is None:
            if not shape.oblique:
                raise InputError(NOT_ENCLOSED)
            # An oblique wall stands in its place, and the room has no one extent that way.
            continue
        # Measured from the middle of the face at the lower end.
        from_m = ends[0].polygon.rings_m[0].mean(axis=0)
        to_m = from_m.copy()
        to_m[axis] = shape.planes[high].offset_m
        names = (ends[0].id, ends[1].id)
        measured = distance(shape, low, high)
        found.append(NamedDimension("overall", room, names, None, (low, high), from_m, to_m, measured))
    return found


def _first_face(faces: Sequence[NamedFace], plane: int) -> NamedFace | None:
    return next((face for face in faces if face.polygon.plane == plane), None)


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
            measured = clear_length(shape, ends[0].wall.plane, edge.wall.plane, ends[1].wall.plane)
            points = [edge.start_m, edge.end_m]
            # Along x or along y in increasing order, as the lengths of the room's cube are.
            if tuple(points[1]) < tuple(points[0]):
                points, ends = points[::-1], ends[::-1]
            planes = (ends[0].wall.plane, ends[1].wall.plane)
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
                    measured,
                )
            )
    return found


def _middle_m(solid: RoomSolid, piece: Polygon) -> Float[np.ndarray, " 3"]:
    """The centre of a face's area: where steps meet a wall, it is not that of its corners."""
    middles_m, areas_m2 = triangles_of(solid, piece)
    return np.average(middles_m, axis=0, weights=areas_m2)


def _room(
    shape: Shape,
    cube: Cube,
    room: str,
    solid: RoomSolid,
    pieces: Sequence[Polygon],
    loops: Sequence[FloorLoop],
) -> NamedRoom:
    """Floor area, volume and perimeter (all walls at the floor, pillars included)."""
    area, volume, perimeter = (np.zeros(len(shape.parameters)) for _ in range(3))
    length_m = 0.0
    for piece in pieces:
        volume += swept(shape, piece.plane, piece.area_m2, _middle_m(solid, piece))
    for loop in loops:
        for k, edge in enumerate(loop.edges):
            edge_m = float(np.linalg.norm(edge.end_m - edge.start_m))
            area += swept(shape, edge.wall.plane, edge_m, 0.5 * (edge.start_m + edge.end_m))
            before, after = loop.edges[k - 1].wall.plane, loop.edges[(k + 1) % len(loop.edges)].wall.plane
            perimeter += clear_length(shape, before, edge.wall.plane, after).gradient
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
