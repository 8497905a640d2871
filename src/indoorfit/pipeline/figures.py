"""Figures for papers, written to a directory whole or not at all."""

import json
import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from indoorfit.config import RunConfig
from indoorfit.errors import ConfigError, InputError
from indoorfit.export import optional_module
from indoorfit.files import check_staged, staged
from indoorfit.model import FitResult, Scan
from indoorfit.report import (
    FIGURE_FORMATS,
    UNIT_MM,
    FigureFormat,
    Picture,
    figure_bytes,
    plan_picture,
    residual_histogram,
    residuals_of,
    step_figures,
    to_pdf,
    to_svg,
    write_picture_png,
)
from indoorfit.stages import announced

from .tracing import trace_greedy

log = logging.getLogger("indoorfit")

_INDEX = "figures.json"

CAPTIONS: Mapping[str, str] = {
    "plan": "Measured plan; lengths in metres with their intervals.",
    "residuals": "Distances of the points from their faces (thesis figure 6-1).",
    "reliability": "Share of references that the intervals hold, over the nominal coverage.",
    "normals": "Normals of the segments: (a) unit sphere, (b) azimuth and elevation (thesis figure 3-5).",
    "step-1-points": "Point cloud without its ceiling (thesis figure 5-1 a).",
    "step-2-segments": "Segments of surface growing (thesis figures 5-1 b, 5-3 a, 5-6 a).",
    "step-3-largest-cube": "Farthest segments by class, largest cube (thesis figures 5-1 d, 5-3 c, 5-6 c).",
    "step-4-remaining-segments": "Remaining wall segments by component (thesis figures 5-2 a, 5-4 a, 5-7 a).",
    "normals-remaining": "Normals of the remaining segments (thesis figures 5-2 b, 5-4 b).",
    "step-5-notch-cubes": "Cubes to be subtracted, intersection points (thesis figures 5-2 d, 5-5 b, 5-7 f).",
    "step-6-result": "The result without ceiling and near walls (thesis figures 5-2 e, 5-5 c, 5-7 g).",
}
"""What each figure shows, for the text under it."""


def check_figures(
    directory: str | Path, formats: Sequence[FigureFormat] = ("svg",), *, overwrite: bool = False
) -> None:
    """Raise now what `write_figures` would raise, so that no long run ends in it.

    Raises:
        ConfigError: no format, or an unknown one.
        OutputError: a library is not installed, or the directory exists or cannot be written.
    """
    check_staged(Path(directory), overwrite=overwrite, marks=(_INDEX,), folder=True)
    unknown = [kind for kind in formats if kind not in FIGURE_FORMATS]
    if unknown or not formats:
        raise ConfigError(
            f"figures: the formats {', '.join(unknown) or '(none)'}; needed some of "
            f"{', '.join(FIGURE_FORMATS)}. Fix: choose among these."
        )
    optional_module("matplotlib", "figures", "figures")
    if "pdf" in formats:
        optional_module("reportlab", "figures", "figures as PDF")


def write_figures(
    result: FitResult,
    scan: Scan,
    config: RunConfig,
    directory: str | Path,
    *,
    formats: Sequence[FigureFormat] = ("svg",),
    overwrite: bool = False,
    pictures: Mapping[str, Picture] | None = None,
) -> tuple[str, ...]:
    """Write plan, residual histogram, normals and the steps of the grammar, and a list of them with captions.

    The steps are those of the greedy method, which is the thesis' own, whatever method the result is of.
    Where it finds no room in the scan they are left out, with a warning to the log.

    Args:
        result: of the scan.
        scan: metres.
        config: settings that the scan was fitted with.
        directory: created; holds `NAME.FORMAT` for every figure, and ``figures.json``.
        formats: of every figure.
        overwrite: replace earlier figures in the same place.
        pictures: further figures by their names in `CAPTIONS`, e.g. ``reliability``.

    Returns:
        the names of the figures, in order.

    Raises:
        ConfigError: an unknown format.
        OutputError: a library is missing, or the directory exists or cannot be written.
    """
    check_figures(directory, formats, overwrite=overwrite)
    with staged([Path(directory)], overwrite=overwrite, marks=(_INDEX,), folders=True) as (place,):
        place.mkdir()
        drawn = {"plan": plan_picture(result, scan.points_m), **(pictures or {})}
        for name, picture in drawn.items():
            for kind in formats:
                _write_picture(place / f"{name}.{kind}", picture, kind)
        plotted = _plots(result, scan, config)
        with announced("write"):
            for name, figure in plotted.items():
                for kind in formats:
                    (place / f"{name}.{kind}").write_bytes(figure_bytes(figure, kind))
        names = [name for name in CAPTIONS if name in drawn or name in plotted]
        index = {name: {"caption": CAPTIONS[name], "files": [f"{name}.{kind}" for kind in formats]}
                 for name in names}  # fmt: skip
        (place / _INDEX).write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")
    return tuple(names)


def _plots(result: FitResult, scan: Scan, config: RunConfig) -> dict[str, Any]:
    plots: dict[str, Any] = {}
    residuals = residuals_of(result, scan.points_m, config.joint.association)
    if residuals is not None:
        plots["residuals"] = residual_histogram(residuals)
    try:
        plots |= step_figures(trace_greedy(scan, config))
    except InputError as error:
        log.warning("figures: no steps, for the greedy method finds no room here: %s", error)
    return plots


_WRITERS: Mapping[FigureFormat, Callable[[Path, Picture], object]] = {
    "svg": lambda path, picture: path.write_text(to_svg(picture, UNIT_MM), encoding="utf-8"),
    "pdf": lambda path, picture: path.write_bytes(to_pdf(picture, UNIT_MM)),
    "png": write_picture_png,
}


def _write_picture(path: Path, picture: Picture, kind: FigureFormat) -> None:
    _WRITERS[kind](path, picture)
