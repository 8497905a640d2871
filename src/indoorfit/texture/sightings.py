"""Which pixels of which faces an image shows, and their colours in it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from .canvas import Canvas
from .claim import reach_m
from .config import TextureConfig
from .views import Move, Planes, Sighting, View, sight, windows

_RIM = 0.1
"""Share of the image's shorter side over which its weight fades towards its rim."""


@dataclass(frozen=True)
class Surroundings:
    """What all views share, scan axes relative to `base_m`."""

    base_m: Float[np.ndarray, " 3"]
    foreign_m: Float[np.ndarray, "points 3"]
    """Thinned points on no face: furniture."""
    foreign_size_m: float


def sightings(
    view: View,
    planes: Planes,
    masks: Sequence[Bool[np.ndarray, "_ _"]],
    around: Surroundings,
    config: TextureConfig,
    move_of: Callable[[int], Move | None] = lambda _: None,
) -> Iterator[tuple[int, Sighting, Int[np.ndarray, " n"]]]:
    """Face, sighting and flat pixel numbers, for every face that the view shows.

    Args:
        view: of the image.
        planes: of all faces.
        masks: wanted pixels of every face.
        around: see `Surroundings`.
        config: see `TextureConfig`.
        move_of: by face, by how much what the image shows lies beside its place.
    """
    for window in windows(view, planes, around.base_m):
        canvas = planes.canvases[window.face]
        mask = masks[window.face][window.rows, window.columns]
        # Twice the reach: what is nearer than its own noise to the wall is the wall.
        clearance_m = 2.0 * reach_m(canvas.face, config)
        sighting = sight(view, planes, window, mask, around.base_m, clearance_m, move_of(window.face))
        row, column = np.nonzero(sighting.visible)
        if len(row):
            place = (row + window.rows.start) * canvas.columns + column + window.columns.start
            yield window.face, sighting, place


def footprint_of(view: View, sighting: Sighting, canvas: Canvas) -> float:
    """Pixels of the image along a side of a texture pixel, in the middle of what is seen."""
    return float(np.median(view.image.camera.fx * canvas.pixel_m / sighting.depth_m))


def weight_of(
    view: View, sighting: Sighting, canvas: Canvas, crisp: float, power: float
) -> Float[np.ndarray, " n"]:
    """How much the image counts at each pixel: its resolution there times its sharpness, to a power, fading
    towards its rim."""
    # Pixels along a side of the texture pixel, as if it were seen from the front.
    fine = np.sqrt(sighting.cosine) * view.image.camera.fx * canvas.pixel_m / sighting.depth_m
    return np.maximum((crisp * fine) ** power * _fade(view, sighting), 1e-12)


def _fade(view: View, sighting: Sighting) -> Float[np.ndarray, " n"]:
    """1 in the middle of the image, 0 at its rim."""
    camera = view.image.camera
    rim = np.minimum.reduce(
        [sighting.u, sighting.v, camera.width - 1.0 - sighting.u, camera.height - 1.0 - sighting.v]
    )
    return np.clip(rim / (_RIM * min(camera.width, camera.height)), 0.0, 1.0)
