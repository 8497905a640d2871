"""The plans of two models over each other, and the intervals of their lengths below."""

import numpy as np
from jaxtyping import Float

from indoorfit.evaluate import Comparison
from indoorfit.model import Dimension, FitResult

from .display import Item, Label, Picture, Region, Stroke
from .names import FLOOR
from .outline import Outline, outline_of
from .plan import scan_dots
from .versus import length_pairs

_INK, _QUIET, _PAPER = "#2a2d30", "#6a7076", "#ffffff"
_JOINT, _GREEDY = "#1f5f8b", "#c8601a"
_MARGIN, _ROW = 28.0, 26.0
_LABELS, _CHART = 250.0, 420.0
"""Widths of the chart's texts and of its bars."""
_SPAN_SHARE = 0.9
"""Of the chart's half width that the farthest interval end takes."""


def versus_picture(
    joint: FitResult,
    greedy: FitResult,
    matched: Comparison,
    points_m: Float[np.ndarray, "points 3"] | None = None,
) -> Picture:
    """Draw both plans in the joint model's frame and, for each length that both have, both intervals.

    Args:
        joint, greedy: of the same scan.
        matched: which faces and lengths of the two belong together.
        points_m: the scan, scan frame, metres; drawn faintly behind the plans.
    """
    outline = outline_of(joint)
    plan: list[Item] = [Region(rings, FLOOR) for room in outline.floors.values() for rings in room]
    plan += scan_dots(joint, outline, points_m)
    plan += [Stroke(wall.points(), _JOINT, 3.0) for wall in (*outline.walls, *outline.oblique)]
    plan += _other_walls(joint, greedy, outline)
    boxes = np.array([item.box() for item in plan if isinstance(item, Stroke)])
    (left, top), (right, bottom) = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
    both = length_pairs(joint, greedy, matched)
    pairs = [(a, b) for a, b in both if a is not None and b is not None]
    chart, chart_height = _chart(pairs)
    width = max(float(right - left), _LABELS + _CHART + 20.0)
    shift = np.array([_MARGIN + 0.5 * (width - (right - left)) - left, _MARGIN + 62.0 - top])
    below = _MARGIN + 62.0 + float(bottom - top) + 44.0
    items: list[Item] = [
        Label("Joint and greedy fit of one scan", (_MARGIN, _MARGIN + 9.0), 18.0, _INK, "start"),
        *_legend(_MARGIN, _MARGIN + 36.0),
        *(item.moved(shift) for item in plan),
        *(item.moved(np.array([_MARGIN, below])) for item in chart),
    ]
    about = f"Plans of both models over each other, and {len(pairs)} lengths with their intervals."
    size = (width + 2 * _MARGIN, below + chart_height + _MARGIN)
    return Picture(*size, _PAPER, tuple(items), "Joint and greedy fit", about)


def _legend(x: float, y: float) -> list[Item]:
    items: list[Item] = []
    for name, colour, dash in (("joint", _JOINT, None), ("greedy", _GREEDY, (7.0, 4.0))):
        items.append(Stroke(np.array([[x, y], [x + 34.0, y]]), colour, 3.0, dash))
        items.append(Label(name, (x + 42.0, y), 11.5, _INK, "start"))
        x += 120.0
    return items


def _other_walls(joint: FitResult, greedy: FitResult, outline: Outline) -> list[Item]:
    """The greedy walls from above, in the joint model's frame."""
    items: list[Item] = []
    for face in greedy.faces:
        if face.kind == "wall":
            corners = outline.to_page(joint.frame.to_manhattan(face.rings_m[0]))
            # From above a wall is a line: its two corners that are farthest from each other.
            apart = np.linalg.norm(corners[:, None] - corners[None], axis=2)
            i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
            items.append(Stroke(corners[[i, j]], _GREEDY, 2.2, (7.0, 4.0)))
    return items


def _chart(pairs: list[tuple[Dimension, Dimension]]) -> tuple[list[Item], float]:
    """Both intervals of every length, as distances from the joint value; and the chart's height."""
    if not pairs:
        return [Label("No length is common to both.", (0.0, 0.0), 11.5, _INK, "start")], _ROW
    ends_m = [
        end - a.quantity.value
        for a, b in pairs
        for d in (a, b)
        for end in (d.quantity.interval.low, d.quantity.interval.high, d.quantity.value)
    ]
    reach_m = max(max(map(abs, ends_m)), 1e-4)
    zero, unit = _LABELS + 0.5 * _CHART, _SPAN_SHARE * 0.5 * _CHART / reach_m
    level = f"{100.0 * pairs[0][0].quantity.interval.level:g} %"
    title = f"Lengths relative to the joint value, with intervals at {level}"
    items: list[Item] = [Label(title, (0.0, 0.0), 13.0, _INK, "start")]
    bottom = 24.0 + _ROW * len(pairs)
    items += _scale(zero, unit, reach_m, bottom)
    for k, (a, b) in enumerate(pairs):
        y = 30.0 + _ROW * k + 0.3 * _ROW
        ids = a.id if a.id == b.id else f"{a.id} / {b.id}"
        where = f"{a.faces[0]} to {a.faces[1]}"
        items.append(Label(f"{ids}   {where}   {a.quantity.value:.3f} m", (0.0, y), 11.0, _INK, "start"))
        for dimension, colour, shift in ((a, _JOINT, -4.5), (b, _GREEDY, 4.5)):
            low, high, value = (
                zero + unit * (x - a.quantity.value)
                for x in (
                    dimension.quantity.interval.low,
                    dimension.quantity.interval.high,
                    dimension.quantity.value,
                )
            )
            items.append(Stroke(np.array([[low, y + shift], [high, y + shift]]), colour, 2.4))
            tick = np.array([[value, y + shift - 4.0], [value, y + shift + 4.0]])
            items.append(Stroke(tick, colour, 2.4))
    return items, bottom + 30.0


def _scale(zero: float, unit: float, reach_m: float, bottom: float) -> list[Item]:
    """A line at the joint value and labelled lines at round distances from it."""
    power = 10.0 ** np.floor(np.log10(reach_m))
    step_m = float(max(s * power for s in (0.2, 0.5, 1.0) if s * power <= reach_m))
    items: list[Item] = []
    for k in range(-int(reach_m / step_m), int(reach_m / step_m) + 1):
        x = zero + unit * k * step_m
        colour, thick = (_QUIET, 1.2) if k == 0 else ("#dcdad5", 0.8)
        items.append(Stroke(np.array([[x, 18.0], [x, bottom]]), colour, thick))
        text = "0 mm" if k == 0 else f"{1e3 * k * step_m:+.3g}"
        items.append(Label(text, (x, bottom + 12.0), 10.0, _QUIET))
    return items
