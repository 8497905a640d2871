"""Two pictures of a batch: how large the errors are, and whether the intervals are right."""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float
from scipy.special import ndtr, ndtri

from indoorfit.report import Item, Label, Picture, Region, Stroke, to_svg

from .collect import Record

_COLOURS = ("#0f6ab4", "#b4540a", "#3f7d4e", "#7a4b94", "#6b6f73")
_LINE, _QUIET, _GRID = "#2a2d30", "#5c646b", "#dcd8cf"
_BOX = (70.0, 30.0, 480.0, 330.0)
"""Left, top, right, bottom of the frame on a page of 640 x 390."""


def error_picture(lengths: Sequence[Record]) -> str:
    """Share of the lengths whose error is below so many millimetres, one curve per configuration, as SVG."""
    errors_mm = {name: np.sort(np.abs([1e3 * r["error_m"] for r in own])) for name, own in _by(lengths)}
    low, high = -1.0, 3.0

    def x_of(mm: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        return (np.log10(np.clip(mm, 10.0**low, 10.0**high)) - low) / (high - low)

    curves = []
    for name, errors in errors_mm.items():
        share = np.arange(len(errors) + 1) / len(errors)
        x = np.concatenate([[0.0], x_of(errors), [1.0]])
        steps_x, steps_y = np.repeat(x, 2)[1:-1], np.repeat(share, 2)
        curves.append((f"{name} ({len(errors)})", np.stack([steps_x, steps_y], axis=1)))
    shown_mm = np.array([0.1, 1.0, 10.0, 100.0, 1000.0])
    ticks = [(float(x), f"{mm:g}") for x, mm in zip(x_of(shown_mm), shown_mm, strict=True)]
    return _chart("Errors", "absolute error, mm", "share of lengths below", ticks, curves, False)


def reliability_picture(lengths: Sequence[Record]) -> str | None:
    """Share of references held against the nominal coverage of the interval, one curve per configuration.

    Every interval is shrunk and stretched as a normal one would be. On the diagonal intervals are right,
    below it too narrow. The references' own uncertainty is added to the intervals. None without any interval.
    """
    judged = [r for r in lengths if r["held"] is not None]
    if not judged:
        return None
    nominal = np.concatenate([np.linspace(0.0, 0.9, 19), [0.925, 0.95, 0.97, 0.98, 0.99, 0.995, 0.999]])
    curves = []
    for name, own in _by(judged):
        reached = np.array([_reached(record) for record in own])
        share = np.mean(reached[None, :] <= nominal[:, None], axis=1)
        curves.append((f"{name} ({len(own)})", np.stack([nominal, share], axis=1)))
    ticks = [(share, f"{100 * share:g}") for share in (0.0, 0.25, 0.5, 0.75, 0.95)]
    return _chart("Reliability", "nominal coverage, %", "share of references held", ticks, curves, True)


def _reached(record: Record) -> float:
    """The smallest nominal coverage whose interval holds the reference."""
    quantile = float(ndtri(0.5 + 0.5 * record["level"]))
    above = record["reference_m"] > record["value_m"]
    half_m = record["high_m"] - record["value_m"] if above else record["value_m"] - record["low_m"]
    std_m = float(np.hypot(max(half_m, 1e-9) / quantile, record["reference_std_m"]))
    return float(2.0 * ndtr(abs(record["error_m"]) / std_m) - 1.0)


def _by(lengths: Sequence[Record]) -> list[tuple[str, list[Record]]]:
    names = list(dict.fromkeys(r["config"] for r in lengths))
    return [(name, [r for r in lengths if r["config"] == name]) for name in names]


def _chart(
    title: str,
    x_title: str,
    y_title: str,
    ticks: list[tuple[float, str]],
    curves: list[tuple[str, Float[np.ndarray, "_ 2"]]],
    diagonal: bool,
) -> str:
    left, top, right, bottom = _BOX

    def on_page(points: Float[np.ndarray, "points 2"]) -> Float[np.ndarray, "points 2"]:
        return np.array([left, bottom]) + points * np.array([right - left, top - bottom])

    items: list[Item] = [*_grid(ticks, on_page)]
    if diagonal:
        items.append(Stroke(on_page(np.array([[0.0, 0.0], [1.0, 1.0]])), _QUIET, 1.0, (4.0, 4.0)))
    for k, (name, points) in enumerate(curves):
        colour = _COLOURS[k % len(_COLOURS)]
        y = top + 14.0 + 20.0 * k
        items.append(Stroke(on_page(points), colour, 1.8))
        items.append(Stroke(np.array([[right + 14.0, y], [right + 34.0, y]]), colour, 2.4))
        items.append(Label(name, (right + 40.0, y), 11.0, _LINE, "start"))
    frame = np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
    items.append(Region((frame,), None, _LINE, 1.0))
    items.append(Label(x_title, (0.5 * (left + right), bottom + 40.0), 12.0, _LINE))
    items.append(Label(y_title, (22.0, 0.5 * (top + bottom)), 12.0, _LINE, "middle", upright=True))
    return to_svg(Picture(640.0, 390.0, "#ffffff", tuple(items), title, f"{y_title} over {x_title}"))


def _grid(ticks: list[tuple[float, str]], on_page: Callable) -> list[Item]:
    items: list[Item] = []
    for x, text in ticks:
        line = on_page(np.array([[x, 0.0], [x, 1.0]]))
        items.append(Stroke(line, _GRID, 0.8))
        items.append(Label(text, (float(line[0, 0]), float(line[0, 1]) + 16.0), 11.0, _QUIET))
    for y in (0.0, 0.25, 0.5, 0.75, 0.95, 1.0):
        line = on_page(np.array([[0.0, y], [1.0, y]]))
        items.append(Stroke(line, _GRID, 0.8))
        items.append(Label(f"{100 * y:g}", (float(line[0, 0]) - 8.0, float(line[0, 1])), 11.0, _QUIET, "end"))
    return items
