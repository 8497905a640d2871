"""The report as one page that needs nothing else: no scripts, no fonts, no network."""

import json
import math
from collections.abc import Mapping
from html import escape
from typing import Any

from indoorfit.export import quantity_text
from indoorfit.model import FitResult, Quantity

from .doorways import evidence_text
from .facts import input_name, level_text
from .markup import html_page, html_table
from .table import what_is_measured
from .tape import tape_section
from .textures import texture_rows


def report_html(result: FitResult, plan_svg: str) -> str:
    """The report of one fit.

    Args:
        result: what to report; all its texts are escaped.
        plan_svg: the plan, as `report.plan_svg` makes it; put into the page as it stands.
    """
    title = f"Measured model of {input_name(result)}" if input_name(result) else "Measured model"
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="quiet">{escape(_summary(result))}</p>',
        *_warnings(result),
        f'<section><h2>Plan</h2><div class="plan">{plan_svg}</div></section>',
        *_dimensions(result),
        *tape_section(result),
        *_rooms(result),
        *_doorways(result),
        *_textures(result),
        *_noise(result),
        *_provenance(result),
    ]
    return html_page(title, body)


def _summary(result: FitResult) -> str:
    n_rooms, n_walls = len(result.rooms), sum(face.kind == "wall" for face in result.faces)
    rooms = "1 room" if n_rooms == 1 else f"{n_rooms} rooms"
    inferred = sum(face.status == "inferred" for face in result.faces)
    seen = f", {inferred} of all faces inferred" if inferred else ", every face observed"
    n_steps = sum(face.kind == "step" for face in result.faces)
    steps = f", {n_steps} upright faces of steps and beams" if n_steps else ""
    return f"{rooms}, {n_walls} walls{steps}{seen}; {result.method} fit. All lengths in metres."


def _warnings(result: FitResult) -> list[str]:
    lines = [f"<code>{escape(note.code)}</code> {escape(note.message)}" for note in result.notes]
    if not result.converged:
        lines.insert(0, "The fit did not converge or a room is not closed: use these numbers with care.")
    return [f'<p class="warning">{line}</p>' for line in lines]


def _dimensions(result: FitResult) -> list[str]:
    several = len(result.rooms) > 1
    rows = [
        (
            ("id", d.id),
            ("", what_is_measured(d, several)),
            *_number_cells(d.quantity, 3, 4),
            *_budget_cells(d.quantity),
            ("", d.loa or ""),
            (d.status, d.status),
        )
        for d in result.dimensions
    ]
    level = level_text(result.level)
    head = (
        "Id", "What", "Value, m", f"Interval, {level}", "u scan, mm", "u scale, mm", "u definition, mm",
        "k", "Degrees of freedom", "Accuracy", "Status",
    )  # fmt: skip
    return [
        "<section><h2>Dimensions</h2>",
        html_table(head, rows),
        '<p class="quiet">Clear lengths between mean wall planes. The columns u are standard uncertainties: '
        "what the residuals of the scan show, a possible error of its scale, and where the wall is (plaster, "
        "skirting). Their squares add up; k times the root is half the interval (JCGM 100). Accuracy is the "
        "USIBD Level of Accuracy that the half width at 95 % belongs to: LOA20 15 to 50 mm, LOA30 5 to 15, "
        "LOA40 1 to 5 mm, LOA50 below 1 mm; LOA10 is worse than 50 mm. An inferred dimension ends at a face "
        "without points.</p></section>",
    ]


def _budget_cells(quantity: Quantity) -> tuple[tuple[str, str], ...]:
    """Parts of the standard uncertainty in millimetres, coverage factor, degrees of freedom."""
    factor, budget = quantity.coverage_factor, quantity.budget
    k = "" if factor is None else f"{factor:.2f}"
    if budget is None:
        return (("number", ""),) * 3 + (("number", k), ("number", ""))
    parts = (budget.data_std, budget.scale_std, budget.definition_std)
    dof = f"{budget.effective_dof:.0f}" if math.isfinite(budget.effective_dof) else "∞"
    return (*(("number", f"{1e3 * part:.2g}") for part in parts), ("number", k), ("number", dof))


def _rooms(result: FitResult) -> list[str]:
    rows = [
        (("id", room.id), ("", name), *_number_cells(quantity, 2, 3), ("", unit))
        for room in result.rooms
        for name, quantity, unit in (
            ("Floor area", room.floor_area, "m²"),
            ("Volume", room.volume, "m³"),
            ("Perimeter", room.perimeter, "m"),
        )
    ]
    head = ("Room", "What", "Value", f"Interval, {level_text(result.level)}", "Unit")
    return ["<section><h2>Rooms</h2>", html_table(head, rows), "</section>"]


def _textures(result: FitResult) -> list[str]:
    kinds = ("id", "", "", "number", "number", "number")
    rows = [tuple(zip(kinds, row, strict=True)) for row in texture_rows(result)]
    if not rows:
        return []
    head = ("Face", "Image", "Colours from", "Pixel, cm", "Seen, %", "Filled, %")
    return [
        "<section><h2>Textures</h2>",
        html_table(head, rows),
        '<p class="quiet">What was neither seen nor filled is transparent in the image.</p></section>',
    ]


def _doorways(result: FitResult) -> list[str]:
    if not result.adjacency:
        return []
    rows = [
        (
            ("id", doorway.id),
            ("", " and ".join(doorway.rooms)),
            ("", " and ".join(doorway.faces)),
            ("number", f"{doorway.width_m:.2f}"),
            ("", evidence_text(doorway.evidence)),
        )
        for doorway in result.adjacency
    ]
    head = ("Door", "Joins", "Through", "Width, m, about", "Evidence")
    return ["<section><h2>Doors between rooms</h2>", html_table(head, rows), "</section>"]


def _noise(result: FitResult) -> list[str]:
    explanation = result.noise.get("explanation")
    plain = {key: value for key, value in result.noise.items() if key != "explanation"}
    parts = ["<section><h2>Noise and intervals</h2>"]
    if explanation:
        parts.append(f"<p>{escape(str(explanation))}</p>")
    if plain:
        parts.append(html_table(("Noise model", "Value"), _pairs(plain)))
    return [*parts, "</section>"]


def _provenance(result: FitResult) -> list[str]:
    table = html_table(("What", "Value"), _pairs(result.provenance))
    return ["<section><h2>Provenance</h2>", table, "</section>"]


def _number_cells(quantity: Quantity, min_decimals: int, max_decimals: int) -> tuple[tuple[str, str], ...]:
    text = quantity_text(quantity, min_decimals, max_decimals)
    return ("number", text.value), ("number", text.spread)


def _pairs(values: Mapping[str, Any]) -> list[tuple[tuple[str, str], tuple[str, str]]]:
    """Nested settings as dotted names, so that a long configuration stays readable."""
    rows = []
    for key, value in values.items():
        if isinstance(value, Mapping) and value:
            rows += [(("", f"{key}.{name[1]}"), cell) for name, cell in _pairs(value)]
        else:
            text = value if isinstance(value, str) else json.dumps(value, default=str)
            rows.append((("", str(key)), ("", text)))
    return rows
