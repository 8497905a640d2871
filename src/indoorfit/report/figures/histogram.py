"""The thesis' figure 6-1: how far the points lie from the model."""

from typing import Any

import numpy as np

from ..residuals import Residuals
from .paper import INK, new_figure, styled


def residual_histogram(residuals: Residuals) -> Any:
    """Histogram of the points' distances from their faces, with the normal curve of their robust spread.

    Args:
        residuals: of `report.residuals_of`; positive into the room.
    """
    edges_mm, std_mm = 1e3 * residuals.edges_m, 1e3 * residuals.std_m
    step_mm = float(edges_mm[1] - edges_mm[0])
    with styled():
        figure = new_figure()
        axes = figure.add_subplot()
        axes.bar(edges_mm[:-1], residuals.counts, 0.92 * step_mm, align="edge", color="#9db8cf")
        x = np.linspace(edges_mm[0], edges_mm[-1], 201)
        height = residuals.n_points * step_mm / (std_mm * np.sqrt(2.0 * np.pi))
        normal = height * np.exp(-0.5 * (x / std_mm) ** 2)
        axes.plot(x, normal, color=INK, linewidth=1.0, label=f"normal distribution, {std_mm:.2g} mm")
        axes.set_xlabel("distance from the face, mm (positive into the room)")
        axes.set_ylabel("points")
        axes.set_xlim(edges_mm[0], edges_mm[-1])
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(loc="upper right")
        axes.set_title(f"{residuals.n_points} points", loc="left", fontsize=8.0)
    return figure
