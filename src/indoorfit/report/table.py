"""The dimension table for the terminal: plain text that survives any log."""

from collections.abc import Sequence

from indoorfit.export import quantity_text
from indoorfit.model import Dimension, FitResult, Quantity, TapeVerdict

from .doorways import doorway_text
from .facts import level_text
from .tape import tape_summary, tape_table

_GAP = "  "


def dimension_table(result: FitResult) -> str:
    """Dimensions, rooms and warnings as aligned lines, metres throughout.

    Values carry as many decimals as their interval warrants; an interval that is not symmetric is
    written as its two ends.
    """
    level = level_text(result.level)
    blocks = []
    if result.dimensions:
        rows = [_dimension_row(d, _several_rooms(result)) for d in result.dimensions]
        blocks.append(aligned(("id", "what", "value m", f"interval at {level}", "status"), rows))
    if result.rooms:
        rows = [
            (room.id, name, *_numbers(quantity), unit)
            for room in result.rooms
            for name, quantity, unit in (
                ("floor area", room.floor_area, "m²"),
                ("volume", room.volume, "m³"),
                ("perimeter", room.perimeter, "m"),
            )
        ]
        blocks.append(aligned(("room", "what", "value", f"interval at {level}", "unit"), rows))
    if result.adjacency:
        blocks.append("\n".join(doorway_text(doorway) for doorway in result.adjacency))
    if result.tape is not None:
        blocks.append("\n".join([*_tape_lines(result.tape), tape_summary(result.tape)]))
    if result.notes:
        blocks.append("\n".join(f"warning {note.code}: {note.message}" for note in result.notes))
    if not result.converged:
        blocks.append("The fit did not converge or a room is not closed: use these numbers with care.")
    return "\n\n".join(blocks) + "\n"


def _tape_lines(tape: TapeVerdict) -> list[str]:
    return [aligned(*tape_table(tape))] if tape.checks else []


def what_is_measured(dimension: Dimension, with_room: bool) -> str:
    """One phrase for a dimension: `wall-1, from wall-4 to wall-2`."""
    subject = dimension.wall or dimension.kind
    between = dimension.wall is not None or dimension.kind == "thickness"
    room = f"{dimension.room} " if with_room and not between else ""
    return f"{room}{subject}, from {dimension.faces[0]} to {dimension.faces[1]}"


def _several_rooms(result: FitResult) -> bool:
    return len(result.rooms) > 1


def _dimension_row(dimension: Dimension, with_room: bool) -> tuple[str, ...]:
    what = what_is_measured(dimension, with_room)
    text = quantity_text(dimension.quantity)
    return dimension.id, what, text.value, text.spread, dimension.status


def _numbers(quantity: Quantity) -> tuple[str, str]:
    text = quantity_text(quantity, min_decimals=2, max_decimals=3)
    return text.value, text.spread


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns as wide as their widest cell, decimal points below each other, a rule below the head."""
    rows = _points_aligned(head, rows)
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    right = [cell.startswith("value") for cell in head]

    def line(cells: Sequence[str]) -> str:
        padded = (
            cell.rjust(width) if flush else cell.ljust(width)
            for cell, width, flush in zip(cells, widths, right, strict=True)
        )
        return _GAP.join(padded).rstrip()

    rule = _GAP.join("-" * width for width in widths)
    return "\n".join([line(head), rule, *map(line, rows)])


def _points_aligned(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """The same rows, values with fewer decimals padded on the right."""
    padded = [list(row) for row in rows]
    for k, title in enumerate(head):
        if title.startswith("value"):
            decimals = [len(row[k].partition(".")[2]) for row in padded]
            for row, own in zip(padded, decimals, strict=True):
                row[k] += " " * (max(decimals) - own)
    return padded
