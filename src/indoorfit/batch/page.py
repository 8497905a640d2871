"""The page of a batch: figures first, then pictures, then every scan."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from indoorfit.report import Cell, Row, html_page, html_table, to_svg

from .collect import Record, Tables
from .plots import error_picture, reliability_picture

_SHOWN = 500
"""Scans on the page; scans.csv has them all."""


@dataclass(frozen=True)
class View:
    """Figures and pictures of a batch, as a notebook shows them."""

    html: str

    def _repr_html_(self) -> str:
        return self.html


def view(tables: Tables) -> View:
    """Figures, configurations side by side and pictures, for notebooks."""
    parts = [*_figures(tables.summary), *_pairs(tables.pairs), *_pictures(tables.lengths)]
    return View("\n".join(parts))


def batch_page(tables: Tables, title: str) -> str:
    """The page as HTML that needs nothing else."""
    failed = [scan for scan in tables.scans if scan["state"] != "done"]
    rooms = len({record["room"] for record in tables.lengths})
    summary = (
        f"{len(tables.scans)} fits, {len(failed)} of them without a result; {len(tables.lengths)} lengths "
        f"with a reference in {rooms} rooms."
    )
    body = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="quiet">{escape(summary)}</p>',
        *(f'<p class="warning">{escape(text)}</p>' for text in _warnings(tables, failed)),
        *_figures(tables.summary),
        *_pairs(tables.pairs),
        *_pictures(tables.lengths),
        *_scans(tables.scans),
        *_refused(tables.refused),
    ]
    return html_page(title, body)


def _warnings(tables: Tables, failed: Sequence[Record]) -> Iterable[str]:
    if failed:
        names = ", ".join(f"{scan['scan']} ({scan['config']})" for scan in failed[:10])
        more = f" and {len(failed) - 10} more" if len(failed) > 10 else ""
        yield f"No result: {names}{more}. They are in no figure below; the reasons stand at the end."
    if tables.refused:
        yield f"{len(tables.refused)} row(s) of tape tables were not used; they stand at the end."
    against = [scan for scan in tables.scans if math.isfinite(scan["tape_p"]) and scan["tape_p"] < 0.01]
    if against:
        names = ", ".join(scan["scan"] for scan in against[:10])
        yield f"The tape contradicts the intervals (p < 0.01) in {len(against)} fit(s): {names}."


def _figures(summary: Sequence[Record]) -> list[str]:
    if not summary:
        return []
    head = (
        "Configuration", "Reference", "By", "Group", "Lengths", "Rooms", "Bias, mm", "RMSE, mm", "MAD, mm",
        "Held, %", "95 % interval, %", "E_n up to 1, %", "Score, mm", "Width, mm",
    )  # fmt: skip
    rows = [
        Row((
            Cell(r["config"], "id"), Cell(r["reference"]), Cell(r["by"]), Cell(r["group"]),
            _number(r["lengths"], 0), _number(r["rooms"], 0), _mm(r["bias_m"]), _mm(r["rmse_m"]),
            _mm(r["mad_m"]), _percent(r["held"]), _range(r), _percent(r["agree"]), _mm(r["score_m"]),
            _mm(r["median_width_m"]),
        ))
        for r in summary
    ]  # fmt: skip
    return [
        "<section><h2>Figures</h2>",
        html_table(head, rows, "Figures"),
        '<p class="quiet">Errors are model minus reference. MAD: median absolute deviation of the errors '
        "from their median. Held: share of the intervals that hold the reference as it is; its 95 % interval "
        "takes rooms, not lengths, as independent. Score: interval score (Gneiting and Raftery 2007): "
        "smaller is better. Width: median.</p></section>",
    ]


def _range(record: Record) -> Cell:
    low, high = record["held_rooms_low"], record["held_rooms_high"]
    if not math.isfinite(low):
        low, high = record["held_low"], record["held_high"]
    if not math.isfinite(low):
        return Cell("", "number")
    return Cell(f"{100 * low:.1f} to {100 * high:.1f}", "number")


def _pairs(pairs: Sequence[Record]) -> list[str]:
    if not pairs:
        return []
    head = (
        "First", "Second", "Lengths of both", "Rooms", "RMSE first, mm", "RMSE second, mm",
        "Median error first, mm", "Median error second, mm", "Rooms where first is better, %",
    )  # fmt: skip
    rows = [
        Row((
            Cell(p["first"], "id"), Cell(p["second"], "id"), _number(p["lengths"], 0), _number(p["rooms"], 0),
            _mm(p["first_rmse_m"]), _mm(p["second_rmse_m"]), _mm(p["first_median_error_m"]),
            _mm(p["second_median_error_m"]),
            Cell(f"{100 * p['first_better']:.0f} ({100 * p['first_better_low']:.0f} to "
                 f"{100 * p['first_better_high']:.0f})", "number"),
        ))
        for p in pairs
    ]  # fmt: skip
    note = (
        '<p class="quiet">Only lengths that both found; what one lost is in the table of scans. In brackets: '
        "95 % interval.</p></section>"
    )
    return ["<section><h2>Side by side</h2>", html_table(head, rows, "Side by side"), note]


def _pictures(lengths: Sequence[Record]) -> list[str]:
    if not lengths:
        return []
    pictures = [error_picture(lengths), reliability_picture(lengths)]
    shown = "".join(f'<div class="plan">{to_svg(picture)}</div>' for picture in pictures if picture)
    return [f"<section><h2>Pictures</h2>{shown}</section>"]


def _scans(scans: Sequence[Record]) -> list[str]:
    if not scans:
        return []
    head = (
        "Scan", "Configuration", "Sensor", "State", "Walls", "Structure", "Lengths", "Lost", "RMSE, mm",
        "Held, %", "What went wrong",
    )  # fmt: skip
    structure = {True: "right", False: "wrong", None: ""}
    rows = [
        Row((
            Cell(s["scan"], "id"), Cell(s["config"]), Cell(s["sensor"]),
            Cell(s["state"], "" if s["state"] == "done" else "inferred"), _number(s["walls"], 0),
            Cell(structure[s["structure_right"]], "inferred" if s["structure_right"] is False else ""),
            _number(s["lengths"], 0), _number(s["lengths_lost"], 0), _mm(s["rmse_m"]), _percent(s["held"]),
            Cell(s["reason"] or s["faults"]),
        ))
        for s in scans[:_SHOWN]
    ]  # fmt: skip
    more = f"<p>{len(scans) - _SHOWN} more in scans.csv.</p>" if len(scans) > _SHOWN else ""
    return ["<section><h2>Scans</h2>", html_table(head, rows, "Scans"), more, "</section>"]


def _refused(refused: Sequence[Record]) -> list[str]:
    if not refused:
        return []
    rows = [
        Row((Cell(r["table"], "id"), _number(r["line"], 0), Cell(r["scan"]), Cell(r["reason"])))
        for r in refused[:_SHOWN]
    ]
    more = f"<p>{len(refused) - _SHOWN} more in refused.csv.</p>" if len(refused) > _SHOWN else ""
    head = ("Table", "Line", "Scan", "Why it was not used")
    return [
        "<section><h2>Rows of tape tables that were not used</h2>",
        html_table(head, rows, "Rows of tape tables that were not used"),
        more,
        "</section>",
    ]


def _number(value: Any, digits: int, factor: float = 1.0) -> Cell:
    if value is None or not math.isfinite(value):
        return Cell("", "number")
    return Cell(f"{factor * value:.{digits}f}", "number")


def _mm(value_m: float) -> Cell:
    return _number(value_m, 2 if math.isfinite(value_m) and abs(value_m) < 0.01 else 1, 1e3)


def _percent(share: float) -> Cell:
    return _number(share, 1, 100.0)
