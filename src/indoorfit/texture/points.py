"""Textures from the colours of the scan's points (thesis 3.3.1)."""

from collections.abc import Sequence

from indoorfit.errors import InputError
from indoorfit.model import FaceTexture, FitResult, Scan

from .canvas import Canvas, canvas_of
from .claim import claim_points
from .config import TextureConfig
from .finish import finished
from .nearest import Colouring, colour_from_points


def texture_from_points(result: FitResult, scan: Scan, config: TextureConfig) -> tuple[FaceTexture, ...]:
    """A texture for every face that has coloured points; the others get none.

    Args:
        result: the fitted model.
        scan: the cloud that it was fitted to, with colours.
        config: see `TextureConfig`.

    Raises:
        InputError: the scan has no colours.
    """
    canvases = [canvas_of(face, result.frame, config.pixel_m, config.max_side) for face in result.faces]
    found = colourings(result, scan, canvases, config)
    textures = [
        finished(canvas, colouring, "points", config)
        for canvas, colouring in zip(canvases, found, strict=True)
        if colouring.known.any()
    ]
    return tuple(textures)


def colourings(
    result: FitResult, scan: Scan, canvases: Sequence[Canvas], config: TextureConfig
) -> list[Colouring]:
    """The colours that the points give to each canvas, in their order.

    Raises:
        InputError: the scan has no colours.
    """
    if scan.colours is None:
        raise InputError(
            f"{scan.name}: has no colours; textures from points need a colour for each. "
            "Fix: give camera images or photos, or leave the textures out."
        )
    base_m = result.frame.origin_scan_m
    points_m = scan.points_m - base_m
    found = []
    for canvas, chosen in zip(canvases, claim_points(points_m, base_m, canvases, config), strict=True):
        x_m, y_m = canvas.coordinates_m(points_m[chosen], base_m)
        found.append(colour_from_points(canvas, canvas.mask(), x_m, y_m, scan.colours[chosen]))
    return found
