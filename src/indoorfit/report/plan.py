"""The measured plan: a top view that people can read before they read anything else."""

import io
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from indoorfit.files import replace_file
from indoorfit.model import FitResult

from .arrows import INFERRED, WARNED, draw_placement
from .caption import caption, heading
from .display import Dots, Item, Label, Picture, Region, Stroke
from .doorways import draw_doorways
from .layout import Layout, lay_out
from .names import FLOOR
from .outline import BAND, Outline, warned_walls
from .raster import to_image
from .svg import to_svg

_PAPER = "#ffffff"
_WALL = "#2a2d30"
_SOLID = "#cfcbc3"
_DOT_COLOURS = ("#c9cacb", "#a9b2ba", "#7f90a0")
"""From few to many points; all fainter than any line."""

_DOT_CELL = 2.5
_MAX_DOTS = 15_000
_CLEAR_M = 0.3
"""Floor and ceiling points would cover the plan, so this much is left out at both ends."""

_MARGIN = 28.0


def plan_svg(result: FitResult, points_m: Float[np.ndarray, "points 3"] | None = None) -> str:
    """The plan as one self-contained SVG element.

    Args:
        result: what to draw.
        points_m: the scan, scan frame, metres; drawn faintly behind the plan.
    """
    return to_svg(plan_picture(result, points_m))


def write_plan_png(
    path: Path, result: FitResult, points_m: Float[np.ndarray, "points 3"] | None = None
) -> None:
    """Write the same plan as a PNG image.

    Raises:
        OutputError: the file cannot be written.
    """
    write_picture_png(path, plan_picture(result, points_m))


def write_picture_png(path: Path, picture: Picture) -> None:
    """Write a plan that is laid out already, so that both formats can share one layout.

    Raises:
        OutputError: the file cannot be written.
    """
    content = io.BytesIO()
    # Level 6 takes three times as long for 5 % less.
    to_image(picture).save(content, "PNG", compress_level=3)
    replace_file(path, content.getvalue())


def plan_picture(
    result: FitResult, points_m: Float[np.ndarray, "points 3"] | None = None, layout: Layout | None = None
) -> Picture:
    """Draw the plan: walls, then names, then dimensions, each where there is space left.

    Args:
        result: what to draw.
        points_m: the scan, scan frame, metres; drawn faintly behind the plan.
        layout: where everything goes; laid out for the screen where it is not given.
    """
    plan = layout or lay_out(result)
    outline = plan.outline
    arrows = [item for placement in plan.placements for item in draw_placement(placement)]
    drawing = [
        *_rooms(outline, warned_walls(result)),
        *scan_dots(result, outline, points_m),
        *_steps(outline),
        *_walls(outline),
    ]
    drawing += draw_doorways(result, outline)
    # Texts last: no line may cross one, and their halos must not eat into a wall that comes later.
    marks = [*plan.names, *arrows]
    drawing += [item for item in marks if not isinstance(item, Label)]
    drawing += [item for item in marks if isinstance(item, Label)]
    return _sheet(result, plan, drawing)


def _sheet(result: FitResult, plan: Layout, drawing: list[Item]) -> Picture:
    """Put heading, drawing and caption below each other on a sheet that fits them."""
    outline = plan.outline
    cramped = [f"{span.label} m" for span in plan.cramped]
    boxes = np.array([item.box() for item in drawing if not isinstance(item, Dots)])
    left, top = boxes[:, :2].min(axis=0)
    right, bottom = boxes[:, 2:].max(axis=0)
    width = max(float(right - left), 560.0)
    head, head_height = heading(result)
    foot, foot_height = caption(result, outline.scale, width, cramped, plan.denominator)
    width = max(width, *(item.box()[2] for item in [*head, *foot]))
    at_drawing = np.array([_MARGIN + 0.5 * (width - (right - left)) - left, _MARGIN + head_height - top])
    at_foot = np.array([_MARGIN, _MARGIN + head_height + (bottom - top) + 30.0])
    items = [
        *(item.moved(np.array([_MARGIN, _MARGIN])) for item in head),
        *(item.moved(at_drawing) for item in drawing),
        *(item.moved(at_foot) for item in foot),
    ]
    height = float(at_foot[1]) + foot_height + _MARGIN
    counts = f"{len(result.rooms)} room(s) with {len(outline.walls) + len(outline.oblique)} walls"
    description = f"Top view of {counts} and the distances between them."
    return Picture(width + 2 * _MARGIN, height, _PAPER, tuple(items), "Measured plan", description)


def _rooms(outline: Outline, warned: set[str]) -> list[Item]:
    """Grey bands around the rooms, coloured where a warning names the wall; floors over inner halves."""
    polygons = [rings for room in outline.floors.values() for rings in room]
    bands: list[Item] = [Region(rings, None, _SOLID, 2 * BAND) for rings in polygons]
    bands += [Region((partition,), _SOLID) for partition in outline.partitions()]
    bands += [Stroke(w.points(), WARNED, 2 * BAND, shows=(w.id,)) for w in outline.walls if w.id in warned]
    return bands + [Region(rings, FLOOR) for rings in polygons]


def _walls(outline: Outline) -> list[Item]:
    items: list[Item] = []
    for wall in sorted((*outline.walls, *outline.oblique), key=lambda wall: wall.inferred):
        if wall.inferred:
            items.append(Stroke(wall.points(), _PAPER, 3.0))
            items.append(Stroke(wall.points(), INFERRED, 2.2, (8.0, 5.0), (wall.id,)))
        else:
            # Square ends, so that corners close.
            along = wall.points()[1] - wall.points()[0]
            reach = np.array([-1.0, 1.0])[:, None] * along / np.hypot(*along)
            items.append(Stroke(wall.points() + reach, _WALL, 2.0, shows=(wall.id,)))
    return items


def _steps(outline: Outline) -> list[Item]:
    """The sides of levels as thin lines, dashed where they are overhead, as in any floor plan."""
    return [
        Stroke(
            step.points(), INFERRED if step.inferred else _WALL, 1.0, (5.0, 3.0) if step.overhead else None
        )
        for step in outline.steps
    ]


def scan_dots(
    result: FitResult, outline: Outline, points_m: Float[np.ndarray, "points 3"] | None
) -> list[Item]:
    """The scan between floor and ceiling as faint dots, one per cell of the page, darker where dense."""
    if points_m is None or not len(points_m):
        return []
    manhattan = result.frame.to_manhattan(points_m)
    low, high = outline.z_range_m
    clear = min(_CLEAR_M, 0.25 * (high - low))
    kept = manhattan[(manhattan[:, 2] > low + clear) & (manhattan[:, 2] < high - clear)]
    page = outline.to_page(kept)
    x0, y0, x1, y1 = outline.room_box()
    near = ((page > [x0 - 14.0, y0 - 14.0]) & (page < [x1 + 14.0, y1 + 14.0])).all(axis=1)
    centres, counts = _thinned(page[near])
    if not len(centres):
        return []
    limits = np.quantile(counts, [0.6, 0.9])
    level = (counts > limits[0]).astype(int) + (counts > limits[1])
    return [Dots(centres[level == k], colour, 1.6) for k, colour in enumerate(_DOT_COLOURS)]


def _thinned(
    points: Float[np.ndarray, "points 2"],
) -> tuple[Float[np.ndarray, "cells 2"], Int[np.ndarray, " cells"]]:
    """One mean point per occupied cell of the page, and the number of points behind it."""
    cells = np.floor(points / _DOT_CELL).astype(np.int64)
    low = cells.min(axis=0, initial=0)
    height = int(cells[:, 1].max(initial=0) - low[1]) + 1
    keys = (cells[:, 0] - low[0]) * height + (cells[:, 1] - low[1])
    counts = np.bincount(keys)
    used = np.flatnonzero(counts)
    used = used[:: -(-len(used) // _MAX_DOTS) or 1]
    sums = [np.bincount(keys, weights=points[:, k]) for k in range(2)]
    return np.column_stack([total[used] / counts[used] for total in sums]), counts[used]
