"""What all figures share: size, colours, the way to a file. The only door to Matplotlib.

`matplotlib.figure.Figure` without pyplot keeps no global state and opens no window.
"""

import io
from typing import Any, Literal, get_args

from indoorfit.export import optional_module
from indoorfit.model import FaceClass

FigureFormat = Literal["svg", "pdf", "png"]
FIGURE_FORMATS: tuple[FigureFormat, ...] = get_args(FigureFormat)

WIDTH_IN = 5.0
"""A generous column; text of 8 pt stays legible when it is set at 85 mm."""
INK, QUIET, PALE = "#2a2d30", "#7a8187", "#c9cdd1"

CLASS_COLOURS: dict[FaceClass, str] = {
    "front": "#0072b2",
    "back": "#56b4e9",
    "left": "#d55e00",
    "right": "#e69f00",
    "floor": "#7a5230",
    "ceiling": "#009e73",
}
"""Told apart by the colour-blind (Okabe and Ito 2008)."""

SEQUENCE = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5230", "#4b4f9c")
"""The same for things without a class: segments, components."""

_STYLE = {
    "font.size": 8.0,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    # Ids in an SVG would else be drawn by lot: equal figures have equal bytes.
    "svg.hashsalt": "indoorfit",
}

_NO_DATE: dict[FigureFormat, dict[str, None]] = {
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
    "png": {"Software": None},
}


def new_figure(width_in: float = WIDTH_IN, height_in: float = 3.2) -> Any:
    """An empty figure.

    Raises:
        OutputError: Matplotlib is not installed.
    """
    matplotlib = optional_module("matplotlib", "figures", "figures")
    figures = optional_module("matplotlib.figure", "figures", "figures")
    with matplotlib.rc_context(_STYLE):
        return figures.Figure(figsize=(width_in, height_in), layout="constrained")


def styled() -> Any:
    """A context in which axes take the common style when they are made."""
    return optional_module("matplotlib", "figures", "figures").rc_context(_STYLE)


def figure_bytes(figure: Any, kind: FigureFormat) -> bytes:
    """The figure as the content of a file; the same figure gives the same bytes."""
    content = io.BytesIO()
    with styled():
        # Cut to what is drawn: how much of its axes a 3D scene fills is not known beforehand.
        figure.savefig(content, format=kind, dpi=300, metadata=_NO_DATE[kind], bbox_inches="tight")
    return content.getvalue()
