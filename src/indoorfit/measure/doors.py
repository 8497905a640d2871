"""Which rooms connect: openings through both faces of a wall, with floor or reveal between them."""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.model import DoorEvidence, Doorway, Frame, Shape

from .backing import Backing, backings
from .named import Survey

_CELL_M = 0.10
"""Side of a cell in which a wall shows a point or does not; at least the spacing of the points."""
_BAND_M = (0.3, 1.8)
"""Heights above the floor at which a door is open and a window is not: above thresholds, below the lintel of
2 m, and so that a sill of 0.9 m fills half of it."""
_FILLED = 0.25
"""Share of a column of cells up to which it is open: handles, leaves and people stand in doors."""
_WIDTHS_M = (0.5, 3.0)
"""Clear widths of hatches and of folding walls."""
_EVEN_M = 0.05
"""Points this near to a face are the wall's."""
_FLOOR_M = 0.10
"""Thresholds are lower."""
_SHARE = 0.3
"""Share of the columns of an opening that must show floor between the faces."""
_LINTEL = 0.5
"""Share of the columns of an opening from which on a row of cells is wall again."""
_MIN_REVEAL = 3
"""Least number of cells of jamb or lintel: one is a stray point."""


def find_doors(
    shape: Shape, frame: Frame, found: Survey, points_m: Float[np.ndarray, "points 3"], pixel_m: float
) -> tuple[Doorway, ...]:
    """Doorways that stand open, in the order of the walls.

    An opening counts if both faces lack points at the same place from knee to head height, and points lie
    between the faces: floor that goes on, or the jambs and the lintel. Without the latter, two pieces of
    furniture back to back would make a door. A door leaf that is shut is wall.

    Args:
        shape: fitted grammar.
        frame: fitted pose.
        found: its survey.
        points_m: the scan in the Manhattan frame.
        pixel_m: side of a square on which every fully scanned surface shows points.
    """
    doors: list[Doorway] = []
    cell_m = max(_CELL_M, pixel_m)
    for backing in backings(shape, found):
        faces_m = [shape.planes[face.polygon.plane].offset_m for face in (backing.low, backing.high)]
        near = _near(points_m, backing, faces_m)
        for opening in _openings(near, backing, faces_m, cell_m):
            evidence = _evidence(near, backing, faces_m, opening, cell_m)
            if evidence:
                height_m = _height_m(near, backing, faces_m, opening, cell_m)
                number = len(doors) + 1
                doors.append(_doorway(frame, backing, faces_m, opening, height_m, evidence, number))
    return tuple(doors)


def _near(
    points_m: Float[np.ndarray, "points 3"], backing: Backing, faces_m: Sequence[float]
) -> Float[np.ndarray, "near 3"]:
    """Points in and at the wall as (across, along, up)."""
    order = [backing.axis, 1 - backing.axis, 2]
    low = np.array([faces_m[0] - _EVEN_M, backing.span_m[0], backing.rise_m[0] - _FLOOR_M])
    high = np.array([faces_m[1] + _EVEN_M, backing.span_m[1], backing.rise_m[1] + _FLOOR_M])
    # One coordinate after the other: the first leaves few points for the next.
    for k, axis in enumerate(order):
        points_m = points_m[(points_m[:, axis] > low[k]) & (points_m[:, axis] < high[k])]
    return points_m[:, order]


def _openings(
    near_m: Float[np.ndarray, "near 3"], backing: Backing, faces_m: Sequence[float], cell_m: float
) -> Iterator[tuple[float, float]]:
    """Ends along the wall of what is open in both faces."""
    n = max(1, int((backing.span_m[1] - backing.span_m[0]) / cell_m))
    edges_m = np.linspace(*backing.span_m, n + 1)
    floor_m = backing.rise_m[0]
    band = (near_m[:, 2] > floor_m + _BAND_M[0]) & (near_m[:, 2] < floor_m + _BAND_M[1])
    is_open, on_wall = np.ones(n, bool), np.zeros(len(near_m), bool)
    for face_m in faces_m:
        on_face = band & (np.abs(near_m[:, 0] - face_m) < _reach_m(faces_m))
        is_open &= _column_share(near_m[on_face], edges_m, floor_m, cell_m) <= _FILLED
        on_wall |= on_face
    steps = np.diff(np.pad(is_open.astype(int), 1))
    for first, last in zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True):
        along_m = near_m[on_wall, 1]
        # A cell that is partly wall is wall, so the edge lies in the cell beside: at its last point.
        before = along_m[(along_m <= edges_m[first]) & (along_m > edges_m[max(first - 1, 0)])]
        after = along_m[(along_m >= edges_m[last]) & (along_m < edges_m[min(last + 1, n)])]
        low_m = float(before.max(initial=-np.inf)) if len(before) else float(edges_m[first])
        high_m = float(after.min(initial=np.inf)) if len(after) else float(edges_m[last])
        if _WIDTHS_M[0] <= high_m - low_m <= _WIDTHS_M[1]:
            yield low_m, high_m


def _column_share(
    face_m: Float[np.ndarray, "points 3"], edges_m: Float[np.ndarray, " n1"], floor_m: float, cell_m: float
) -> Float[np.ndarray, " n"]:
    """Share of the band's cells with a point, for every column along the wall."""
    n, rows = len(edges_m) - 1, max(1, int((_BAND_M[1] - _BAND_M[0]) / cell_m))
    column = np.clip(np.searchsorted(edges_m, face_m[:, 1]) - 1, 0, n - 1)
    share = (face_m[:, 2] - floor_m - _BAND_M[0]) / (_BAND_M[1] - _BAND_M[0])
    row: Int[np.ndarray, " points"] = np.clip((share * rows).astype(int), 0, rows - 1)
    seen: Bool[np.ndarray, "n rows"] = np.zeros((n, rows), bool)
    seen[column, row] = True
    return seen.mean(axis=1)


def _height_m(
    near_m: Float[np.ndarray, "near 3"],
    backing: Backing,
    faces_m: Sequence[float],
    opening: tuple[float, float],
    cell_m: float,
) -> float | None:
    """From the floor to the lowest points of the first row of cells that is wall again; None without one."""
    low_m, high_m = backing.rise_m[0] + _BAND_M[1], backing.rise_m[1]
    n = max(1, int((opening[1] - opening[0]) / cell_m))
    on_face = np.min(np.abs(near_m[:, :1] - np.array(faces_m)), axis=1) < _reach_m(faces_m)
    over = on_face & (near_m[:, 1] > opening[0]) & (near_m[:, 1] < opening[1]) & (near_m[:, 2] > low_m)
    along = np.clip((n * (near_m[over, 1] - opening[0]) / (opening[1] - opening[0])).astype(int), 0, n - 1)
    up_m = near_m[over, 2]
    # What is as high as the ceiling is its edge, not a lintel.
    for bottom_m in np.arange(low_m, high_m - cell_m, cell_m):
        in_row = (up_m >= bottom_m) & (up_m < bottom_m + cell_m)
        if len(np.unique(along[in_row])) >= _LINTEL * n:
            return float(up_m[in_row].min() - backing.rise_m[0])
    return None


def _reach_m(faces_m: Sequence[float]) -> float:
    """How near to a face a point is the wall's and not that of its other side."""
    return min(_EVEN_M, 0.4 * (faces_m[1] - faces_m[0]))


def _evidence(
    near_m: Float[np.ndarray, "near 3"],
    backing: Backing,
    faces_m: Sequence[float],
    opening: tuple[float, float],
    cell_m: float,
) -> tuple[DoorEvidence, ...]:
    """What lies between the two faces in the opening."""
    margin_m = 0.25 * (faces_m[1] - faces_m[0])
    between = (near_m[:, 0] > faces_m[0] + margin_m) & (near_m[:, 0] < faces_m[1] - margin_m)
    inside = (near_m[:, 1] > opening[0] - _EVEN_M) & (near_m[:, 1] < opening[1] + _EVEN_M)
    points_m = near_m[between & inside]
    above_m = points_m[:, 2] - backing.rise_m[0]
    found: list[DoorEvidence] = []
    # Jambs have feet, too: only what lies clear of them is floor.
    at_edge = np.min(np.abs(points_m[:, 1, None] - np.array(opening)), axis=1, initial=np.inf) < cell_m
    columns = np.unique(np.floor(points_m[(np.abs(above_m) < _FLOOR_M) & ~at_edge, 1] / cell_m))
    if len(columns) >= _SHARE * max((opening[1] - opening[0]) / cell_m - 2.0, 1.0):
        found.append("floor")
    jamb = (above_m > _BAND_M[0]) & (at_edge | (above_m > _BAND_M[1]))
    if len(np.unique(np.floor(points_m[jamb][:, 1:] / cell_m), axis=0)) >= _MIN_REVEAL:
        found.append("reveal")
    return tuple(found)


def _doorway(
    frame: Frame,
    backing: Backing,
    faces_m: Sequence[float],
    opening: tuple[float, float],
    height_m: float | None,
    evidence: tuple[DoorEvidence, ...],
    number: int,
) -> Doorway:
    sill_m = np.zeros(3)
    sill_m[backing.axis] = 0.5 * (faces_m[0] + faces_m[1])
    sill_m[1 - backing.axis] = 0.5 * (opening[0] + opening[1])
    sill_m[2] = backing.rise_m[0]
    return Doorway(
        id=f"door-{number}",
        rooms=(backing.low.room, backing.high.room),
        faces=(backing.low.id, backing.high.id),
        sill_m=frame.to_scan(sill_m),
        width_m=opening[1] - opening[0],
        evidence=("holes", *evidence),
        height_m=height_m,
    )
