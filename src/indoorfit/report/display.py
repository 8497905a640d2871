"""A picture as a short list of shapes, which two small back ends draw: one layout, one look.

Units are those of the page (1/96 inch on screen), x to the right, y down.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from .lettering import text_width

Box = tuple[float, float, float, float]
"""Left, top, right, bottom."""

CAP_HEIGHT = 0.70
"""Height of a capital letter as a share of the font size; texts are centred by it."""


@dataclass(frozen=True)
class Region:
    """A filled area; points inside an odd number of rings belong to it."""

    rings: tuple[Float[np.ndarray, "_ 2"], ...]
    fill: str | None
    stroke: str | None = None
    width: float = 0.0
    """Of the outline, centred on the rings, with mitred corners."""
    shows: tuple[str, ...] = ()
    """Ids of the faces or dimensions that this is a picture of, for pages that point them out."""

    def box(self) -> Box:
        """Bounds without the outline."""
        return _bounds(np.concatenate(self.rings))

    def moved(self, shift: Float[np.ndarray, " 2"]) -> "Region":
        """The same region elsewhere."""
        return replace(self, rings=tuple(ring + shift for ring in self.rings))


@dataclass(frozen=True)
class Stroke:
    """An open line."""

    points: Float[np.ndarray, "points 2"]
    colour: str
    width: float
    dash: tuple[float, float] | None = None
    """Lengths of ink and gap."""
    shows: tuple[str, ...] = ()
    """As in `Region`."""

    def box(self) -> Box:
        """Bounds without the width."""
        return _bounds(self.points)

    def moved(self, shift: Float[np.ndarray, " 2"]) -> "Stroke":
        """The same line elsewhere."""
        return replace(self, points=self.points + shift)


@dataclass(frozen=True)
class Dots:
    """Many small marks of one colour."""

    centres: Float[np.ndarray, "dots 2"]
    colour: str
    diameter: float

    def box(self) -> Box:
        """Bounds of the centres; an empty box at the origin without dots."""
        return _bounds(self.centres) if len(self.centres) else (0.0, 0.0, 0.0, 0.0)

    def moved(self, shift: Float[np.ndarray, " 2"]) -> "Dots":
        """The same dots elsewhere."""
        return replace(self, centres=self.centres + shift)


@dataclass(frozen=True)
class Label:
    """One line of text."""

    text: str
    at: tuple[float, float]
    """The anchor, half a capital letter above the baseline."""
    size: float
    colour: str
    anchor: Literal["start", "middle", "end"] = "middle"
    upright: bool = False
    """True for text that reads from bottom to top."""
    halo: str | None = None
    """Colour of an outline that sets the text off from what lies behind it."""
    shows: tuple[str, ...] = ()
    """As in `Region`."""

    def box(self) -> Box:
        """Bounds of the text, ascenders and descenders included."""
        return text_box(self.at, text_width(self.text, self.size), self.size, self.anchor, self.upright)

    def moved(self, shift: Float[np.ndarray, " 2"]) -> "Label":
        """The same text elsewhere."""
        return replace(self, at=(self.at[0] + float(shift[0]), self.at[1] + float(shift[1])))


Item = Region | Stroke | Dots | Label


@dataclass(frozen=True)
class Picture:
    """Everything that is drawn, back to front, and the page that it is drawn on."""

    width: float
    height: float
    background: str
    items: tuple[Item, ...]
    title: str
    description: str
    """For those who listen to the page."""


def text_box(
    at: tuple[float, float],
    width: float,
    size: float,
    anchor: Literal["start", "middle", "end"] = "middle",
    upright: bool = False,
) -> Box:
    """Bounds of a line of text of the given width."""
    start = -width * {"start": 0.0, "middle": 0.5, "end": 1.0}[anchor]
    half = 0.58 * size
    if upright:
        return at[0] - half, at[1] - start - width, at[0] + half, at[1] - start
    return at[0] + start, at[1] - half, at[0] + start + width, at[1] + half


def _bounds(points: Float[np.ndarray, "points 2"]) -> Box:
    (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)
