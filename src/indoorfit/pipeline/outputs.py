"""A result written to a directory, whole or not at all."""

from collections.abc import Sequence
from pathlib import Path

from indoorfit.config import RunConfig, config_from_dict
from indoorfit.export import write_dimensions_csv, write_glb, write_images, write_obj, write_vrml
from indoorfit.files import FormatName, atomic_directory
from indoorfit.fitting import AssociationConfig, register
from indoorfit.io import write_model_json
from indoorfit.model import FitResult, Scan
from indoorfit.report import (
    plan_picture,
    render_png,
    report_html,
    report_pdf,
    residuals_of,
    to_svg,
    write_picture_png,
)

from .formats import FORMATS
from .overriding import without_boxes


def write_outputs(
    result: FitResult,
    directory: str | Path,
    scan: Scan | None,
    *,
    overwrite: bool,
    formats: Sequence[FormatName] = (),
    pdf: bool = False,
) -> None:
    """Write model.json, GLB, VRML, OBJ, textures, the dimension table, the plan, a view and the report.

    Args:
        result: what to write.
        directory: created; its parents too.
        scan: drawn faintly behind the plan where given.
        overwrite: replace an earlier result in the same place.
        formats: further files, of the formats that are not written anyway.
        pdf: write the report as report.pdf, too.

    Raises:
        OutputError: the directory exists without `overwrite`, or cannot be written, or a library that a
            format needs is not installed.
    """
    points_m = None if scan is None else as_fitted(scan, result).points_m
    with atomic_directory(directory, overwrite=overwrite) as out:
        write_model_json(out / "model.json", result)
        write_images(out, result)
        write_glb(out / "model.glb", result)
        write_vrml(out / "model.wrl", result)
        write_obj(out / "model.obj", result)
        write_dimensions_csv(out / "dimensions.csv", result)
        # Laying the plan out takes longer than drawing it: once for both formats.
        picture = plan_picture(result, points_m)
        drawing = to_svg(picture)
        (out / "plan.svg").write_text(drawing, encoding="utf-8")
        write_picture_png(out / "plan.png", picture)
        render_png(out / "view.png", result)
        residuals = None if points_m is None else residuals_of(result, points_m, _association(result))
        (out / "report.html").write_text(report_html(result, drawing, residuals), encoding="utf-8")
        if pdf:
            (out / "report.pdf").write_bytes(report_pdf(result, picture))
        for name in formats:
            target = out / FORMATS[name].file_name
            if not target.exists():
                FORMATS[name].write(target, result, None)


def as_fitted(scan: Scan, result: FitResult) -> Scan:
    """The scan as its model speaks of it: without what was ignored, displaced frames where they belong.

    Of those frames the slips are taken out, too: some millimetres.

    Args:
        scan: that was given to the fit.
        result: of the fit.
    """
    said = _config(result).overrides
    if said.ignore_box:
        scan = without_boxes(scan, said)
    displaced = [motion for motion in result.registration if motion.displaced]
    return scan if scan.frame_ids is None or not displaced else register(scan, displaced)


def _association(result: FitResult) -> AssociationConfig:
    """Which points the fit let its planes claim: the report speaks of the same."""
    return _config(result).joint.association


def _config(result: FitResult) -> RunConfig:
    return config_from_dict(dict(result.provenance.get("config", {})))
