"""Where the parts of a plan go, for every format that draws one."""

from dataclasses import dataclass

from indoorfit.model import FitResult

from .arrows import Placement, Span, place_spans, spans_of
from .board import Board
from .display import Item
from .names import name_oblique, name_rooms, name_walls
from .outline import Outline, outline_of

UNIT_MM = 25.4 / 96.0
"""A page unit on paper."""


@dataclass(frozen=True)
class Layout:
    """A plan before it is drawn."""

    outline: Outline
    names: tuple[Item, ...]
    """Of rooms and walls."""
    placements: tuple[Placement, ...]
    """The dimensions."""
    cramped: tuple[Span, ...]
    """Dimensions without space for their values."""
    denominator: int | None
    """N of the scale 1:N on paper, or None for a plan that is only looked at."""


def lay_out(result: FitResult, denominator: int | None = None) -> Layout:
    """Find a place for walls, then names, then dimensions.

    Args:
        result: what to draw.
        denominator: N of the scale 1:N on paper; without it as large as is good to read on a screen.
    """
    scale = None if denominator is None else 1000.0 / denominator / UNIT_MM
    outline = outline_of(result, scale)
    board = Board()
    board.add("wall", [wall.box() for wall in (*outline.walls, *outline.steps)])
    board.add("wall", [box for wall in outline.oblique for box in wall.boxes()])
    # Names of short walls come last: with a leader they can stand anywhere.
    names = [*name_rooms(result, outline, board), *name_walls(outline, board, short=False)]
    names += name_oblique(result, outline, board)
    placements, cramped = place_spans(spans_of(result, outline), outline, board)
    names += name_walls(outline, board, short=True)
    return Layout(outline, tuple(names), tuple(placements), tuple(cramped), denominator)
