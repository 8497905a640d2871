"""A plan on paper, to scale."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from indoorfit.errors import OutputError
from indoorfit.model import FitResult

from .display import Picture
from .layout import UNIT_MM, Layout, lay_out
from .plan import plan_picture

_SCALES = (50, 100, 200, 500, 1000)
"""ISO 5455, from the one that floor plans are drawn in."""

_PAPERS_MM = {"A4": (210, 297), "A3": (297, 420), "A2": (420, 594), "A1": (594, 841), "A0": (841, 1189)}
"""ISO 216, portrait."""

_COMMON = ("A4", "A3")
"""What office printers take: chosen from where no scale is demanded."""


@dataclass(frozen=True)
class Sheet:
    """A plan laid on a sheet of paper."""

    paper: str
    """``A4``, ``A3``, ..."""
    size_mm: tuple[int, int]
    """Width and height."""
    layout: Layout
    picture: Picture
    """As large as the sheet; a page unit is `UNIT_MM`."""


def plan_sheet(result: FitResult, denominator: int | None = None) -> Sheet:
    """Lay the plan on paper.

    Args:
        result: what to draw.
        denominator: N of the scale 1:N. Without it the first of 1:50, 1:100, 1:200, ... that fits A4 or A3;
            with it the smallest sheet from A4 to A0.

    Raises:
        OutputError: no sheet is large enough.
    """
    extent_mm = _extent_mm(result)
    for n in _SCALES if denominator is None else (denominator,):
        # Laying out takes longest, so it is done only where the walls alone would fit.
        sheets = [
            (paper, size)
            for paper, size in _sheets(_COMMON if denominator is None else tuple(_PAPERS_MM))
            if all(extent / n < side for extent, side in zip(extent_mm, size, strict=True))
        ]
        if not sheets:
            continue
        layout = lay_out(result, n)
        picture = plan_picture(result, None, layout)
        for paper, size in sheets:
            if picture.width * UNIT_MM <= size[0] and picture.height * UNIT_MM <= size[1]:
                return Sheet(paper, size, layout, _centred(picture, size))
    width_m, depth_m = (extent / 1000.0 for extent in extent_mm)
    said = "any scale up to 1:1000 on A3" if denominator is None else f"1:{denominator} on A0"
    raise OutputError(
        f"plan: {width_m:.1f} x {depth_m:.1f} m with all its texts is too large for {said}. "
        "Fix: give a smaller scale, e.g. --scale 2000, or write DXF, which has no sheet."
    )


def plan_layout(result: FitResult, denominator: int | None = None) -> Layout:
    """The plan for drawing programs, where paper comes later.

    Args:
        result: what to draw.
        denominator: N of the scale 1:N that letters are sized for; without it the first of 1:50, 1:100, ...
            at which the walls fit A3, or the last.
    """
    if denominator is None:
        extent_mm, sheet = max(_extent_mm(result)), min(_PAPERS_MM["A3"])
        denominator = next((n for n in _SCALES if extent_mm / n < sheet), _SCALES[-1])
    return lay_out(result, denominator)


def _extent_mm(result: FitResult) -> tuple[float, float]:
    corners = np.concatenate(
        [result.frame.to_manhattan(ring) for face in result.faces for ring in face.rings_m]
    )
    width, depth = 1000.0 * (corners.max(axis=0) - corners.min(axis=0))[:2]
    return float(width), float(depth)


def _sheets(papers: tuple[str, ...]) -> Iterator[tuple[str, tuple[int, int]]]:
    """Small ones first, landscape before portrait."""
    for paper in papers:
        short, long = _PAPERS_MM[paper]
        yield paper, (long, short)
        yield paper, (short, long)


def _centred(picture: Picture, size_mm: tuple[int, int]) -> Picture:
    width, height = (side / UNIT_MM for side in size_mm)
    shift = np.array([0.5 * (width - picture.width), 0.5 * (height - picture.height)])
    items = tuple(item.moved(shift) for item in picture.items)
    return replace(picture, width=width, height=height, items=items)
