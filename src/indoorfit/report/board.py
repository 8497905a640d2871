"""What is on the page already, and what a new mark would collide with."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from .display import Box

Kind = Literal["wall", "text", "line", "extension"]

COLLISION = 1000.0
"""The cost of one forbidden overlap; anything below it is a matter of taste."""

_CROSSING = 30.0
_EXTENSION_OVER_WALL = 40.0


@dataclass(frozen=True)
class Marks:
    """The boxes of one candidate: what it would put on the page."""

    texts: tuple[Box, ...] = ()
    lines: tuple[Box, ...] = ()
    extensions: tuple[Box, ...] = ()


@dataclass
class Board:
    """Occupied boxes by kind. Grows while the picture is laid out."""

    _boxes: dict[Kind, list[Box]] = field(
        default_factory=lambda: {"wall": [], "text": [], "line": [], "extension": []}
    )
    _arrays: dict[Kind, np.ndarray] = field(default_factory=dict)

    def add(self, kind: Kind, boxes: Iterable[Box]) -> None:
        """Occupy some boxes."""
        self._boxes[kind] += boxes
        self._arrays.pop(kind, None)

    def place(self, marks: Marks) -> None:
        """Occupy what a chosen candidate consists of."""
        self.add("text", marks.texts)
        self.add("line", marks.lines)
        self.add("extension", marks.extensions)

    def hits(self, kind: Kind, boxes: Sequence[Box], gap: float = 0.0) -> int:
        """How many occupied boxes of a kind the given ones overlap, with a gap kept around them."""
        if not boxes or not self._boxes[kind]:
            return 0
        if kind not in self._arrays:
            self._arrays[kind] = np.array(self._boxes[kind])
        taken, new = self._arrays[kind][None], np.array(boxes)[:, None]
        apart = (new[..., :2] - gap >= taken[..., 2:]) | (taken[..., :2] >= new[..., 2:] + gap)
        return int((~apart.any(axis=-1)).sum())

    def cost(self, marks: Marks) -> float:
        """Collisions of a candidate with all that is there, from 0 (none) upward."""
        forbidden = (
            sum(self.hits(kind, marks.texts, gap=2.0) for kind in self._boxes)
            + self.hits("wall", marks.lines, gap=2.0)
            + self.hits("text", marks.lines, gap=2.0)
            + self.hits("text", marks.extensions, gap=1.0)
            + self._parallel(marks.lines)
        )
        untidy = _CROSSING * (self.hits("line", marks.lines) + self.hits("extension", marks.lines))
        untidy += 0.2 * _CROSSING * self.hits("line", marks.extensions)
        return COLLISION * forbidden + untidy + _EXTENSION_OVER_WALL * self.hits("wall", marks.extensions)

    def _parallel(self, lines: Sequence[Box]) -> int:
        """Lines that run along each other closer than people can tell apart."""
        beside = 0
        for x0, y0, x1, y1 in lines:
            flat = x1 - x0 > y1 - y0
            for a0, b0, a1, b1 in self._boxes["line"]:
                if flat != (a1 - a0 > b1 - b0):
                    continue
                near = abs(y0 - b0) < 6.0 if flat else abs(x0 - a0) < 6.0
                shared = min(x1, a1) - max(x0, a0) if flat else min(y1, b1) - max(y0, b0)
                beside += int(near and shared > 0.0)
        return beside
