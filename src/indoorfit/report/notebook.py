"""A model as a notebook shows it."""

from html import escape

import numpy as np
from jaxtyping import Float

from indoorfit.export import quantity_text
from indoorfit.model import Dimension, FitResult

from .facts import level_text
from .markup import html_table
from .plan import plan_svg
from .table import what_is_measured


def notebook_html(result: FitResult, points_m: Float[np.ndarray, "points 3"] | None = None) -> str:
    """The plan, the lengths with their intervals, and the warnings; all texts escaped.

    Args:
        result: what to show.
        points_m: the scan, scan frame, metres; drawn faintly behind the plan.
    """
    head = ("", "length", "value, m", f"interval at {level_text(result.level)}", "status")
    table = html_table(head, [_row(d, len(result.rooms) > 1) for d in result.dimensions])
    notes = "".join(f"<p><b>{escape(n.code)}</b> {escape(n.message)}</p>" for n in result.notes)
    doubt = "" if result.converged else "<p><b>Not sound:</b> use these numbers with care.</p>"
    return f"{plan_svg(result, points_m)}{doubt}{table}{notes}"


def _row(dimension: Dimension, with_room: bool) -> list[tuple[str, str]]:
    text = quantity_text(dimension.quantity)
    return [
        ("id", dimension.id),
        ("", what_is_measured(dimension, with_room)),
        ("number", text.value),
        ("number", text.spread),
        ("", dimension.status),
    ]
