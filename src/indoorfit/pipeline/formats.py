"""Every format that a model can be written in, by name and by suffix."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from indoorfit.errors import OutputError
from indoorfit.export import (
    optional_module,
    write_3mf,
    write_cityjson,
    write_collada,
    write_dimensions_csv,
    write_glb,
    write_ifc,
    write_images,
    write_mesh_ply,
    write_obj,
    write_stl,
    write_vrml,
    write_x3d,
)
from indoorfit.files import FormatName, replace_file
from indoorfit.model import FitResult
from indoorfit.report import UNIT_MM, plan_layout, plan_sheet, to_dxf, to_pdf, to_svg, write_picture_png


@dataclass(frozen=True)
class Format:
    """One way of writing a model."""

    file_name: str
    """In a folder of results."""
    suffix: str
    write: Callable[[Path, FitResult, int | None], None]
    """Arguments: path, result, N of the plan's scale 1:N (None: the one that fits). Models ignore it."""
    is_plan: bool = False
    library: str | None = None
    """Module that must be installed."""
    extra: str = ""
    """Of indoorfit, that installs it."""


def _of_model(write: Callable[[Path, FitResult], None]) -> Callable[[Path, FitResult, int | None], None]:
    """A writer that has nothing to do with a plan's scale."""

    def without_scale(path: Path, result: FitResult, denominator: int | None) -> None:
        write(path, result)

    return without_scale


def _with_images(write: Callable[[Path, FitResult], None]) -> Callable[[Path, FitResult, int | None], None]:
    """A writer of a model whose textures lie in a folder beside it."""

    def with_images(path: Path, result: FitResult, denominator: int | None) -> None:
        write_images(path.parent, result)
        write(path, result)

    return with_images


def _write_pdf(path: Path, result: FitResult, denominator: int | None) -> None:
    replace_file(path, to_pdf(plan_sheet(result, denominator).picture, UNIT_MM))


def _write_svg(path: Path, result: FitResult, denominator: int | None) -> None:
    replace_file(path, to_svg(plan_sheet(result, denominator).picture, UNIT_MM).encode("utf-8"))


def _write_png(path: Path, result: FitResult, denominator: int | None) -> None:
    write_picture_png(path, plan_sheet(result, denominator).picture)


def _write_dxf(path: Path, result: FitResult, denominator: int | None) -> None:
    replace_file(path, to_dxf(result, plan_layout(result, denominator)))


FORMATS: Mapping[FormatName, Format] = {
    "glb": Format("model.glb", ".glb", _of_model(write_glb)),
    "vrml": Format("model.wrl", ".wrl", _with_images(write_vrml)),
    "x3d": Format("model.x3d", ".x3d", _with_images(write_x3d)),
    "obj": Format("model.obj", ".obj", _with_images(write_obj)),
    "ply": Format("model.ply", ".ply", _of_model(write_mesh_ply)),
    "stl": Format("model.stl", ".stl", _of_model(write_stl)),
    "3mf": Format("model.3mf", ".3mf", _of_model(write_3mf)),
    "dae": Format("model.dae", ".dae", _with_images(write_collada)),
    "ifc": Format("model.ifc", ".ifc", _of_model(write_ifc), library="ifcopenshell", extra="ifc"),
    "cityjson": Format("model.city.json", ".city.json", _of_model(write_cityjson)),
    "dxf": Format("plan.dxf", ".dxf", _write_dxf, is_plan=True, library="ezdxf", extra="plan"),
    "pdf": Format("plan.pdf", ".pdf", _write_pdf, is_plan=True, library="reportlab", extra="plan"),
    "svg": Format("plan.svg", ".svg", _write_svg, is_plan=True),
    "png": Format("plan.png", ".png", _write_png, is_plan=True),
    "csv": Format("dimensions.csv", ".csv", _of_model(write_dimensions_csv)),
}


def format_of(path: Path, name: FormatName | None = None) -> Format:
    """The format that a file name stands for.

    Args:
        path: judged by its suffix, whatever its case.
        name: of the format, where the suffix shall not decide.

    Raises:
        OutputError: no format has this suffix.
    """
    if name is not None:
        return FORMATS[name]
    for candidate in FORMATS.values():
        if path.name.lower().endswith(candidate.suffix):
            return candidate
    known = ", ".join(candidate.suffix for candidate in FORMATS.values())
    raise OutputError(
        f"{path.name}: the suffix {path.suffix!r} stands for no format; known are {known}. "
        "Fix: choose one of these, or give --format."
    )


def check_formats(names: Sequence[FormatName], report_pdf: bool = False) -> None:
    """Raise now what writing would raise for want of a library, so that no long run ends in it.

    Args:
        names: of the formats that are to be written.
        report_pdf: whether the report is to be written as PDF, too.

    Raises:
        OutputError: a library is not installed.
    """
    if report_pdf:
        optional_module("reportlab", "plan", "report.pdf")
    for name in names:
        wanted = FORMATS[name]
        if wanted.library is not None:
            optional_module(wanted.library, wanted.extra, name)
