"""Doorways on the plan and in words."""

from collections.abc import Sequence

import numpy as np

from indoorfit.model import Doorway, FitResult

from .display import Item, Region, Stroke
from .names import FLOOR
from .outline import Outline

_JAMB = "#2a2d30"


def draw_doorways(result: FitResult, outline: Outline) -> list[Item]:
    """A gap in the wall for every doorway, with a line for each jamb."""
    items: list[Item] = []
    for doorway in result.adjacency:
        walls = [outline.wall(face) for face in doorway.faces]
        if walls[0] is None or walls[1] is None:
            continue
        axis = walls[0].axis
        middle = float(outline.to_page(result.frame.to_manhattan(doorway.sill_m)[None])[0, 1 - axis])
        half = 0.5 * doorway.width_m * outline.scale
        # A page unit more on both sides, to cover the lines of the two faces.
        across = sorted(wall.at for wall in walls if wall is not None)
        low, high = across[0] - 1.2, across[1] + 1.2
        ends_at = (middle - half, middle + half)
        corners = np.array([[low, ends_at[0]], [high, ends_at[0]], [high, ends_at[1]], [low, ends_at[1]]])
        ends = [corners[[0, 1]], corners[[2, 3]]]
        if axis == 1:
            corners, ends = corners[:, ::-1], [end[:, ::-1] for end in ends]
        items.append(Region((corners,), FLOOR))
        items += [Stroke(end, _JAMB, 1.2) for end in ends]
    return items


def doorway_text(doorway: Doorway) -> str:
    """One phrase: `door-1 joins room-1 and room-2, about 0.9 m wide and 2.0 m high, through wall-3 and ...`;
    without the height where no lintel was seen."""
    high = "" if doorway.height_m is None else f" and {doorway.height_m:.1f} m high"
    return (
        f"{doorway.id} joins {doorway.rooms[0]} and {doorway.rooms[1]}, "
        f"about {doorway.width_m:.1f} m wide{high}, through {doorway.faces[0]} and {doorway.faces[1]}"
    )


_SAID = {
    "holes": "both faces lack points there",
    "floor": "floor between the faces",
    "reveal": "jambs or lintel between the faces",
    "truth": "built so",
}


def evidence_text(evidence: Sequence[str]) -> str:
    """What speaks for a doorway, in words."""
    return "; ".join(_SAID[kind] for kind in evidence)
