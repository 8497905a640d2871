"""Pages one can look at: truth and model over the points, and the reliability of the intervals."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from benchmarks.outcome import Outcome, PlanPicture
from indoorfit.evaluate import summarise

_PANEL = (420, 400)
_CAPTION = 84
_COLUMNS = 4
_TRUE, _TRUE_LOST = "#9fdcae", "#5d9bee"
_MODEL = {"observed": "#222222", "inferred": "#e08a00", "wrong": "#d81b1b"}
_LEGEND = (
    ("true wall, found", _TRUE),
    ("true wall, not found", _TRUE_LOST),
    ("model, observed", _MODEL["observed"]),
    ("model, inferred", _MODEL["inferred"]),
    ("model, wrong", _MODEL["wrong"]),
)


def overlay_page(outcomes: Sequence[Outcome], title: str, path: Path, n_panels: int = 8) -> None:
    """Plans of some rooms of a suite, those that went wrong first.

    Args:
        outcomes: of one suite and one way of fitting.
        title: printed on top.
        path: PNG to write.
        n_panels: at most.
    """
    shown = sorted((o for o in outcomes if o.picture is not None), key=lambda o: (o.right, -_rmse_mm(o)))
    # Two that are right for comparison, the worst of all others.
    wrong = [outcome for outcome in shown if not outcome.right][: n_panels - 2]
    shown = [*wrong, *[outcome for outcome in shown if outcome.right][: n_panels - len(wrong)]]
    rows = max(1, -(-len(shown) // _COLUMNS))
    page = Image.new("RGB", (_COLUMNS * _PANEL[0], 50 + rows * _PANEL[1]), "white")
    pen = ImageDraw.Draw(page)
    pen.text((10, 8), title, fill="black", font=_font(16))
    for k, (name, colour) in enumerate(_LEGEND):
        pen.line((10 + 190 * k, 38, 30 + 190 * k, 38), fill=colour, width=4)
        pen.text((36 + 190 * k, 30), name, fill=colour, font=_font(12))
    for k, outcome in enumerate(shown):
        corner = ((k % _COLUMNS) * _PANEL[0], 50 + (k // _COLUMNS) * _PANEL[1])
        page.paste(_panel(outcome), corner)
    page.save(path)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)


def _rmse_mm(outcome: Outcome) -> float:
    if outcome.comparison is None or not outcome.comparison.lengths:
        return 0.0
    return 1e3 * summarise(outcome.comparison.lengths).rmse_m


def _panel(outcome: Outcome) -> Image.Image:
    panel = Image.new("RGB", _PANEL, "white")
    pen = ImageDraw.Draw(panel)
    assert outcome.picture is not None, "the caller shows rooms with a picture only"
    _draw_plan(pen, outcome.picture)
    said = [f"seed {outcome.job.seed}: " + ("right" if outcome.right else "WRONG")]
    if outcome.comparison is not None:
        c = outcome.comparison
        said[0] += f", IoU {c.footprint_iou:.3f} / {c.solid_iou:.3f}, RMSE {_rmse_mm(outcome):.1f} mm"
    said += [fault.splitlines()[0][:72] for fault in outcome.faults[:3]]
    if len(outcome.faults) > 3:
        said[-1] += f" (+{len(outcome.faults) - 3})"
    if outcome.notes:
        said.append(", ".join(outcome.notes)[:72])
    for k, line in enumerate(said[:5]):
        pen.text((8, _PANEL[1] - _CAPTION + 15 * k), line, fill="black", font=_font(11))
    return panel


def _draw_plan(pen: ImageDraw.ImageDraw, picture: PlanPicture) -> None:
    lines = [line[:4] for line in (*picture.true_lines_m, *picture.model_lines_m)]
    ends = np.array(lines).reshape(-1, 2)
    low, high = ends.min(axis=0) - 0.4, ends.max(axis=0) + 0.4
    space = np.array([_PANEL[0] - 16, _PANEL[1] - _CAPTION - 16])
    scale = float((space / (high - low)).min())

    def place(x: float, y: float) -> tuple[float, float]:
        return 8 + (x - low[0]) * scale, 8 + (high[1] - y) * scale

    for *line, found in picture.true_lines_m:
        pen.line((*place(*line[:2]), *place(*line[2:])), fill=_TRUE if found else _TRUE_LOST, width=6)
    for x, y in picture.dots_m.tolist():
        if low[0] < x < high[0] and low[1] < y < high[1]:
            u, v = place(x, y)
            pen.rectangle((u, v, u + 1, v + 1), fill="#9a9a9a")
    for *line, state in picture.model_lines_m:
        pen.line((*place(*line[:2]), *place(*line[2:])), fill=_MODEL[state], width=2)


def reliability_picture(tables: Mapping[str, Mapping[float, Mapping[str, float]]], path: Path) -> None:
    """Share of intervals that hold the truth against the nominal one, with 95 % intervals of that share.

    Args:
        tables: by name of the curve, then by level: `share`, `low`, `high`.
        path: PNG to write.
    """
    size, left, top = 460, 60, 20
    page = Image.new("RGB", (size + left + 320, max(size + 80, 60 + 18 * len(tables))), "white")
    pen = ImageDraw.Draw(page)

    def place(x: float, y: float) -> tuple[float, float]:
        return left + x * size, top + (1.0 - y) * size

    pen.rectangle((*place(0, 1), *place(1, 0)), outline="#888888")
    pen.line((*place(0, 0), *place(1, 1)), fill="#888888")
    for tick in (0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 0.95, 1.0):
        x, y = place(tick, 0.0)
        pen.text((x - 10, y + 6), f"{tick:g}", fill="black", font=_font(11))
        pen.text((left - 34, place(0.0, tick)[1] - 7), f"{tick:g}", fill="black", font=_font(11))
    pen.text(
        (left + 150, top + size + 30), "nominal coverage; upwards: share held", fill="black", font=_font(13)
    )
    for k, (name, table) in enumerate(tables.items()):
        colour = f"hsl({360 * k // max(len(tables), 1)}, 70%, 40%)"
        points = [place(level, held["share"]) for level, held in table.items() if held["n"]]
        # Side by side, or the bars of all curves would hide each other.
        shift = 16.0 * (k / max(len(tables) - 1, 1) - 0.5)
        for level, held in table.items():
            (x, low), (_, high) = place(level, held["low"]), place(level, held["high"])
            pen.line((x + shift, low, x + shift, high), fill=colour)
        if len(points) > 1:
            pen.line([place(0, 0), *points, place(1, 1)], fill=colour, width=2)
        for x, y in points:
            pen.ellipse((x - 3, y - 3, x + 3, y + 3), fill=colour)
        shares = ", ".join(f"{level:g}: {held['share']:.3f}" for level, held in table.items() if held["n"])
        pen.text((left + size + 20, top + 18 * k), f"{name}  {shares}", fill=colour, font=_font(11))
    page.save(path)
