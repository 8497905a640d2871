"""Textures from posed camera images (thesis 7.3, the last recommendation)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.model import CameraImage, FaceTexture, FitResult, Scan

from .canvas import Canvas, canvas_of
from .claim import claim_points, reach_m
from .config import TextureConfig
from .exposure import balance
from .finish import finished
from .nearest import Colouring, colour_from_points
from .sampling import sampled, sharpness
from .views import Planes, Sighting, View, planes_of, sight, view_of, windows

_SPARSE_M = 0.10
"""Distance of the places where exposures are compared: some hundreds on a wall."""
_RIM = 0.1
"""Share of the image's shorter side over which its weight fades towards its rim."""
_DARK, _BRIGHT = 8.0, 247.0
"""Values beyond are cut off by the camera and tell no exposure."""


@dataclass(frozen=True)
class _Surroundings:
    """What all views share, scan axes relative to `base_m`."""

    base_m: Float[np.ndarray, " 3"]
    foreign_m: Float[np.ndarray, "points 3"]
    """Thinned points on no face: furniture."""
    foreign_size_m: float


def texture_from_images(
    result: FitResult, scan: Scan, images: Sequence[CameraImage], config: TextureConfig
) -> tuple[FaceTexture, ...]:
    """A texture for every face that an image shows.

    Every texture pixel gets the mean of the images that see it, which is nearly that of the best ones alone:
    the weight is a power of the resolution on the face (distance and angle), times sharpness, and fades
    towards the image's rim, so that seams blend. Other faces and the scan's own points hide what is behind
    them. Pixels that no image saw take the colours of the points around, if the scan has colours.

    Args:
        result: the fitted model.
        scan: the cloud that it was fitted to.
        images: with poses in the scan frame.
        config: see `TextureConfig`.

    Raises:
        InputError: an image cannot be read.
    """
    canvases = [canvas_of(face, result.frame, config.image_pixel_m, config.max_side) for face in result.faces]
    base_m = result.frame.origin_scan_m
    points_m = scan.points_m - base_m
    claimed = claim_points(points_m, base_m, canvases, config)
    around = _surroundings(points_m, base_m, canvases, claimed)
    gains = _gains(result, images, around, config) if config.exposure else np.ones((len(images), 3))
    found = _blend(canvases, images, gains, around, config)
    textures = []
    for canvas, colouring, chosen in zip(canvases, found, claimed, strict=True):
        if scan.colours is not None and len(chosen):
            x_m, y_m = canvas.coordinates_m(points_m[chosen], base_m)
            below = colour_from_points(
                canvas, canvas.mask(), x_m, y_m, scan.colours[chosen], wanted=~colouring.known
            )
            colouring = _over(colouring, below)
        if colouring.known.any():
            textures.append(finished(canvas, colouring, "images", config))
    return tuple(textures)


def _over(upper: Colouring, lower: Colouring) -> Colouring:
    """One colouring where it is known, else the other."""
    colours = np.where(upper.known[..., None], upper.colours, lower.colours)
    return Colouring(colours, upper.known | lower.known)


def _surroundings(
    points_m: Float[np.ndarray, "points 3"],
    base_m: Float[np.ndarray, " 3"],
    canvases: Sequence[Canvas],
    claimed: Sequence[np.ndarray],
) -> _Surroundings:
    """The furniture: points on no face, one in each cube as large as the spacing of the points on faces."""
    on_face = np.zeros(len(points_m), bool)
    for chosen in claimed:
        on_face[chosen] = True
    area_m2 = sum(float(canvas.mask().sum()) * canvas.pixel_m**2 for canvas in canvases)
    size_m = max(0.02, float(np.sqrt(area_m2 / max(int(on_face.sum()), 1))))
    foreign_m = points_m[~on_face]
    cells = np.floor(foreign_m / size_m).astype(np.int64)
    cells -= cells.min(axis=0, initial=0)
    sides = cells.max(axis=0, initial=0) + 1
    _, first = np.unique(np.ravel_multi_index(tuple(cells.T), tuple(sides)), return_index=True)
    return _Surroundings(base_m, foreign_m[first], size_m)


def _gains(
    result: FitResult, images: Sequence[CameraImage], around: _Surroundings, config: TextureConfig
) -> Float[np.ndarray, "images 3"]:
    """Exposure factors, from colours at places that several images show."""
    canvases = [canvas_of(face, result.frame, _SPARSE_M, config.max_side) for face in result.faces]
    planes = planes_of(canvases, around.base_m)
    masks = [canvas.mask() for canvas in canvases]
    starts = np.cumsum([0, *(mask.size for mask in masks)])
    samples = np.full((len(images), int(starts[-1]), 3), np.nan, np.float32)
    for k, image in enumerate(images):
        view = view_of(image, planes, around.base_m, around.foreign_m, around.foreign_size_m)
        pixels = image.load()
        for face, sighting, place in _sightings(view, planes, masks, around, config):
            footprint = _footprint(view, sighting, canvases[face])
            colours = sampled(pixels, sighting.u, sighting.v, 0.5 * footprint)
            colours[((colours < _DARK) | (colours > _BRIGHT)).any(axis=1)] = np.nan
            samples[k, starts[face] + place] = colours
    return balance(samples.astype(float))


def _blend(
    canvases: Sequence[Canvas],
    images: Sequence[CameraImage],
    gains: Float[np.ndarray, "images 3"],
    around: _Surroundings,
    config: TextureConfig,
) -> list[Colouring]:
    planes = planes_of(canvases, around.base_m)
    masks = [canvas.mask() for canvas in canvases]
    sums = [np.zeros((canvas.rows * canvas.columns, 3), np.float32) for canvas in canvases]
    weights = [np.zeros(canvas.rows * canvas.columns, np.float32) for canvas in canvases]
    for image, gain in zip(images, gains, strict=True):
        view = view_of(image, planes, around.base_m, around.foreign_m, around.foreign_size_m)
        pixels = image.load()
        crisp = sharpness(pixels)
        for face, sighting, place in _sightings(view, planes, masks, around, config):
            footprint = _footprint(view, sighting, canvases[face])
            colours = sampled(pixels, sighting.u, sighting.v, footprint) * gain.astype(np.float32)
            # Pixels along a side of the texture pixel, as if it were seen from the front.
            fine = np.sqrt(sighting.cosine) * image.camera.fx * canvases[face].pixel_m / sighting.depth_m
            weight = (crisp * fine) ** config.view_power * _fade(view, sighting)
            weight = np.maximum(weight, 1e-12).astype(np.float32)
            weights[face][place] += weight
            sums[face][place] += weight[:, None] * colours
    found = []
    for canvas, total, weight in zip(canvases, sums, weights, strict=True):
        known = (weight > 0.0).reshape(canvas.rows, canvas.columns)
        mean = total / np.maximum(weight, 1e-30)[:, None]
        found.append(Colouring(mean.reshape(canvas.rows, canvas.columns, 3).astype(float), known))
    return found


def _sightings(
    view: View,
    planes: Planes,
    masks: Sequence[Bool[np.ndarray, "_ _"]],
    around: _Surroundings,
    config: TextureConfig,
) -> Iterator[tuple[int, Sighting, Int[np.ndarray, " n"]]]:
    """Face, sighting and flat pixel numbers, for every face that the view shows."""
    for window in windows(view, planes, around.base_m):
        canvas = planes.canvases[window.face]
        mask = masks[window.face][window.rows, window.columns]
        # Twice the reach: what is nearer than its own noise to the wall is the wall.
        clearance_m = 2.0 * reach_m(canvas.face, config)
        sighting = sight(view, planes, window, mask, around.base_m, clearance_m)
        row, column = np.nonzero(sighting.visible)
        if len(row):
            place = (row + window.rows.start) * canvas.columns + column + window.columns.start
            yield window.face, sighting, place


def _footprint(view: View, sighting: Sighting, canvas: Canvas) -> float:
    """Pixels of the image along a side of a texture pixel, in the middle of what is seen."""
    return float(np.median(view.image.camera.fx * canvas.pixel_m / sighting.depth_m))


def _fade(view: View, sighting: Sighting) -> Float[np.ndarray, " n"]:
    """1 in the middle of the image, 0 at its rim."""
    camera = view.image.camera
    rim = np.minimum.reduce(
        [sighting.u, sighting.v, camera.width - 1.0 - sighting.u, camera.height - 1.0 - sighting.v]
    )
    return np.clip(rim / (_RIM * min(camera.width, camera.height)), 0.0, 1.0)
