"""What is on the page already, and what a new mark would collide with."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

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
        taken = self._array(kind)
        return sum(int(_overlaps(taken, box, gap).sum()) for box in boxes) if len(taken) else 0

    def cost(self, marks: Marks) -> float:
        """Collisions of a candidate with all that is there: 0 for none, `COLLISION` if one is forbidden."""
        # Cheapest first: most candidates fail on a wall.
        forbidden = (
            any(self.hits(kind, marks.texts, gap=2.0) for kind in self._boxes)
            or self.hits("wall", marks.lines, gap=2.0)
            or self.hits("text", marks.lines, gap=2.0)
            or self.hits("text", marks.extensions, gap=1.0)
            or self._runs_along(marks.lines)
        )
        if forbidden:
            return COLLISION
        untidy = _CROSSING * (self.hits("line", marks.lines) + self.hits("extension", marks.lines))
        untidy += 0.2 * _CROSSING * self.hits("line", marks.extensions)
        return untidy + _EXTENSION_OVER_WALL * self.hits("wall", marks.extensions)

    def _runs_along(self, lines: Sequence[Box]) -> bool:
        """Whether a line runs beside another, closer than people can tell apart."""
        return any(self._hits_parallel(line) for line in lines)

    def _hits_parallel(self, line: Box) -> bool:
        x0, y0, x1, y1 = line
        flat = x1 - x0 > y1 - y0
        # Thickened across, a line overlaps all that cross it too: only those in its direction count.
        thick = (x0, y0 - 5.0, x1, y1 + 5.0) if flat else (x0 - 5.0, y0, x1 + 5.0, y1)
        taken = self._array("line")
        if not len(taken):
            return False
        same = (taken[:, 2] - taken[:, 0] > taken[:, 3] - taken[:, 1]) == flat
        return bool((_overlaps(taken, thick, 0.0) & same).any())

    def _array(self, kind: Kind) -> Float[np.ndarray, "boxes 4"]:
        if kind not in self._arrays:
            self._arrays[kind] = np.array(self._boxes[kind], float).reshape(-1, 4)
        return self._arrays[kind]


def _overlaps(taken: Float[np.ndarray, "boxes 4"], new: Box, gap: float) -> Bool[np.ndarray, " boxes"]:
    """Which of the boxes the new one overlaps, with a gap kept around it."""
    x0, y0, x1, y1 = new
    return (
        (taken[:, 2] > x0 - gap)
        & (taken[:, 0] < x1 + gap)
        & (taken[:, 3] > y0 - gap)
        & (taken[:, 1] < y1 + gap)
    )
