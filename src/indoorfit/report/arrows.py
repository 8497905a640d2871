"""Where dimension lines and their texts go: every place worth trying, and the cheapest taken."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from indoorfit.export import quantity_text
from indoorfit.model import Dimension, FitResult

from .board import COLLISION, Board, Marks
from .display import Box, Item, Label, Region, Stroke, text_box
from .lettering import text_width
from .outline import BAND, Outline, WallLine

SIZE = 12.0
_TIER = 23.0
"""Distance of neighbouring dimension lines: a text and its air."""
_RAISE = 9.5
"""Distance of a text's middle from its line."""
_GAP = 3.0

LINE = "#35607f"
TEXT = "#1d2b36"
ACCENT = "#0f6ab4"
INFERRED = "#b4540a"
WARNED = "#f0c36d"
"""Behind the line of a wall: pale enough for the line to stay the darkest."""


@dataclass(frozen=True)
class Span:
    """One distance to draw; dimensions between the same two faces share it."""

    dimensions: tuple[str, ...]
    """Their ids."""
    text: str
    axis: int
    """Page axis along which it is measured."""
    low: float
    high: float
    ends: tuple[WallLine, WallLine]
    """The walls at `low` and at `high`."""
    walls: tuple[WallLine, ...]
    """Walls whose clear length it is."""
    room: str
    inferred: bool

    @property
    def ids(self) -> str:
        """The ids as drawn."""
        return ", ".join(self.dimensions)

    @property
    def label(self) -> str:
        """Names and value as drawn."""
        return f"{self.ids}  {self.text}" if self.text else self.ids


@dataclass(frozen=True)
class Placement:
    """A span at a place."""

    span: Span
    at: float
    """Page coordinate of the dimension line, across the span."""
    text_at: tuple[float, float]
    upright: bool
    marks: Marks
    taste: float
    """What makes it less handsome than others, without collisions."""


def spans_of(result: FitResult, outline: Outline) -> list[Span]:
    """All distances that a plan can show, walls before overall extents, roomy ones first."""
    groups: dict[tuple[str, str], list[Dimension]] = {}
    for dimension in result.dimensions:
        if dimension.kind not in ("height", "step"):
            groups.setdefault(dimension.faces, []).append(dimension)
    spans = [span for group in groups.values() if (span := _span(group, outline)) is not None]
    spans += [span for d in result.dimensions if (span := _to_corner(d, result, outline)) is not None]
    # Texts that fit their span have one good place; the short ones can go around them.
    return sorted(spans, key=lambda span: (not span.walls, not _fits(span)))


def _fits(span: Span) -> bool:
    return text_width(span.label, SIZE) + 12.0 <= span.high - span.low


def _span(group: list[Dimension], outline: Outline) -> Span | None:
    first = group[0]
    pair = [outline.wall(face) for face in first.faces]
    if pair[0] is None or pair[1] is None or pair[0].axis != pair[1].axis:
        return None
    low, high = sorted((pair[0], pair[1]), key=lambda wall: wall.at)
    own = [outline.wall(d.wall) for d in group if d.wall is not None]
    return Span(
        dimensions=tuple(d.id for d in group),
        text=quantity_text(first.quantity).together,
        axis=low.axis,
        low=low.at,
        high=high.at,
        ends=(low, high),
        walls=tuple(wall for wall in own if wall is not None),
        room=first.room,
        inferred=first.status == "inferred",
    )


def _to_corner(dimension: Dimension, result: FitResult, outline: Outline) -> Span | None:
    """The clear length of a wall along the axes that ends at an oblique one: from corner to corner."""
    wall = None if dimension.wall is None else outline.wall(dimension.wall)
    if wall is None or all(outline.wall(face) is not None for face in dimension.faces):
        return None
    axis = 1 - wall.axis
    places = outline.to_page(result.frame.to_manhattan(np.stack([dimension.from_m, dimension.to_m])))[:, axis]
    low, high = (
        WallLine(wall.id, wall.room, axis, float(at), wall.at, wall.at, 1, wall.inferred)
        for at in np.sort(places)
    )
    return Span(
        dimensions=(dimension.id,),
        text=quantity_text(dimension.quantity).together,
        axis=axis,
        low=low.at,
        high=high.at,
        ends=(low, high),
        walls=(wall,),
        room=dimension.room,
        inferred=dimension.status == "inferred",
    )


def place_spans(spans: list[Span], outline: Outline, board: Board) -> tuple[list[Placement], list[Span]]:
    """Choose a place for every span, without any overlap of texts, lines and walls.

    Returns:
        the placements, and the spans that had to go without their value (id only) or found no room.
    """
    placements: list[Placement] = []
    cramped: list[Span] = []
    for span in spans:
        best = _best(span, outline, board)
        if best is None:
            cramped.append(span)
            best = _best(replace(span, text=""), outline, board)
        if best is not None:
            board.place(best.marks)
            placements.append(best)
    return placements, cramped


def _best(span: Span, outline: Outline, board: Board) -> Placement | None:
    best, least = None, COLLISION
    for placement in sorted(_placements(span, outline), key=lambda p: p.taste):
        # Taste is a lower bound of the cost, and they come in its order.
        if placement.taste >= least:
            break
        cost = placement.taste + board.cost(placement.marks)
        if cost < least:
            best, least = placement, cost
    return best


def _placements(span: Span, outline: Outline) -> Iterator[Placement]:
    for at, side, taste in _line_places(span, outline):
        middle = (0.5 * (span.low + span.high), at)
        holder = outline.room_at(*(middle if span.axis == 0 else middle[::-1]))
        if holder not in (None, span.room):
            taste += 150.0
        lines, extensions = _line_boxes(span, at)
        for text_at, upright, text, extra in _text_places(span, at, side):
            reach = _reach(span, text) if extra >= _BEYOND else ()
            yield Placement(
                span, at, text_at, upright, Marks((text,), (*lines, *reach), extensions), taste + extra
            )


def _line_places(span: Span, outline: Outline) -> Iterator[tuple[float, int, float]]:
    """Positions of the line across the span, the side that its text prefers, and their taste."""
    across = 1 - span.axis
    room, house = outline.room_box(span.room), outline.room_box()
    for wall in span.walls:
        outer = not _is_covered(wall, outline)
        # Below and left come first, as on a drawing board.
        turned = 3.0 if (wall.outward > 0) != (across == 1) else 0.0
        edge = house[across + 2] if wall.outward > 0 else house[across]
        for tier in range(1, 9):
            away = (_TIER * tier + BAND - 2.0) * wall.outward
            if outer:
                yield edge + away, wall.outward, turned + 4.0 * tier + 0.08 * abs(edge - wall.at)
            yield wall.at + away, wall.outward, turned + 4.0 * tier + (10.0 if outer else 25.0)
            inner = wall.at - (_TIER * tier + 13.0) * wall.outward
            yield inner, -wall.outward, turned + 5.0 * tier + (200.0 if outer else 0.0)
    if not span.walls:
        for tier in range(1, 9):
            away = _TIER * tier + BAND - 2.0
            for box, extra in ((house, 0.0), (room, 15.0)):
                low_side = 0.0 if across == 0 else 3.0
                yield box[across] - away, -1, low_side + 4.0 * tier + extra
                yield box[across + 2] + away, 1, 3.0 - low_side + 4.0 * tier + extra
        for share in (0.5, 0.35, 0.65, 0.25, 0.75, 0.15, 0.85):
            inside = room[across] + share * (room[across + 2] - room[across])
            yield inside, -1, 60.0 + 20.0 * abs(share - 0.5)


def _is_covered(wall: WallLine, outline: Outline) -> bool:
    """Whether another wall lies outward of this one: then there is no clear way to the margin."""
    return any(
        other.axis == wall.axis
        and (other.at - wall.at) * wall.outward > 0.5
        and min(other.high, wall.high) - max(other.low, wall.low) > 0.5
        for other in outline.walls
    )


_BEYOND = 30.0


def _text_places(span: Span, at: float, side: int) -> Iterator[tuple[tuple[float, float], bool, Box, float]]:
    """Anchors of the text, whether it is upright, its box, and the taste of it."""
    width = text_width(span.label, SIZE)
    length, middle = span.high - span.low, 0.5 * (span.low + span.high)
    overhang = max(0.0, width - length + 12.0)
    alongs = [(middle, 0.12 * overhang)]
    if overhang:
        for direction in (-1, 1):
            alongs.append((middle + direction * 0.5 * overhang, 6.0 + 0.1 * overhang))
            alongs.append((middle + direction * (0.5 * length + 0.5 * width + 12.0), -1.0))
    else:
        alongs += [(middle + share * (length - width), 10.0) for share in (-0.25, 0.25, -0.45, 0.45)]
    # Text sits above a level line and left of an upright one, unless that side is taken.
    for along, taste in alongs:
        if taste < 0.0:
            yield _text_at(span, along, at, width, upright=span.axis == 1, extra=_BEYOND)
            continue
        for rise, flipped in ((-_RAISE, 0.0), (_RAISE, 4.0)):
            extra = taste + flipped + (2.0 if rise * side < 0 and overhang else 0.0)
            yield _text_at(span, along, at + rise, width, upright=span.axis == 1, extra=extra)
    if span.axis == 1 and overhang:
        for direction in (-1, 1):
            beside = at + direction * (8.0 + 0.5 * width)
            yield _text_at(span, middle, beside, width, upright=False, extra=3.0)


def _text_at(span: Span, along: float, across: float, width: float, upright: bool, extra: float):
    anchor = (along, across) if span.axis == 0 else (across, along)
    return anchor, upright, text_box(anchor, width, SIZE, "middle", upright), extra


def _line_boxes(span: Span, at: float) -> tuple[tuple[Box, ...], tuple[Box, ...]]:
    """The dimension line, shortened to stay off the walls that it ends at, and its extension lines."""
    inset = min(4.0, 0.25 * (span.high - span.low))
    line = _oriented(span, span.low + inset, span.high - inset, at - 0.5, at + 0.5)
    extensions = []
    for end in span.ends:
        start = extension_start(end, at)
        if start is not None:
            extensions.append(_oriented(span, end.at - 0.4, end.at + 0.4, *sorted((start, at))))
    return (line,), tuple(extensions)


def extension_start(wall: WallLine, at: float) -> float | None:
    """Where the extension line leaves the wall; None where the dimension line meets the wall itself."""
    if wall.low - 1.0 <= at <= wall.high + 1.0:
        return None
    return wall.low - BAND - _GAP if at < wall.low else wall.high + BAND + _GAP


def _reach(span: Span, text: Box) -> tuple[Box, ...]:
    """The piece of line from the span to a text beyond its end: nothing else may stand there."""
    start, end = (text[0], text[2]) if span.axis == 0 else (text[1], text[3])
    across = 0.5 * (text[1] + text[3]) if span.axis == 0 else 0.5 * (text[0] + text[2])
    if start > span.high:
        return (_oriented(span, span.high + 4.0, start - 3.0, across - 0.5, across + 0.5),)
    return (_oriented(span, end + 3.0, span.low - 4.0, across - 0.5, across + 0.5),)


def _oriented(span: Span, along0: float, along1: float, across0: float, across1: float) -> Box:
    if span.axis == 0:
        return along0, across0, along1, across1
    return across0, along0, across1, along1


def draw_placement(placement: Placement) -> Iterator[Item]:
    """Extension lines, dimension line with arrow heads, and the text with its id in colour."""
    span, at = placement.span, placement.at
    colour, shows = INFERRED if span.inferred else LINE, span.dimensions
    for end in span.ends:
        start = extension_start(end, at)
        if start is not None:
            over = at + (2.0 if at > start else -2.0)
            yield Stroke(_points(span, [(end.at, start), (end.at, over)]), colour, 0.6, shows=shows)
    short = span.high - span.low < 24.0
    tail = 12.0 if short else 0.0
    yield Stroke(_points(span, [(span.low - tail, at), (span.high + tail, at)]), colour, 0.9, shows=shows)
    for tip, direction in ((span.low, 1.0), (span.high, -1.0)):
        back = tip + direction * (-7.0 if short else 7.0)
        head = _points(span, [(tip, at), (back, at - 2.2), (back, at + 2.2)])
        yield Region((head,), colour, shows=shows)
    yield from _draw_text(placement)


def _draw_text(placement: Placement) -> Iterator[Item]:
    span = placement.span
    name = f"{span.ids}  " if span.text else span.ids
    whole, first = text_width(span.label, SIZE), text_width(name, SIZE)
    x, y = placement.text_at
    accent = INFERRED if span.inferred else ACCENT
    for text, start, colour in ((span.ids, -0.5 * whole, accent), (span.text, first - 0.5 * whole, TEXT)):
        if text:
            corner = (x, y - start) if placement.upright else (x + start, y)
            yield Label(text, corner, SIZE, colour, "start", placement.upright, "#ffffff", span.dimensions)


def _points(span: Span, pairs: list[tuple[float, float]]) -> np.ndarray:
    points = np.array(pairs)
    return points if span.axis == 0 else points[:, ::-1]
