"""The display list as pixels."""

from itertools import pairwise

import numpy as np
from jaxtyping import Float
from PIL import Image, ImageDraw

from .display import CAP_HEIGHT, Dots, Item, Label, Picture, Region, Stroke
from .lettering import SUPERSCRIPT_RISE, SUPERSCRIPT_SIZE, font, runs, text_width

_OVERSAMPLING = 2
"""Pillow draws lines without smoothing; twice the size and a mean over 2 x 2 pixels smooths them."""


def to_image(picture: Picture, scale: float = 1.5) -> Image.Image:
    """Draw a picture.

    Args:
        picture: what to draw.
        scale: pixels per page unit.
    """
    factor = scale * _OVERSAMPLING
    size = (round(picture.width * factor), round(picture.height * factor))
    image = Image.new("RGB", size, picture.background)
    for item in picture.items:
        _draw(image, item, factor)
    return image.reduce(_OVERSAMPLING)


def _draw(image: Image.Image, item: Item, factor: float) -> None:
    pen = ImageDraw.Draw(image)
    match item:
        case Region():
            _draw_region(image, item, factor)
        case Stroke():
            for a, b in _dashes(item.points * factor, item.dash, factor):
                _draw_segment(pen, a, b, item.colour, item.width * factor, extend=False)
        case Dots():
            radius = 0.5 * item.diameter * factor
            for x, y in (item.centres * factor).tolist():
                pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=item.colour)
        case Label():
            _draw_label(image, item, factor)


def _draw_region(image: Image.Image, region: Region, factor: float) -> None:
    rings = [[(x, y) for x, y in (ring * factor).tolist()] for ring in region.rings]
    if region.fill and len(rings) == 1:
        ImageDraw.Draw(image).polygon(rings[0], fill=region.fill)
    elif region.fill:
        mask = Image.new("L", image.size, 0)
        pen = ImageDraw.Draw(mask)
        for k, ring in enumerate(rings):
            pen.polygon(ring, fill=0 if k else 255)
        image.paste(region.fill, (0, 0), mask)
    if region.stroke:
        pen = ImageDraw.Draw(image)
        for ring in region.rings:
            for a, b in zip(ring * factor, np.roll(ring, -1, axis=0) * factor, strict=True):
                _draw_segment(pen, a, b, region.stroke, region.width * factor, extend=True)


def _draw_segment(
    pen: ImageDraw.ImageDraw,
    a: Float[np.ndarray, " 2"],
    b: Float[np.ndarray, " 2"],
    colour: str,
    width: float,
    extend: bool,
) -> None:
    """A line as a rectangle; `extend` by half its width closes right-angled corners like a mitre."""
    length = float(np.linalg.norm(b - a))
    if length == 0.0:
        return
    along = (b - a) / length * 0.5 * width
    across = np.array([-along[1], along[0]])
    if extend:
        a, b = a - along, b + along
    pen.polygon(
        [(x, y) for x, y in np.array([a - across, b - across, b + across, a + across]).tolist()], colour
    )


def _dashes(points: Float[np.ndarray, "points 2"], dash: tuple[float, float] | None, factor: float):
    """The inked pieces of a line."""
    for a, b in pairwise(points):
        length = float(np.linalg.norm(b - a))
        if dash is None or length == 0.0:
            yield a, b
            continue
        period = sum(dash) * factor
        for start in np.arange(0.0, length, period):
            end = min(start + dash[0] * factor, length)
            yield a + (b - a) * (start / length), a + (b - a) * (end / length)


def _draw_label(image: Image.Image, label: Label, factor: float) -> None:
    size = label.size * factor
    width = text_width(label.text, size)
    margin = int(0.5 * size)
    # The text goes to a patch of its own, which can be turned; its anchor is the patch's middle.
    patch_size = (int(width) + 2 * margin, int(1.2 * size) + 2 * margin)
    ink, halo = Image.new("L", patch_size, 0), Image.new("L", patch_size, 0)
    x, baseline = 0.5 * (patch_size[0] - width), 0.5 * patch_size[1] + 0.5 * CAP_HEIGHT * size
    for piece, raised in runs(label.text):
        face = font(size * (SUPERSCRIPT_SIZE if raised else 1.0))
        at = (x, baseline - (SUPERSCRIPT_RISE * size if raised else 0.0))
        ImageDraw.Draw(ink).text(at, piece, fill=255, font=face, anchor="ls")
        if label.halo:
            around = 0.14 * size
            ImageDraw.Draw(halo).text(at, piece, fill=255, font=face, anchor="ls", stroke_width=around)
        x += float(face.getlength(piece))
    shift = {"start": 0.5, "middle": 0.0, "end": -0.5}[label.anchor] * width
    centre = (label.at[0] * factor + shift, label.at[1] * factor)
    if label.upright:
        ink, halo = (layer.transpose(Image.Transpose.ROTATE_90) for layer in (ink, halo))
        centre = (label.at[0] * factor, label.at[1] * factor - shift)
    corner = (round(centre[0] - 0.5 * ink.width), round(centre[1] - 0.5 * ink.height))
    if label.halo:
        image.paste(label.halo, corner, halo)
    image.paste(label.colour, corner, ink)
