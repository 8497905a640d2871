"""A small stage for the step figures: one view for all of them, no axes, a bar of one metre."""

from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.export import optional_module

from .paper import INK, new_figure

_MOST_MARKS = 6000
"""A vector figure with more takes seconds to open and looks the same."""
_AZIMUTH_DEG, _ELEVATION_DEG = -115.0, 38.0
"""From the front left and above, as `view.png`."""

_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]


def stage(low_m: Float[np.ndarray, " 3"], high_m: Float[np.ndarray, " 3"]) -> tuple[Any, Any]:
    """Figure and axes that hold a box, Manhattan frame, with a bar of one metre before it."""
    figure = new_figure(4.6, 3.6)
    axes = figure.add_subplot(projection="3d")
    axes.set_proj_type("ortho")
    axes.view_init(elev=_ELEVATION_DEG, azim=_AZIMUTH_DEG)
    axes.set_axis_off()
    margin = 0.02 * (high_m - low_m)
    for k, name in enumerate("xyz"):
        getattr(axes, f"set_{name}lim")(low_m[k] - margin[k], high_m[k] + margin[k])
    axes.set_box_aspect(high_m - low_m, zoom=0.92)
    at = np.array([low_m[0], low_m[1] - 0.12 * (high_m[1] - low_m[1]), low_m[2]])
    axes.plot([at[0], at[0] + 1.0], [at[1]] * 2, [at[2]] * 2, color=INK, linewidth=2.0)
    axes.text(
        at[0] + 0.5, at[1] - 0.05 * (high_m[1] - low_m[1]), at[2], "1 m", color=INK, ha="center", va="top"
    )
    return figure, axes


def marks(axes: Any, points_m: Float[np.ndarray, "points 3"], colour: Any, size: float = 1.2) -> None:
    """Points, thinned evenly to what a figure can bear."""
    step = -(-len(points_m) // _MOST_MARKS) or 1
    shown = colour if isinstance(colour, str) else colour[::step]
    axes.scatter(*points_m[::step].T, s=size, c=shown, linewidths=0.0, depthshade=False)


def wire(axes: Any, bounds_m: Float[np.ndarray, "2 3"], colour: str, fill: float = 0.0) -> None:
    """A box by its edges, its sides tinted where `fill` is above 0."""
    corners = np.array([[bounds_m[(k >> axis) & 1, axis] for axis in range(3)] for k in range(8)])
    for a, b in _EDGES:
        axes.plot(*corners[[a, b]].T, color=colour, linewidth=1.0)
    if fill > 0.0:
        # Each side is the four corners that agree in one bit, in the order around it.
        rings = []
        for axis in range(3):
            others = [k for k in range(3) if k != axis]
            for end in (0, 1):
                order = [(0, 0), (1, 0), (1, 1), (0, 1)]
                rings.append(corners[[(end << axis) | (u << others[0]) | (v << others[1]) for u, v in order]])
        polygons(axes, rings, colour, fill, edge="none")


def polygons(
    axes: Any, rings_m: list[Float[np.ndarray, "_ 3"]], colours: Any, alpha: float, edge: str = INK
) -> None:
    """Flat faces, farther ones first."""
    art3d = optional_module("mpl_toolkits.mplot3d.art3d", "figures", "figures")
    patches = art3d.Poly3DCollection(
        rings_m, facecolors=colours, edgecolors=edge, linewidths=0.7, alpha=alpha
    )
    axes.add_collection3d(patches)


def towards_observer() -> Float[np.ndarray, " 3"]:
    """Unit direction from the model to the observer, Manhattan frame."""
    azimuth, elevation = np.deg2rad([_AZIMUTH_DEG, _ELEVATION_DEG])
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
