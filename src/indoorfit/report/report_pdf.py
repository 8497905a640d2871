"""The report on paper: plan, tables, warnings and provenance on sheets of A4, by reportlab."""

import io
import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from indoorfit.export import optional_module, quantity_text
from indoorfit.model import FitResult, Quantity

from .display import Picture
from .doorways import doorway_text
from .facts import input_name, level_text
from .lettering import drawable
from .pdf import draw_picture
from .table import what_is_measured
from .tape import tape_summary

_MARGIN_PT = 45.0
_PLAN_HEIGHT_PT = 400.0
"""At most, so that the dimensions begin on the first sheet in most rooms."""


def report_pdf(result: FitResult, plan: Picture) -> bytes:
    """The report as a PDF of A4 sheets; the same result gives the same bytes.

    Args:
        result: what to report; its texts may hold anything.
        plan: as `report.plan_picture` draws it; made to fit the sheet.

    Raises:
        OutputError: reportlab is not installed.
    """
    platypus = optional_module("reportlab.platypus", "plan", "report.pdf")
    sheets = _Sheets(platypus, result)
    sheets.heading()
    sheets.plan(plan)
    sheets.dimensions()
    sheets.rooms()
    sheets.notes()
    sheets.provenance()
    return sheets.content()


class _Sheets:
    """The story of a reportlab document, told part by part."""

    def __init__(self, platypus: Any, result: FitResult) -> None:
        self._p, self._result, self._story = platypus, result, []
        self._pages = optional_module("reportlab.lib.pagesizes", "plan", "report.pdf")
        self._colors = optional_module("reportlab.lib.colors", "plan", "report.pdf")
        styles = optional_module("reportlab.lib.styles", "plan", "report.pdf").getSampleStyleSheet()
        self._styles = {
            "title": styles["Title"].clone("own title", alignment=0, fontSize=18, leading=22, spaceAfter=2),
            "head": styles["Heading2"].clone("own head", fontSize=12, spaceBefore=12, spaceAfter=4),
            "text": styles["BodyText"].clone("own text", fontSize=9, leading=12),
            "cell": styles["BodyText"].clone("own cell", fontSize=7.5, leading=9.5, spaceBefore=0),
        }

    def content(self) -> bytes:
        """The file."""
        buffer = io.BytesIO()
        document = self._p.SimpleDocTemplate(
            buffer, pagesize=self._pages.A4, title=drawable(_title(self._result)), creator="indoorfit",
            leftMargin=_MARGIN_PT, rightMargin=_MARGIN_PT, topMargin=_MARGIN_PT, bottomMargin=_MARGIN_PT,
            # No dates and ids, so the same report gives the same bytes.
            invariant=1,
        )  # fmt: skip
        document.build(self._story, onFirstPage=_page_number, onLaterPages=_page_number)
        return buffer.getvalue()

    def heading(self) -> None:
        """What this is, and the doubt that comes before all numbers."""
        result = self._result
        self._say("title", _title(result))
        rooms = "1 room" if len(result.rooms) == 1 else f"{len(result.rooms)} rooms"
        walls = sum(face.kind == "wall" for face in result.faces)
        self._say("text", f"{rooms}, {walls} walls; {result.method} fit. All lengths in metres.")
        if not result.converged:
            self._say(
                "text", "The fit did not converge or a room is not closed: use these numbers with care."
            )

    def plan(self, plan: Picture) -> None:
        """The plan, as large as the sheet allows."""
        self._story.append(self._p.Spacer(1, 8))
        width_pt = self._pages.A4[0] - 2.0 * _MARGIN_PT
        unit_pt = min(width_pt / plan.width, _PLAN_HEIGHT_PT / plan.height)

        class Plan(self._p.Flowable):
            def wrap(self, aW: float, aH: float) -> tuple[float, float]:
                return width_pt, plan.height * unit_pt

            def draw(self) -> None:
                canvas: Any = self.canv  # type: ignore[attr-defined]
                canvas.translate(0.5 * (width_pt - plan.width * unit_pt), 0.0)
                draw_picture(canvas, plan, unit_pt)

        self._story.append(Plan())

    def dimensions(self) -> None:
        """Value, interval, accuracy and status of every length, and the tape where there was one."""
        result = self._result
        checks = {} if result.tape is None else {check.dimension: check for check in result.tape.checks}
        several = len(result.rooms) > 1
        rows = []
        for d in result.dimensions:
            row = [
                d.id,
                what_is_measured(d, several),
                *_number_texts(d.quantity, 3, 4),
                d.loa or "",
                d.status,
            ]
            if checks:
                check = checks.get(d.id)
                row += [f"{check.value_m:.4f}", f"{1e3 * check.deviation_m:+.1f}"] if check else ["", ""]
            rows.append(row)
        head = ["Id", "What", "Value, m", f"Interval, {level_text(result.level)}", "Accuracy", "Status"]
        shares = [6, 34, 12, 18, 11, 12]
        if checks:
            head, shares = [*head, "Tape, m", "Model - tape, mm"], [*shares, 11, 12]
        self._table("Dimensions", head, rows, shares, numbers=(2, 3, 6, 7))
        if result.tape is not None:
            self._say("text", tape_summary(result.tape))

    def rooms(self) -> None:
        """Areas, volumes and perimeters, and the doors."""
        rows = [
            [room.id, name, *_number_texts(quantity, 2, 3), unit]
            for room in self._result.rooms
            for name, quantity, unit in (
                ("Floor area", room.floor_area, "m²"),
                ("Volume", room.volume, "m³"),
                ("Perimeter", room.perimeter, "m"),
            )
        ]
        head = ["Room", "What", "Value", f"Interval, {level_text(self._result.level)}", "Unit"]
        self._table("Rooms", head, rows, [20, 24, 18, 22, 16], numbers=(2, 3))
        for doorway in self._result.adjacency:
            self._say("text", doorway_text(doorway))

    def notes(self) -> None:
        """Warnings, and what the intervals rest on."""
        if self._result.notes:
            self._say("head", "Warnings")
        for note in self._result.notes:
            self._say("text", f"{note.code}: {note.message}")
        explanation = self._result.noise.get("explanation")
        if explanation:
            self._say("head", "Noise and intervals")
            self._say("text", str(explanation))

    def provenance(self) -> None:
        """Where it comes from; every single setting is in model.json."""
        rows = [[key, text] for key, text in _facts(self._result.provenance)]
        if rows:
            self._table("Provenance", ["What", "Value"], rows, [25, 75])

    def _say(self, style: str, text: str) -> None:
        # Paragraphs read markup: texts of files must not be any.
        self._story.append(self._p.Paragraph(escape(drawable(text)), self._styles[style]))

    def _table(
        self,
        title: str,
        head: Sequence[str],
        rows: Sequence[Sequence[str]],
        shares: Sequence[int],
        numbers: Sequence[int] = (),
    ) -> None:
        """A table over the width of the sheet; its head stands on every sheet that it goes on to."""
        if not rows:
            return
        self._say("head", title)
        width_pt = self._pages.A4[0] - 2.0 * _MARGIN_PT
        right = self._styles["cell"].clone("own number", alignment=2)

        def cell(column: int, text: str, bold: bool = False) -> Any:
            style = right if column in numbers else self._styles["cell"]
            shown = escape(drawable(text))
            return self._p.Paragraph(f"<b>{shown}</b>" if bold else shown, style)

        lines = [[cell(k, text, bold=True) for k, text in enumerate(head)]]
        lines += [[cell(k, text) for k, text in enumerate(row)] for row in rows]
        widths = [width_pt * share / sum(shares) for share in shares]
        rules = [
            ("LINEBELOW", (0, 0), (-1, -1), 0.4, self._colors.HexColor("#bbbbbb")),
            ("VALIGN", (0, 0), (-1, -1), "TOP"),
            ("TOPPADDING", (0, 0), (-1, -1), 2.0),
            ("BOTTOMPADDING", (0, 0), (-1, -1), 2.5),
        ]
        self._story.append(self._p.Table(lines, widths, repeatRows=1, style=rules))


def _title(result: FitResult) -> str:
    name = input_name(result)
    return f"Measured model of {name}" if name else "Measured model"


def _number_texts(quantity: Quantity, min_decimals: int, max_decimals: int) -> tuple[str, str]:
    text = quantity_text(quantity, min_decimals, max_decimals)
    return text.value, text.spread


def _facts(provenance: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Everything but the settings and the times, dotted names."""
    facts: list[tuple[str, str]] = []
    for key, value in provenance.items():
        if key in ("config", "timings_s") or value is None:
            continue
        if isinstance(value, Mapping):
            facts += [(f"{key}.{name}", text) for name, text in _facts(value)]
        else:
            facts.append((key, value if isinstance(value, str) else json.dumps(value, default=str)))
    return facts


def _page_number(canvas: Any, document: Any) -> None:
    canvas.setFont("Helvetica", 8)
    canvas.drawRightString(document.pagesize[0] - _MARGIN_PT, 0.5 * _MARGIN_PT, f"Page {document.page}")
