"""What the levels of floor and ceiling add to the dimensions of a room."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from indoorfit.model import DimensionKind, Polygon, Shape

from .named import NamedDimension, NamedFace, distance
from .plan_cells import PlanCells


def heights(
    shape: Shape, room: str, faces: Sequence[NamedFace], cells: PlanCells
) -> tuple[NamedDimension, ...]:
    """The clear height over every pair of a floor and a ceiling that lie above each other, main levels first.

    Args:
        shape: the grammar.
        room: id of the room.
        faces: one for every polygon of the room, in their order.
        cells: of the same polygons.
    """
    pairs: dict[tuple[int, int], tuple[NamedFace, NamedFace, np.ndarray]] = {}
    inside = (cells.floor >= 0) & (cells.ceiling >= 0)
    for floor, ceiling in sorted(set(zip(cells.floor[inside], cells.ceiling[inside], strict=True))):
        over = (cells.floor == floor) & (cells.ceiling == ceiling)
        ends = faces[floor], faces[ceiling]
        # Pieces of one plane count once, at the first of them.
        pairs.setdefault((ends[0].polygon.plane, ends[1].polygon.plane), (*ends, over))
    main = main_planes(shape, faces)
    # The main ceiling may nowhere lie over the main floor: the room's height is between them all the same.
    pairs.setdefault(main, (_face_on(faces, main[0]), _face_on(faces, main[1]), cells.floor >= 0))
    ordered = sorted(pairs.items(), key=lambda item: (item[0] != main, item[0]))
    return tuple(
        _upright(shape, room, "height", (low, high), cells.widest(over)) for _, (low, high, over) in ordered
    )


def levels(
    shape: Shape,
    room: str,
    faces: Sequence[NamedFace],
    cells: PlanCells,
    known: Sequence[NamedDimension],
) -> tuple[NamedDimension, ...]:
    """Rise or drop of every other level from the main one, and its extents in plan.

    Args:
        shape: the grammar.
        room: id of the room.
        faces: one for every polygon of the room, in their order.
        cells: of the same polygons.
        known: extents between planes that these dimensions have are not repeated.
    """
    main = main_planes(shape, faces)
    done = {dimension.planes for dimension in known}
    found: list[NamedDimension] = []
    for base, of in zip(main, (cells.floor, cells.ceiling), strict=True):
        for k in sorted(set(of[of >= 0].tolist())):
            face = faces[k]
            if face.polygon.plane == base:
                continue
            on_base = _face_on(faces, base)
            ends = sorted((on_base, face), key=lambda f: shape.planes[f.polygon.plane].offset_m)
            # At the edge, where a tape can be held; levels that do not meet have none.
            number = next(k for k, other in enumerate(faces) if other is on_base)
            at_m = cells.border(of == k, of == number)
            at_m = cells.widest(of == k) if at_m is None else at_m
            step = _upright(shape, room, "step", (ends[0], ends[1]), at_m)
            for dimension in (step, *_extents(shape, room, faces, face.polygon)):
                if dimension.planes not in done:
                    done.add(dimension.planes)
                    found.append(dimension)
    return tuple(found)


def main_planes(shape: Shape, faces: Sequence[NamedFace]) -> tuple[int, int]:
    """The planes with most floor and with most ceiling."""
    areas_m2: dict[int, float] = {}
    for face in faces:
        areas_m2[face.polygon.plane] = areas_m2.get(face.polygon.plane, 0.0) + face.polygon.area_m2
    level = [k for k in areas_m2 if shape.planes[k].axis == 2]
    floor, ceiling = (
        max((k for k in level if shape.planes[k].outward == outward), key=lambda k: areas_m2[k])
        for outward in (-1, 1)
    )
    return floor, ceiling


def _face_on(faces: Sequence[NamedFace], plane: int) -> NamedFace:
    """The largest face on a plane."""
    return max((f for f in faces if f.polygon.plane == plane), key=lambda f: f.polygon.area_m2)


def _upright(
    shape: Shape, room: str, kind: DimensionKind, ends: tuple[NamedFace, NamedFace], at_m: np.ndarray
) -> NamedDimension:
    """A distance along z, at a place of the plan; the lower face first."""
    low, high = ends[0].polygon.plane, ends[1].polygon.plane
    from_m, to_m = (np.array([*at_m, shape.planes[k].offset_m]) for k in (low, high))
    measured = distance(shape, low, high)
    return NamedDimension(kind, room, (ends[0].id, ends[1].id), None, (low, high), from_m, to_m, measured)


def _extents(
    shape: Shape, room: str, faces: Sequence[NamedFace], level: Polygon
) -> tuple[NamedDimension, ...]:
    """The extents of one level piece, between the upright faces at its ends."""
    ring = level.rings_m[0]
    found = []
    for axis in range(2):
        ends = [_face_at(shape, faces, ring, axis, at) for at in (ring[:, axis].min(), ring[:, axis].max())]
        if ends[0] is None or ends[1] is None:
            continue
        low, high = ends[0].polygon.plane, ends[1].polygon.plane
        middle_m = 0.5 * (ring.min(axis=0) + ring.max(axis=0))
        from_m, to_m = middle_m.copy(), middle_m.copy()
        from_m[axis], to_m[axis] = shape.planes[low].offset_m, shape.planes[high].offset_m
        names, measured = (ends[0].id, ends[1].id), distance(shape, low, high)
        found.append(NamedDimension("width", room, names, None, (low, high), from_m, to_m, measured))
    return tuple(found)


def _face_at(
    shape: Shape, faces: Sequence[NamedFace], ring_m: Float[np.ndarray, "_ 3"], axis: int, at_m: float
) -> NamedFace | None:
    """The upright face that meets a level piece where it ends, at `at_m` on the axis."""
    edge = ring_m[ring_m[:, axis] == at_m]
    low_m, high_m = edge.min(axis=0), edge.max(axis=0)
    for face in faces:
        other = face.polygon.rings_m[0]
        plane = shape.planes[face.polygon.plane]
        if plane.axis == axis and not plane.oblique and other[0, axis] == at_m:
            # Corners in one place have equal numbers: polygons come from one mesh.
            meets = (other.min(axis=0) <= high_m) & (other.max(axis=0) >= low_m)
            apart = np.minimum(other.max(axis=0), high_m) - np.maximum(other.min(axis=0), low_m)
            if meets.all() and apart[1 - axis] > 0.0:
                return face
    return None
