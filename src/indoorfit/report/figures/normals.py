"""The thesis' figure 3-5: normal vectors of segments, which gather where the walls are."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from jaxtyping import Float

from .paper import CLASS_COLOURS, INK, PALE, QUIET, new_figure, styled
from .trace import GreedyTrace


def normal_scatter(trace: GreedyTrace, segments: Iterable[int] | None = None) -> Any:
    """Normals of segments on the unit sphere, and by azimuth and elevation, coloured by class.

    Args:
        trace: of the scan.
        segments: those to be shown; default: all.
    """
    chosen = list(range(len(trace.normals)) if segments is None else segments)
    with styled():
        figure = new_figure(6.4, 3.0)
        sphere, plane = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
        for name, colour in (*CLASS_COLOURS.items(), (None, PALE)):
            own = [k for k in chosen if trace.classes[k] == name]
            if not own:
                continue
            normals, size = trace.normals[own], _sizes(trace.areas_m2[own])
            look = {"s": size, "color": colour, "edgecolors": INK, "linewidths": 0.3, "alpha": 0.9}
            sphere.scatter(*normals.T, depthshade=False, **look)
            azimuth_deg, elevation_deg = angles_deg(normals)
            plane.scatter(azimuth_deg, elevation_deg, label=name or "no class", zorder=3, **look)
        _finish_sphere(sphere)
        _finish_plane(plane)
    return figure


def angles_deg(
    normals: Float[np.ndarray, "n 3"],
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """Azimuth from x towards y, -135 to 225 so that no wall lies on the cut, and elevation, degrees."""
    azimuth = np.rad2deg(np.arctan2(normals[:, 1], normals[:, 0]))
    elevation = np.rad2deg(np.arcsin(np.clip(normals[:, 2], -1.0, 1.0)))
    return (azimuth + 135.0) % 360.0 - 135.0, elevation


def _sizes(areas_m2: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Marks grow with the segment's side, so that slivers do not look like walls."""
    return np.clip(12.0 * np.sqrt(areas_m2), 4.0, 60.0)


def _finish_sphere(axes: Any) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    flat = np.zeros_like(turn)
    for ring in ((np.cos(turn), np.sin(turn), flat), (np.cos(turn), flat, np.sin(turn)),
                 (flat, np.cos(turn), np.sin(turn))):  # fmt: skip
        axes.plot(*ring, color=PALE, linewidth=0.6)
    for axis, name in enumerate("xyz"):
        end = np.zeros(3)
        end[axis] = 1.35
        axes.plot(*zip(np.zeros(3), end, strict=True), color=QUIET, linewidth=0.6)
        axes.text(*(1.08 * end), name, color=INK)
    axes.set_box_aspect((1.0, 1.0, 1.0), zoom=1.5)
    axes.set_proj_type("ortho")
    axes.view_init(elev=22.0, azim=-60.0)
    axes.set_axis_off()
    axes.set_title("(a)", loc="left", fontsize=8.0)


def _finish_plane(axes: Any) -> None:
    axes.set_xlim(-135.0, 225.0)
    axes.set_ylim(-100.0, 100.0)
    axes.set_xticks([-90, 0, 90, 180])
    axes.set_yticks([-90, -45, 0, 45, 90])
    axes.grid(color=PALE, linewidth=0.4)
    axes.set_xlabel("azimuth, degrees")
    axes.set_ylabel("elevation, degrees")
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title("(b)", loc="left", fontsize=8.0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=4, fontsize=7.0, handletextpad=0.1)
