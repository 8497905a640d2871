"""The report as one page that needs nothing else: its scripts are inside, no fonts, no network."""

from html import escape

from indoorfit.model import FitResult

from .dimension_section import dimension_section, interval_head, number_cells
from .doorways import evidence_text
from .facts import input_name
from .html_table import Cell, Row, html_table, pairs
from .markup import html_page
from .residual_figures import histogram_svg, residual_maps
from .residuals import Residuals
from .scene import scene_data
from .tape import tape_section
from .textures import texture_rows
from .viewer_section import VIEW, policy, scripts


def report_html(
    result: FitResult,
    plan_svg: str,
    residuals: Residuals | None = None,
) -> str:
    """The report of one fit.

    Args:
        result: what to report; all its texts are escaped.
        plan_svg: the plan, as `report.plan_svg` makes it; put into the page as it stands.
        residuals: of the scan, as `report.residuals_of` finds them; without them their section is left out.
    """
    title = f"Measured model of {input_name(result)}" if input_name(result) else "Measured model"
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="quiet">{escape(_summary(result))}</p>',
        *_warnings(result),
        VIEW,
        dimension_section(result),
        *tape_section(result),
        f'<section id="plan"><h2>Plan</h2><div class="plan">{plan_svg}</div></section>',
        _rooms(result),
        _doorways(result),
        _residuals(residuals),
        _noise(result),
        _textures(result),
        _provenance(result),
    ]
    return html_page(title, body, policy(), scripts(scene_data(result)))


def _summary(result: FitResult) -> str:
    n_rooms, n_walls = len(result.rooms), sum(face.kind == "wall" for face in result.faces)
    rooms = "1 room" if n_rooms == 1 else f"{n_rooms} rooms"
    inferred = sum(face.status == "inferred" for face in result.faces)
    seen = f", {inferred} of all faces inferred" if inferred else ", every face observed"
    return f"{rooms}, {n_walls} walls{seen}; {result.method} fit. All lengths in metres."


def _warnings(result: FitResult) -> list[str]:
    lines = [f"<code>{escape(note.code)}</code> {escape(note.message)}" for note in result.notes]
    if not result.converged:
        lines.insert(0, "The fit did not converge or a room is not closed: use these numbers with care.")
    return [f'<p class="warning">{line}</p>' for line in lines]


def _rooms(result: FitResult) -> str:
    rows = [
        Row((Cell(room.id, "id"), Cell(name), *number_cells(quantity, 2, 3), Cell(unit)))
        for room in result.rooms
        for name, quantity, unit in (
            ("Floor area", room.floor_area, "m²"),
            ("Volume", room.volume, "m³"),
            ("Perimeter", room.perimeter, "m"),
        )
    ]
    head = ("Room", "What", "Value", interval_head(result.level, "as the value"), "Unit")
    table = html_table(head, rows, "Rooms with their intervals", sortable=True)
    return f'<section id="rooms"><h2>Rooms</h2>\n{table}</section>'


def _doorways(result: FitResult) -> str:
    if not result.adjacency:
        return ""
    rows = [
        Row(
            (
                Cell(doorway.id, "id"),
                Cell(" and ".join(doorway.rooms)),
                Cell(" and ".join(doorway.faces)),
                Cell(f"{doorway.width_m:.2f}", "number", sort=doorway.width_m),
                Cell(evidence_text(doorway.evidence)),
            )
        )
        for doorway in result.adjacency
    ]
    head = ("Door", "Joins", "Through", "Width, m, about", "Evidence")
    table = html_table(head, rows, "Doors between rooms")
    return f'<section id="doors"><h2>Doors between rooms</h2>\n{table}</section>'


def _residuals(residuals: Residuals | None) -> str:
    if residuals is None:
        return ""
    return (
        '<section id="residuals"><h2>Residuals</h2>'
        f"<p>Distances of {residuals.n_points} points from the faces that they belong to. Half of them are "
        f"nearer than {0.6745e3 * residuals.std_m:.1f} mm to the middle of the bars; the line is a normal "
        f"distribution with that spread (standard deviation {1e3 * residuals.std_m:.1f} mm). Bars far above "
        "it at the sides are skirting, doors, furniture, or walls that are not flat.</p>"
        f'<div class="plan">{histogram_svg(residuals)}</div>'
        "<h3>Where a wall bows</h3><p>Each face as seen from inside the room (floors and ceilings as on the "
        "plan), with the median residual of every small square. A slow change of colour is a wall that bows "
        "or leans; a sharp step is something in front of it, or a place where the scan has slipped. Below "
        f"each stands the range of nine tenths of its squares.</p>{residual_maps(residuals)}</section>"
    )


def _textures(result: FitResult) -> str:
    looks = ("id", "", "", "number", "number", "number")
    rows = [
        Row(tuple(Cell(text, look) for text, look in zip(row, looks, strict=True)))
        for row in texture_rows(result)
    ]
    if not rows:
        return ""
    head = ("Face", "Image", "Colours from", "Pixel, cm", "Seen, %", "Filled, %")
    return (
        f'<section id="images"><h2>Textures</h2>\n{html_table(head, rows, "Textures of the faces")}\n'
        '<p class="quiet">What was neither seen nor filled is transparent in the image.</p></section>'
    )


def _noise(result: FitResult) -> str:
    explanation = result.noise.get("explanation")
    plain = {key: value for key, value in result.noise.items() if key != "explanation"}
    parts = [f"<p>{escape(str(explanation))}</p>"] if explanation else []
    if plain:
        table = html_table(("Noise model", "Value"), pairs(plain), "Noise model")
        parts.append(f"<details><summary>Noise model in numbers</summary>{table}</details>")
    return f'<section id="noise"><h2>Noise and intervals</h2>{"".join(parts)}</section>'


def _provenance(result: FitResult) -> str:
    table = html_table(("What", "Value"), pairs(result.provenance), "Provenance")
    return (
        '<section id="provenance"><h2>Provenance</h2>'
        f"<details><summary>Input, versions and settings</summary>{table}</details></section>"
    )
