"""Textures from posed camera images (thesis 7.3, the last recommendation)."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from jaxtyping import Float

from indoorfit.model import CameraImage, FaceTexture, FitResult, Scan

from .align import Moves, align, move_of
from .canvas import Canvas, canvas_of
from .claim import claim_points
from .config import TextureConfig
from .exposure import balance
from .finish import finished
from .nearest import Colouring, colour_from_points
from .sampling import sampled, sharpness
from .sightings import Surroundings, footprint_of, sightings, weight_of
from .views import planes_of, view_of

_SPARSE_M = 0.10
"""Distance of the places where exposures are compared: some hundreds on a wall."""
_DARK, _BRIGHT = 8.0, 247.0
"""Values beyond are cut off by the camera and tell no exposure."""


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
    moves = align(result, images, gains, around, config) if config.align else {}
    found = _blend(canvases, images, gains, moves, around, config)
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
) -> Surroundings:
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
    return Surroundings(base_m, foreign_m[first], size_m)


def _gains(
    result: FitResult, images: Sequence[CameraImage], around: Surroundings, config: TextureConfig
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
        for face, sighting, place in sightings(view, planes, masks, around, config):
            footprint = footprint_of(view, sighting, canvases[face])
            colours = sampled(pixels, sighting.u, sighting.v, 0.5 * footprint)
            colours[((colours < _DARK) | (colours > _BRIGHT)).any(axis=1)] = np.nan
            samples[k, starts[face] + place] = colours
    return balance(samples.astype(float))


def _blend(
    canvases: Sequence[Canvas],
    images: Sequence[CameraImage],
    gains: Float[np.ndarray, "images 3"],
    moves: Moves,
    around: Surroundings,
    config: TextureConfig,
) -> list[Colouring]:
    planes = planes_of(canvases, around.base_m)
    masks = [canvas.mask() for canvas in canvases]
    sums = [np.zeros((canvas.rows * canvas.columns, 3), np.float32) for canvas in canvases]
    weights = [np.zeros(canvas.rows * canvas.columns, np.float32) for canvas in canvases]
    for k, (image, gain) in enumerate(zip(images, gains, strict=True)):
        view = view_of(image, planes, around.base_m, around.foreign_m, around.foreign_size_m)
        pixels = image.load()
        crisp = sharpness(pixels)
        moved = partial(move_of, moves, k)
        for face, sighting, place in sightings(view, planes, masks, around, config, moved):
            footprint = footprint_of(view, sighting, canvases[face])
            colours = sampled(pixels, sighting.u, sighting.v, footprint) * gain.astype(np.float32)
            weight = weight_of(view, sighting, canvases[face], crisp, config.view_power).astype(np.float32)
            weights[face][place] += weight
            sums[face][place] += weight[:, None] * colours
    found = []
    for canvas, total, weight in zip(canvases, sums, weights, strict=True):
        known = (weight > 0.0).reshape(canvas.rows, canvas.columns)
        mean = total / np.maximum(weight, 1e-30)[:, None]
        found.append(Colouring(mean.reshape(canvas.rows, canvas.columns, 3).astype(float), known))
    return found
