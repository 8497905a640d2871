"""The model seen from above, in page units: x to the right, y of the Manhattan frame upward."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from indoorfit.model import Face, FitResult

from .display import Box

BAND = 7.0
"""Thickness of the drawn wall, outside the face that was measured. The true one is not known."""

_THICKEST_M = 0.6
"""What is farther apart than this is not drawn as one wall between two rooms."""

_AREA = (760.0, 560.0)
_LARGEST = 1.7


@dataclass(frozen=True)
class WallLine:
    """A wall face as a line on the page."""

    id: str
    room: str
    axis: int
    """0 for a wall that stands across x (drawn upright), 1 for one across y."""
    at: float
    """Page coordinate on that axis."""
    low: float
    high: float
    """Extent along the wall."""
    outward: int
    """+1 or -1: the page direction that leaves the room."""
    inferred: bool
    overhead: bool | None = None
    """Of the side of a level: whether it hangs from the ceiling or stands on the floor. None for walls."""

    def box(self) -> Box:
        """Bounds of the drawn wall; a line for the side of a level."""
        band = BAND if self.overhead is None else 1.0
        inner, outer = sorted((self.at - self.outward, self.at + self.outward * band))
        if self.axis == 0:
            return inner, self.low, outer, self.high
        return self.low, inner, self.high, outer

    def points(self) -> Float[np.ndarray, "2 2"]:
        """Its two ends."""
        ends = np.array([[self.at, self.low], [self.at, self.high]])
        return ends if self.axis == 0 else ends[:, ::-1]


@dataclass(frozen=True)
class ObliqueLine:
    """An oblique wall as a line on the page."""

    id: str
    room: str
    ends: Float[np.ndarray, "2 2"]
    outward: Float[np.ndarray, " 2"]
    """Unit vector of the page that leaves the room."""
    inferred: bool

    def points(self) -> Float[np.ndarray, "2 2"]:
        """Its two ends."""
        return self.ends

    def boxes(self) -> list[Box]:
        """What the drawn wall covers, in pieces of the size of its thickness."""
        n = max(1, int(np.hypot(*(self.ends[1] - self.ends[0])) / BAND))
        along = self.ends[0] + (np.arange(n)[:, None] + 0.5) / n * (self.ends[1] - self.ends[0])
        middles = along + 0.5 * BAND * self.outward
        half = 0.5 * BAND + 1.0
        return [(float(x - half), float(y - half), float(x + half), float(y + half)) for x, y in middles]


@dataclass(frozen=True)
class Outline:
    """All rooms on the page."""

    scale: float
    """Page units per metre."""
    walls: tuple[WallLine, ...]
    """Along the axes."""
    oblique: tuple[ObliqueLine, ...]
    steps: tuple[WallLine, ...]
    """The sides of platforms, beams and lowered ceilings."""
    floors: dict[str, tuple[tuple[Float[np.ndarray, "_ 2"], ...], ...]]
    """By room, the floor polygons with their holes."""
    floor_boxes: dict[str, Box]
    """By room, the bounds of its floor polygons."""
    z_range_m: tuple[float, float]
    """Lowest floor and highest ceiling, Manhattan frame."""

    def to_page(self, points_m: Float[np.ndarray, "points 3"]) -> Float[np.ndarray, "points 2"]:
        """From the Manhattan frame to the page."""
        return points_m[:, :2] * np.array([self.scale, -self.scale])

    def wall(self, face_id: str) -> WallLine | None:
        """The wall or side of a level of that face, None for floors and ceilings."""
        return next((wall for wall in (*self.walls, *self.steps) if wall.id == face_id), None)

    def line(self, face_id: str) -> WallLine | ObliqueLine | None:
        """The same, or the oblique wall of that face."""
        return self.wall(face_id) or next((wall for wall in self.oblique if wall.id == face_id), None)

    def room_box(self, room: str | None = None) -> Box:
        """Bounds of a room's walls, or of all rooms'."""
        ends = np.concatenate([wall.points() for wall in self.walls if room in (None, wall.room)])
        (x0, y0), (x1, y1) = ends.min(axis=0), ends.max(axis=0)
        return float(x0), float(y0), float(x1), float(y1)

    def partitions(self) -> list[Float[np.ndarray, "corners 2"]]:
        """What is between two rooms that stand back to back: the measured thickness of a wall."""
        rectangles = []
        for a in self.walls:
            for b in self.walls:
                low, high = max(a.low, b.low), min(a.high, b.high)
                facing = a.axis == b.axis and a.outward > 0 > b.outward and high > low
                if facing and 0.0 < b.at - a.at < _THICKEST_M * self.scale:
                    # As far as the bands reach; the floors are drawn over what is too much.
                    low, high = low - BAND, high + BAND
                    corners = np.array([[a.at, low], [b.at, low], [b.at, high], [a.at, high]])
                    rectangles.append(corners if a.axis == 0 else corners[:, ::-1])
        return rectangles

    def room_at(self, x: float, y: float) -> str | None:
        """The room that holds a point of the page."""
        for room, polygons in self.floors.items():
            left, top, right, bottom = self.floor_boxes[room]
            # The bounds spare most of the work in a house of many rooms.
            if not (left <= x <= right and top <= y <= bottom):
                continue
            if any(_inside(rings, x, y) for rings in polygons):
                return room
        return None


def outline_of(result: FitResult, scale: float | None = None) -> Outline:
    """Lay the model's faces on the page.

    Args:
        result: what to draw.
        scale: page units per metre; without it as large as is good to read on a screen.
    """
    corners = {
        face.id: tuple(result.frame.to_manhattan(ring) for ring in face.rings_m) for face in result.faces
    }
    everything = np.concatenate([ring for rings in corners.values() for ring in rings])
    extent_m = np.maximum(everything.max(axis=0) - everything.min(axis=0), 1e-3)
    n_walls = sum(face.kind == "wall" for face in result.faces)
    # More walls have more to say, so they get a larger sheet.
    growth = min(max(np.sqrt(n_walls / 8.0), 1.0), _LARGEST)
    if scale is None:
        scale = float(min(_AREA[0] / extent_m[0], _AREA[1] / extent_m[1]) * growth)
    flip = np.array([scale, -scale])
    floors = {
        room.id: tuple(
            tuple(ring[:, :2] * flip for ring in corners[face.id])
            for face in result.faces
            if face.kind == "floor" and face.room == room.id
        )
        for room in result.rooms
    }
    walls = tuple(
        _wall_line(result, face, np.concatenate(corners[face.id])[:, :2] * flip)
        for face in result.faces
        if face.kind == "wall" and not result.shape.planes[face.plane].oblique
    )
    oblique = tuple(
        _oblique_line(result, face, corners[face.id][0][:, :2] * flip)
        for face in result.faces
        if face.kind == "wall" and result.shape.planes[face.plane].oblique
    )
    z_range_m = (float(everything[:, 2].min()), float(everything[:, 2].max()))
    steps = []
    for face in result.faces:
        if face.kind == "step":
            ring = np.concatenate(corners[face.id])
            line = _wall_line(result, face, ring[:, :2] * flip)
            steps.append(replace(line, overhead=bool(ring[:, 2].mean() > np.mean(z_range_m))))
    return Outline(scale, walls, oblique, tuple(steps), floors, _boxes(floors), z_range_m)


def warned_walls(result: FitResult) -> set[str]:
    """Ids of the walls that a warning is about, but for those that are drawn as inferred anyway."""
    named = {face for note in result.notes for face in note.faces}
    return {f.id for f in result.faces if f.kind == "wall" and f.status == "observed" and f.id in named}


def _wall_line(result: FitResult, face: Face, corners: Float[np.ndarray, "corners 2"]) -> WallLine:
    plane = result.shape.planes[face.plane]
    low, high = corners[:, 1 - plane.axis].min(), corners[:, 1 - plane.axis].max()
    outward = plane.outward if plane.axis == 0 else -plane.outward
    at = float(corners[:, plane.axis].mean())
    return WallLine(
        face.id, face.room, plane.axis, at, float(low), float(high), outward, face.status == "inferred"
    )


def _oblique_line(result: FitResult, face: Face, corners: Float[np.ndarray, "corners 2"]) -> ObliqueLine:
    plane = result.shape.planes[face.plane]
    along = plane.turn_normal[:2] * [1.0, -1.0]
    order = np.argsort(corners @ along, kind="stable")
    outward = plane.outward * plane.normal[:2] * [1.0, -1.0]
    ends = corners[[order[0], order[-1]]]
    return ObliqueLine(face.id, face.room, ends, outward, face.status == "inferred")


def _boxes(floors: dict[str, tuple[tuple[Float[np.ndarray, "_ 2"], ...], ...]]) -> dict[str, Box]:
    boxes: dict[str, Box] = {}
    for room, polygons in floors.items():
        corners = np.array([corner for rings in polygons for ring in rings for corner in ring]).reshape(-1, 2)
        x0, y0 = corners.min(axis=0, initial=np.inf).tolist()
        x1, y1 = corners.max(axis=0, initial=-np.inf).tolist()
        boxes[room] = (x0, y0, x1, y1)
    return boxes


def _inside(rings: tuple[Float[np.ndarray, "_ 2"], ...], x: float, y: float) -> bool:
    """Even-odd rule over all rings."""
    crossings = 0
    for ring in rings:
        a, b = ring, np.roll(ring, -1, axis=0)
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(spans, b[:, 1] - a[:, 1], 1.0)
        reach = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
        crossings += int((spans & (reach > x)).sum())
    return crossings % 2 == 1
