"""The display list as PDF, by reportlab."""

import io
from itertools import pairwise
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.export import optional_module

from .display import CAP_HEIGHT, Dots, Item, Label, Picture, Region, Stroke
from .lettering import drawable, text_width

_FONT = "Helvetica"
"""One of the 14 fonts that every reader of PDF has: nothing is embedded."""


def to_pdf(picture: Picture, unit_mm: float) -> bytes:
    """The picture as one page of lines and texts.

    Args:
        picture: what to draw.
        unit_mm: length of a page unit on paper.

    Raises:
        OutputError: reportlab is not installed.
    """
    library = optional_module("reportlab.pdfgen.canvas", "plan", "PDF")
    unit_pt = unit_mm / 25.4 * 72.0
    buffer = io.BytesIO()
    size = (picture.width * unit_pt, picture.height * unit_pt)
    # Invariant: no dates and ids, so the same plan gives the same bytes.
    canvas = library.Canvas(buffer, pagesize=size, invariant=1)
    canvas.setTitle(picture.title)
    canvas.setSubject(picture.description)
    canvas.setCreator("indoorfit")
    draw_picture(canvas, picture, unit_pt)
    canvas.showPage()
    canvas.save()
    return buffer.getvalue()


def draw_picture(canvas: Any, picture: Picture, unit_pt: float) -> None:
    """Draw with the lower left corner at the canvas' origin.

    Args:
        canvas: of reportlab.
        picture: what to draw.
        unit_pt: length of a page unit in points.
    """
    canvas.setLineJoin(0)
    page = _Page(canvas, picture, unit_pt)
    for item in picture.items:
        page.draw(item)


class _Page:
    """A reportlab canvas in page units, y down."""

    def __init__(self, canvas: Any, picture: Picture, unit_pt: float) -> None:
        self._canvas = canvas
        self._unit_pt = unit_pt
        self._height_pt = picture.height * unit_pt

    def draw(self, item: Item) -> None:
        """Put one item on the page."""
        match item:
            case Region():
                self._region(item)
            case Stroke():
                self._stroke(item)
            case Dots():
                self._canvas.setFillColor(item.colour)
                for x, y in self._points(item.centres):
                    self._canvas.circle(x, y, 0.5 * item.diameter * self._unit_pt, stroke=0, fill=1)
            case Label():
                self._label(item)

    def _points(self, points: Float[np.ndarray, "n 2"]) -> list[tuple[float, float]]:
        return [(x * self._unit_pt, self._height_pt - y * self._unit_pt) for x, y in points.tolist()]

    def _region(self, region: Region) -> None:
        path = self._canvas.beginPath()
        for ring in region.rings:
            first, *others = self._points(ring)
            path.moveTo(*first)
            for point in others:
                path.lineTo(*point)
            path.close()
        if region.fill:
            self._canvas.setFillColor(region.fill)
        if region.stroke:
            self._canvas.setStrokeColor(region.stroke)
            self._canvas.setLineWidth(region.width * self._unit_pt)
        # Fill mode 0 is the even-odd rule.
        self._canvas.drawPath(path, stroke=int(bool(region.stroke)), fill=int(bool(region.fill)), fillMode=0)

    def _stroke(self, stroke: Stroke) -> None:
        self._canvas.setStrokeColor(stroke.colour)
        self._canvas.setLineWidth(stroke.width * self._unit_pt)
        dash = [length * self._unit_pt for length in stroke.dash or ()]
        self._canvas.setDash(dash, 0)
        for a, b in pairwise(self._points(stroke.points)):
            self._canvas.line(*a, *b)
        self._canvas.setDash([], 0)

    def _label(self, label: Label) -> None:
        text = drawable(label.text)
        size_pt = label.size * self._unit_pt
        own_width = self._canvas.stringWidth(text, _FONT, size_pt)
        # The layout counts on the width, whatever the font is.
        width = text_width(label.text, label.size) * self._unit_pt
        start = -width * {"start": 0.0, "middle": 0.5, "end": 1.0}[label.anchor]
        ((x, y),) = self._points(np.array([label.at]))
        # The outline first, then the letters on top of it.
        for outline in (True, False) if label.halo else (False,):
            self._canvas.saveState()
            self._canvas.translate(x, y)
            if label.upright:
                self._canvas.rotate(90)
            line = self._canvas.beginText(start, -0.5 * CAP_HEIGHT * size_pt)
            line.setFont(_FONT, size_pt)
            line.setHorizScale(100.0 * width / own_width if own_width > 0 else 100.0)
            if outline:
                self._canvas.setLineJoin(1)
                self._canvas.setLineWidth(0.28 * size_pt)
                self._canvas.setStrokeColor(label.halo)
                line.setTextRenderMode(1)
            line.setFillColor(label.colour)
            line.textOut(text)
            self._canvas.drawText(line)
            self._canvas.restoreState()
