"""The thesis' figures 5-1 to 5-7: the grammar at work, step by step."""

from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.fitting import GreedyStep

from .normals import normal_scatter
from .paper import CLASS_COLOURS, INK, PALE, QUIET, SEQUENCE, styled
from .scene import marks, polygons, stage, towards_observer, wire
from .trace import GreedyTrace

_LID_M = 0.15
"""Points this close to the ceiling would hide all others."""


def step_figures(trace: GreedyTrace) -> dict[str, Any]:
    """One figure per step of the procedure, by name, in its order; what there is not is left out.

    `normals` is the thesis' figure 3-5 for all segments, `normals-remaining` for those that the largest cube
    left over (figures 5-2 b and 5-4 b).
    """
    with styled():
        figures = {
            "normals": normal_scatter(trace),
            "step-1-points": _points(trace),
            "step-2-segments": _segments(trace),
            "step-3-largest-cube": _largest_cube(trace),
        }
        remaining = [k for component in trace.components() for k in component]
        if remaining:
            figures["step-4-remaining-segments"] = _remaining(trace)
            figures["normals-remaining"] = normal_scatter(trace, remaining)
        if any(step.action == "cube" for step in trace.steps):
            figures["step-5-notch-cubes"] = _notches(trace)
        figures["step-6-result"] = _result(trace)
    return figures


def _box(trace: GreedyTrace) -> Float[np.ndarray, "2 3"]:
    return trace.shape.bounds_m()[trace.shape.rooms[0].id]


def _open_top(trace: GreedyTrace, points_m: Float[np.ndarray, "points 3"]) -> np.ndarray:
    """Which points lie in or near the room and below its ceiling."""
    low, high = _box(trace)
    reach_m = 0.25
    inside = np.all((points_m > low - reach_m) & (points_m < high + reach_m), axis=1)
    return inside & (points_m[:, 2] < high[2] - _LID_M)


def _points(trace: GreedyTrace) -> Any:
    """The cloud, shaded by height."""
    figure, axes = stage(*_box(trace))
    shown = trace.points_m[_open_top(trace, trace.points_m)]
    low, high = _box(trace)
    share = np.clip((shown[:, 2] - low[2]) / (high[2] - low[2]), 0.0, 1.0)[:, None]
    marks(
        axes, shown, np.array([0.55, 0.42, 0.30]) * (1.0 - share) + np.array([0.25, 0.45, 0.62]) * share, 0.9
    )
    return figure


def _segments(trace: GreedyTrace) -> Any:
    """Surface growing: each segment in a colour of its own, what belongs to none pale."""
    figure, axes = stage(*_box(trace))
    shown = _open_top(trace, trace.surfels_m)
    palette = np.array([*SEQUENCE, PALE])
    index = np.where(trace.labels < 0, len(SEQUENCE), trace.labels % len(SEQUENCE))
    marks(axes, trace.surfels_m[shown], palette[index[shown]])
    return figure


def _largest_cube(trace: GreedyTrace) -> Any:
    """The farthest segments of each class, and the cube that was fitted to them."""
    figure, axes = stage(*_box(trace))
    selected = trace.selected()
    taken = [k for group in selected.values() for k in group]
    open_top = _open_top(trace, trace.surfels_m)
    marks(axes, trace.surfels_m[open_top & ~np.isin(trace.labels, taken)], PALE, 0.7)
    for name, group in selected.items():
        marks(axes, trace.surfels_m[open_top & np.isin(trace.labels, group)], CLASS_COLOURS[name])
    wire(axes, _box(trace), INK)
    return figure


def _remaining(trace: GreedyTrace) -> Any:
    """What the largest cube did not explain, by connected component."""
    figure, axes = stage(*_box(trace))
    wire(axes, _box(trace), PALE)
    for k, component in enumerate(trace.components()):
        own = np.isin(trace.labels, component)
        marks(axes, trace.surfels_m[own], SEQUENCE[k % len(SEQUENCE)], 2.0)
    return figure


def _notches(trace: GreedyTrace) -> Any:
    """The cubes to be subtracted on the largest one; dots: where two walls meet floor and ceiling."""
    made = [step for step in trace.steps if step.action == "cube"]
    bounds_m = [_closed(trace, step) for step in made]
    together = np.array([_box(trace), *bounds_m])
    figure, axes = stage(together[:, 0].min(axis=0), together[:, 1].max(axis=0))
    wire(axes, _box(trace), INK)
    for k, (step, bounds) in enumerate(zip(made, bounds_m, strict=True)):
        colour = SEQUENCE[k % len(SEQUENCE)]
        wire(axes, bounds, colour, fill=0.22)
        if len(step.corners_m):
            marks(axes, step.corners_m.reshape(-1, 3), INK, 14.0)
    return figure


def _closed(trace: GreedyTrace, step: GreedyStep) -> Float[np.ndarray, "2 3"]:
    """Bounds of a step's cube; infinite sides end a margin outside, as in the grammar."""
    assert step.cube is not None, "a step that made a cube names it"
    assert step.bounds_m is not None, "a step that made a cube bounds it"
    return np.where(np.isfinite(step.bounds_m), step.bounds_m, trace.shape.bounds_m()[step.cube])


def _result(trace: GreedyTrace) -> Any:
    """The largest cube minus the others, without ceiling and near walls."""
    figure, axes = stage(*_box(trace))
    rings, colours = [], []
    for polygon in trace.polygons:
        plane = trace.shape.planes[polygon.plane]
        inward = np.zeros(3)
        inward[plane.axis] = -plane.outward
        if inward @ towards_observer() > 0.0:
            rings.append(polygon.rings_m[0])
            colours.append({0: "#cdd7d9", 1: "#e2dfd5", 2: "#cbb89e"}[plane.axis])
    polygons(axes, rings, colours, 1.0, edge=QUIET)
    return figure
