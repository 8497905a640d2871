"""A model as a notebook shows it."""

from html import escape

import numpy as np
from jaxtyping import Float

from indoorfit.export import quantity_text
from indoorfit.model import Dimension, FitResult

from .facts import level_text
from .html_table import Cell, Row, html_table
from .plan import plan_svg
from .table import what_is_measured


def notebook_html(result: FitResult, points_m: Float[np.ndarray, "points 3"] | None = None) -> str:
    """The plan, the lengths with their intervals, and the warnings; all texts escaped.

    Args:
        result: what to show.
        points_m: the scan, scan frame, metres; drawn faintly behind the plan.
    """
    head = ("", "length", "value, m", f"interval at {level_text(result.level)}", "status")
    table = html_table(head, [_row(d, len(result.rooms) > 1) for d in result.dimensions], "Lengths")
    notes = "".join(f"<p><b>{escape(n.code)}</b> {escape(n.message)}</p>" for n in result.notes)
    doubt = "" if result.converged else "<p><b>Not sound:</b> use these numbers with care.</p>"
    return f"{plan_svg(result, points_m)}{doubt}{table}{notes}"


def _row(dimension: Dimension, with_room: bool) -> Row:
    text = quantity_text(dimension.quantity)
    cells = (
        Cell(dimension.id, "id"),
        Cell(what_is_measured(dimension, with_room)),
        Cell(text.value, "number"),
        Cell(text.spread, "number"),
        Cell(dimension.status),
    )
    return Row(cells)
