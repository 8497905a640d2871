"""Camera images moved on the faces to where they agree, as poses are never as sharp as images."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from jaxtyping import Float, Int
from scipy import ndimage

from indoorfit.geometry import MAD_TO_STD
from indoorfit.model import CameraImage, FitResult

from .canvas import Canvas, canvas_of
from .config import TextureConfig
from .sampling import sampled, sharpness
from .sightings import Surroundings, footprint_of, sightings, weight_of
from .views import Move, View, planes_of, view_of

_COARSER = 2.0
"""Pixels of the alignment in pixels of the texture: edges are placed to a tenth of a pixel, so this is fine
enough and four times as fast."""
_ROUNDS = 3
"""Of moving all images towards the mean of the others, which grows sharper with each."""
_LEAST_PIXELS = 200
"""A view of less of a face is not worth aligning."""
_TURN_PER_M = 1.0
"""Turn and stretch, in radians (and parts) per metre of pose error: a hand-held camera that is 1 cm off is
some 10 mrad off, too."""
_FLOOR = 2.0
"""Grey levels by which two images of the same place differ at least: noise and compression."""
_EACH = 0.1
"""What one pixel's evidence counts: neighbouring pixels err together, over some three by three."""
_SMOOTH = 1.0
"""Pixels by which the mean is smoothed before its gradient is taken."""

Moves = dict[tuple[int, int], Move]
"""By number of the image and of the face; images that stay are not in it."""


def align(
    result: FitResult,
    images: Sequence[CameraImage],
    gains: Float[np.ndarray, "images 3"],
    around: Surroundings,
    config: TextureConfig,
) -> Moves:
    """For every image and face the affine move in the face's plane that makes it agree with the others.

    Each round compares every image with the weighted mean of all and takes a Gauss-Newton step; the
    priors (`pose_error_m` and the turn that goes with it) hold what no edge tells, and the mean of all moves,
    in place. Grey values, reweighted as for a Cauchy loss, so that glare and passers-by count little.

    Args:
        result: the fitted model.
        images: with poses in the scan frame.
        gains: of their exposures.
        around: see `Surroundings`.
        config: see `TextureConfig`.

    Source: B. Lucas & T. Kanade, An iterative image registration technique, IJCAI 1981; aligning to the mean
    instead of to each other is Q.-Y. Zhou & V. Koltun, Color map optimization, ACM Trans. Graph. 33 (2014).
    """
    pixel_m = _COARSER * config.image_pixel_m
    canvases = [canvas_of(face, result.frame, pixel_m, config.max_side) for face in result.faces]
    scene = _Scene(canvases, around, config)
    views = [
        view_of(image, scene.planes, around.base_m, around.foreign_m, around.foreign_size_m)
        for image in images
    ]
    moves: Moves = {}
    for _ in range(_ROUNDS):
        means = [_Mean(canvas) for canvas in canvases]
        for k, (view, gain) in enumerate(zip(views, gains, strict=True)):
            for face, place, grey, weight in _seen(k, view, gain, scene, moves):
                means[face].total[place] += weight * grey
                means[face].weight[place] += weight
        for mean in means:
            mean.finish()
        for k, (view, gain) in enumerate(zip(views, gains, strict=True)):
            for face, place, grey, weight in _seen(k, view, gain, scene, moves):
                if len(place) >= _LEAST_PIXELS:
                    moves[k, face] = _moved(moves.get((k, face)), means[face], place, grey, weight, config)
    return moves


class _Scene:
    """What all images share."""

    def __init__(self, canvases: Sequence[Canvas], around: Surroundings, config: TextureConfig) -> None:
        self.canvases, self.around, self.config = canvases, around, config
        self.planes = planes_of(canvases, around.base_m)
        self.masks = [canvas.mask() for canvas in canvases]


class _Mean:
    """Weighted mean of the grey values on one face, and its gradient."""

    def __init__(self, canvas: Canvas) -> None:
        self.canvas = canvas
        n = canvas.rows * canvas.columns
        self.total, self.weight = np.zeros(n), np.zeros(n)
        self.gradient: Float[np.ndarray, "2 pixels"] = np.zeros((2, n))

    def finish(self) -> None:
        """Take the gradient, in grey levels per metre; 0 where the mean is not known all around."""
        known = self.weight > 0.0
        shape = (self.canvas.rows, self.canvas.columns)
        grey = np.where(known, self.total / np.maximum(self.weight, 1e-30), 0.0).reshape(shape)
        if min(shape) < 3:
            return
        smooth = ndimage.gaussian_filter(grey, _SMOOTH)
        down, right = np.gradient(smooth, self.canvas.pixel_m)
        sound = ndimage.binary_erosion(known.reshape(shape), np.ones((3, 3), bool), 3)
        self.gradient = np.stack([right.ravel(), down.ravel()]) * sound.ravel()


def _seen(
    k: int, view: View, gain: Float[np.ndarray, " 3"], scene: _Scene, moves: Moves
) -> Iterator[tuple[int, Int[np.ndarray, " n"], Float[np.ndarray, " n"], Float[np.ndarray, " n"]]]:
    """Face, flat pixel numbers, grey values and weights of what one image shows, moved as it is by now."""
    pixels = view.image.load()
    crisp = sharpness(pixels)
    moved = partial(move_of, moves, k)
    for face, sighting, place in sightings(
        view, scene.planes, scene.masks, scene.around, scene.config, moved
    ):
        canvas = scene.canvases[face]
        colours = sampled(pixels, sighting.u, sighting.v, footprint_of(view, sighting, canvas))
        grey = (colours * gain.astype(np.float32)).mean(axis=1).astype(float)
        yield face, place, grey, weight_of(view, sighting, canvas, crisp, scene.config.view_power)


def move_of(moves: Moves, image: int, face: int) -> Move | None:
    """Where the image shows the face, if not where its pose says."""
    return moves.get((image, face))


def _moved(
    move: Move | None,
    mean: _Mean,
    place: Int[np.ndarray, " n"],
    grey: Float[np.ndarray, " n"],
    weight: Float[np.ndarray, " n"],
    config: TextureConfig,
) -> Move:
    """One Gauss-Newton step of one image on one face."""
    canvas = mean.canvas
    row, column = np.divmod(place, canvas.columns)
    x_m, y_m = (column + 0.5) * canvas.pixel_m, (row + 0.5) * canvas.pixel_m
    if move is None:
        move = Move(np.array([x_m.mean(), y_m.mean()]), np.zeros((2, 3)))
    others = mean.weight[place] - weight
    right, down = mean.gradient[:, place]
    # Where hardly anyone else looks there is nothing to agree with.
    used = (others > 0.1 * weight) & ((right != 0.0) | (down != 0.0))
    if used.sum() < _LEAST_PIXELS:
        return move
    place, x_m, y_m, right, down = place[used], x_m[used], y_m[used], right[used], down[used]
    # From the mean with its own share: two images that each went the whole way would change places.
    residual = grey[used] - mean.total[place] / mean.weight[place]
    residual = residual - np.median(residual)
    spread = max(_FLOOR, MAD_TO_STD * float(np.median(np.abs(residual))))
    trust = _EACH / spread**2 / (1.0 + (residual / (2.0 * spread)) ** 2)
    c = np.stack([x_m - move.centre_m[0], y_m - move.centre_m[1], np.ones(len(x_m))])
    slopes = np.concatenate([right * c, down * c])
    turn = config.pose_error_m * _TURN_PER_M
    prior = np.tile([turn, turn, config.pose_error_m], 2) ** -2.0
    system = (slopes * trust) @ slopes.T + np.diag(prior)
    wanted = (slopes * trust) @ residual + prior * move.matrix.ravel()
    return Move(move.centre_m, move.matrix - np.linalg.solve(system, wanted).reshape(2, 3))
