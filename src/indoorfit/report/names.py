"""Where the names of walls and rooms go."""

from collections.abc import Iterator

import numpy as np

from indoorfit.export import quantity_text
from indoorfit.model import FitResult, Room

from .arrows import INFERRED
from .board import COLLISION, Board, Marks
from .display import Box, Item, Label, Stroke, text_box
from .lettering import text_width
from .outline import BAND, Outline, WallLine

FLOOR = "#f7f4ee"
_WALL_SIZE = 9.5
_WALL_COLOUR = "#6b6f73"
_ROOM_COLOUR = "#3b3f43"


def name_rooms(result: FitResult, outline: Outline, board: Board) -> Iterator[Item]:
    """The name of every room, with area and height where there is space, far from its walls."""
    for room in result.rooms:
        area = f"{quantity_text(room.floor_area, 2, 3).value} m²"
        heights = [d for d in result.dimensions if d.kind == "height" and d.room == room.id]
        height = f"height {quantity_text(heights[0].quantity).value} m" if heights else ""
        second = " · ".join(text for text in (area, height) if text)
        for lines in (((room.id, 15.0), (second, 11.0)), ((room.id, 12.0),)):
            centre = _roomiest(room, outline, board, lines)
            if centre is not None:
                yield from _room_lines(centre, lines, board)
                break


def _room_lines(centre: tuple[float, float], lines, board: Board) -> Iterator[Item]:
    for (text, size), box, y in _stacked(centre, lines):
        board.add("text", [box])
        yield Label(text, (centre[0], y), size, _ROOM_COLOUR, halo=FLOOR)


def _stacked(centre: tuple[float, float], lines) -> Iterator[tuple[tuple[str, float], Box, float]]:
    height = 18.0
    for k, (text, size) in enumerate(lines):
        y = centre[1] + (k - 0.5 * (len(lines) - 1)) * height
        yield (text, size), text_box((centre[0], y), text_width(text, size), size), y


def _roomiest(room: Room, outline: Outline, board: Board, lines) -> tuple[float, float] | None:
    """The point of a grid whose text is inside the room and farthest from everything."""
    x0, y0, x1, y1 = outline.room_box(room.id)
    best, clearance = None, 0.0
    walls = [wall.box() for wall in outline.walls if wall.room == room.id]
    middle = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)])
    for x in np.linspace(x0, x1, 17)[1:-1]:
        for y in np.linspace(y0, y1, 17)[1:-1]:
            boxes = [box for _, box, _ in _stacked((x, y), lines)]
            if board.hits("wall", boxes, 4.0) or board.hits("text", boxes, 4.0):
                continue
            # No wall is near, so the text lies on the same side of all of them as its middle.
            if outline.room_at(float(x), float(y)) != room.id:
                continue
            # Distance of the text to the nearest wall; a little pull to the middle settles ties.
            free = min(_distance(box, wall) for box in boxes for wall in walls)
            free -= 0.05 * float(np.hypot(*(middle - (x, y))))
            if best is None or free > clearance:
                best, clearance = (float(x), float(y)), free
    return best


def _distance(a: Box, b: Box) -> float:
    dx = max(a[0] - b[2], b[0] - a[2], 0.0)
    dy = max(a[1] - b[3], b[1] - a[3], 0.0)
    return float(np.hypot(dx, dy))


def name_walls(outline: Outline, board: Board, short: bool) -> Iterator[Item]:
    """The id of every wall, along it and inside where that fits, else nearby with a leader.

    Args:
        outline: the walls.
        board: what is taken; the names are added.
        short: name the walls that are hardly longer than their name, or the others.
    """
    for wall in (*outline.walls, *outline.steps):
        text = f"{wall.id} inferred" if wall.inferred else wall.id
        if short != (1.6 * text_width(text, _WALL_SIZE) > wall.high - wall.low):
            continue
        best = _best_name(wall, text, outline, board)
        if best is None:
            continue
        at, upright, box, taste = best
        board.add("text", [box])
        colour = INFERRED if wall.inferred else _WALL_COLOUR
        if taste >= _LEADER:
            yield Stroke(np.array([_middle(wall), _nearest(box, _middle(wall))]), colour, 0.6)
        background = FLOOR if outline.room_at(*at) else "#ffffff"
        yield Label(text, at, _WALL_SIZE, colour, "middle", upright, background, (wall.id,))


def _best_name(
    wall: WallLine, text: str, outline: Outline, board: Board
) -> tuple[tuple[float, float], bool, Box, float] | None:
    """The cheapest place for a wall's name: anchor, whether upright, box and taste."""
    width = text_width(text, _WALL_SIZE)
    best, least = None, COLLISION
    for at, upright, taste in sorted(_places(wall, width), key=lambda place: place[2]):
        if taste >= least:
            break
        box = text_box(at, width, _WALL_SIZE, "middle", upright)
        cost = taste + board.cost(Marks(texts=(box,)))
        if cost >= least:
            continue
        # A name inside another room would be read as that room's.
        cost += 200.0 * (outline.room_at(*at) not in (None, wall.room))
        # ... and one clearly nearer to another wall as that wall's.
        own = _distance(box, wall.box()) - 2.0
        cost += 60.0 * any(_distance(box, other.box()) < own for other in outline.walls if other != wall)
        if cost < least:
            best, least = (at, upright, box, taste), cost
    return best


def name_oblique(result: FitResult, outline: Outline, board: Board) -> Iterator[Item]:
    """The id of every oblique wall and its clear length, outside in front of its middle."""
    for wall in outline.oblique:
        texts = [f"{wall.id} inferred" if wall.inferred else wall.id]
        for dimension in result.dimensions:
            if dimension.wall == wall.id:
                text = quantity_text(dimension.quantity)
                texts.append(f"{dimension.id}  {text.together}")
        text = "  ".join(texts)
        width, middle = text_width(text, _WALL_SIZE), wall.points().mean(axis=0)
        half = 0.5 * float(np.abs(wall.outward) @ [width, _WALL_SIZE])
        places = [(away, side) for away in (10.0, 22.0, 40.0, 60.0, 85.0, 115.0) for side in (1.0, -1.0)]
        for away, side in places:
            x, y = middle + side * (away + half) * wall.outward
            box = text_box((float(x), float(y)), width, _WALL_SIZE)
            if board.cost(Marks(texts=(box,))) < COLLISION:
                board.add("text", [box])
                colour = INFERRED if wall.inferred else _WALL_COLOUR
                background = FLOOR if outline.room_at(float(x), float(y)) else "#ffffff"
                yield Label(text, (float(x), float(y)), _WALL_SIZE, colour, halo=background, shows=(wall.id,))
                break


_LEADER = 40.0


def _places(wall: WallLine, width: float) -> Iterator[tuple[tuple[float, float], bool, float]]:
    """Middle of the text, whether it is upright, and the taste of it."""
    middle, length = 0.5 * (wall.low + wall.high), wall.high - wall.low
    inside = wall.at - 10.0 * wall.outward
    if width <= length:
        for share in (0.0, -0.2, 0.2, -0.4, 0.4):
            along = middle + share * (length - width)
            yield _point(wall, along, inside), wall.axis == 0, abs(share)
    half = 0.5 * width if wall.axis == 0 else 0.6 * _WALL_SIZE
    for away in (6.0, 14.0, 24.0, 38.0, 56.0):
        for shift in (0.0, -14.0, 14.0, -30.0, 30.0, -50.0, 50.0):
            taste = _LEADER + away + 0.3 * abs(shift)
            yield _point(wall, middle + shift, wall.at - wall.outward * (away + half)), False, taste
            outside = wall.at + wall.outward * (away + BAND + half)
            yield _point(wall, middle + shift, outside), False, taste + 8.0


def _point(wall: WallLine, along: float, across: float) -> tuple[float, float]:
    return (across, along) if wall.axis == 0 else (along, across)


def _middle(wall: WallLine) -> tuple[float, float]:
    return _point(wall, 0.5 * (wall.low + wall.high), wall.at)


def _nearest(box: Box, point: tuple[float, float]) -> tuple[float, float]:
    return min(max(point[0], box[0]), box[2]), min(max(point[1], box[1]), box[3])
