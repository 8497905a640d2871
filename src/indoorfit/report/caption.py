"""Heading and foot of the plan: what it shows, how large it is, and what the marks mean."""

import numpy as np

from indoorfit.export import quantity_text
from indoorfit.model import FitResult, Room

from .arrows import INFERRED, TEXT, WARNED
from .display import Item, Label, Region, Stroke
from .doorways import doorway_text
from .facts import input_name, level_text
from .lettering import text_width
from .outline import BAND, warned_walls

_QUIET = "#5c646b"
_LINE = "#2a2d30"
_ROW = 18.0


def heading(result: FitResult) -> tuple[list[Item], float]:
    """Title lines with their top left corner at the origin, and their height."""
    name = input_name(result)
    title = f"Plan of {name}" if name else "Measured plan"
    rooms = "1 room" if len(result.rooms) == 1 else f"{len(result.rooms)} rooms"
    second = f"{result.method} fit · {rooms} · lengths in metres, ± at {level_text(result.level)} confidence"
    items: list[Item] = [
        Label(title, (0.0, 9.0), 18.0, TEXT, "start"),
        Label(second, (0.0, 32.0), 11.5, _QUIET, "start"),
    ]
    if result.converged:
        return items, 62.0
    items.append(Label("The fit did not converge: see the warnings.", (0.0, 51.0), 11.5, INFERRED, "start"))
    return items, 80.0


def caption(
    result: FitResult, scale: float, width: float, cramped: list[str], denominator: int | None
) -> tuple[list[Item], float]:
    """Scale bar, axes, legend and room lines, with the top left corner at the origin, and their height.

    Args:
        result: what the plan shows.
        scale: page units per metre.
        width: of the sheet.
        cramped: dimensions that the drawing has no space for.
        denominator: N of the scale 1:N, written where it is given.
    """
    bar, bar_width = _scale_bar(scale)
    items: list[Item] = [*bar, *_axes(np.array([bar_width + 46.0, 16.0]))]
    legend = _legend(result, np.array([bar_width + 120.0, 0.0]))
    items += legend
    # Below the scale bar and every line of the legend, of which each is a stroke and a label.
    y = max(58.0, 0.5 * len(legend) * _ROW + 9.0)
    if denominator is not None:
        text = f"Scale 1:{denominator} when printed without fitting to the page"
        items.append(Label(text, (0.0, y), 11.5, TEXT, "start"))
        y += _ROW
    rooms = [line for room in result.rooms for line in _room_lines(result, room)]
    doors = [doorway_text(doorway) for doorway in result.adjacency]
    for line in [*rooms, *doors, *_cramped_lines(cramped, width)]:
        items.append(Label(line, (0.0, y), 11.5, TEXT, "start"))
        y += _ROW
    return items, y - 0.5 * _ROW


def _room_lines(result: FitResult, room: Room) -> list[str]:
    """Area, volume, perimeter and height; of a room with several levels their heights in a second line."""
    parts = [
        f"{name} {quantity_text(quantity, 2, 3).together} {unit}"
        for name, quantity, unit in (
            ("floor", room.floor_area, "m²"),
            ("volume", room.volume, "m³"),
            ("perimeter", room.perimeter, "m"),
        )
    ]
    upright = [d for d in result.dimensions if d.kind in ("height", "step") and d.room == room.id]
    heights = [f"{d.kind} ({d.id}) {quantity_text(d.quantity).together} m" for d in upright]
    lines = [[*parts, *heights]] if len(heights) == 1 else [parts, heights]
    return [f"{room.id}:  " + "  ·  ".join(line) for line in lines]


def _cramped_lines(cramped: list[str], width: float) -> list[str]:
    """Dimensions that the drawing has no space for, wrapped to the sheet."""
    lines: list[str] = []
    for k, text in enumerate(cramped):
        piece = f"Not written in the plan:  {text}" if k == 0 else text
        if lines and text_width(f"{lines[-1]}  ·  {piece}", 11.5) <= width:
            lines[-1] += f"  ·  {piece}"
        else:
            lines.append(piece)
    return lines


def _scale_bar(scale: float) -> tuple[list[Item], float]:
    """A bar of 1, 2 or 5 times a power of ten metres, at most 200 units long, in two halves."""
    wanted_m = 200.0 / scale
    power = 10.0 ** np.floor(np.log10(wanted_m))
    length_m = float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted_m))
    length = length_m * scale
    half = np.array([[0.0, 12.0], [0.5 * length, 12.0], [0.5 * length, 17.0], [0.0, 17.0]])
    whole = np.array([[0.0, 12.0], [length, 12.0], [length, 17.0], [0.0, 17.0]])
    items: list[Item] = [Region((whole,), "#ffffff", _LINE, 1.0), Region((half,), _LINE)]
    for share in (0.0, 0.5, 1.0):
        text = f"{share * length_m:g}" + (" m" if share == 1.0 else "")
        items.append(Label(text, (share * length, 29.0), 10.5, _QUIET))
    return items, length


def _axes(corner: np.ndarray) -> list[Item]:
    """The Manhattan axes: x to the right, y upward."""
    corner = corner + np.array([0.0, 10.0])
    items: list[Item] = []
    for name, direction in (("x", np.array([1.0, 0.0])), ("y", np.array([0.0, -1.0]))):
        across = direction[::-1]
        tip = corner + 28.0 * direction
        back = tip - 6.0 * direction
        items.append(Stroke(np.array([corner, back]), _LINE, 1.1))
        items.append(Region((np.array([tip, back + 2.4 * across, back - 2.4 * across]),), _LINE))
        at = tip + 8.0 * direction
        items.append(Label(name, (float(at[0]), float(at[1])), 10.5, _QUIET))
    return items


def _legend(result: FitResult, corner: np.ndarray) -> list[Item]:
    line = np.array([[0.0, 0.0], [30.0, 0.0]])
    items: list[Item] = []
    kinds: list[tuple[str, str, float, tuple[float, float] | None]] = [
        ("wall face as measured", _LINE, 2.0, None)
    ]
    if any(face.status == "inferred" for face in result.faces):
        kinds.append(("inferred: no points on it", INFERRED, 2.0, (8.0, 5.0)))
    if any(face.kind == "step" for face in result.faces):
        kinds.append(("side of a step (dashed: overhead)", _LINE, 1.0, None))
    if warned_walls(result):
        kinds.append(("a warning is about this wall", WARNED, BAND, None))
    for k, (text, colour, width, dash) in enumerate(kinds):
        at = corner + np.array([0.0, 9.0 + k * 18.0])
        items.append(Stroke(line + at, colour, width, dash))
        items.append(Label(text, (float(at[0]) + 38.0, float(at[1])), 10.5, _QUIET, "start"))
    return items
