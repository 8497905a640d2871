"""From colours with gaps to the raster that goes into a file."""

import numpy as np

from indoorfit.model import FaceTexture, TextureSource

from .canvas import Canvas
from .config import TextureConfig
from .fill import bleed, diffuse
from .nearest import Colouring


def finished(
    canvas: Canvas, colouring: Colouring, source: TextureSource, config: TextureConfig
) -> FaceTexture:
    """Fill or mark the gaps, continue the colours over the edge, round to bytes.

    Args:
        canvas: of the face.
        colouring: its colours, at least one pixel of them known.
        source: where they come from.
        config: `gaps` decides between filling and alpha.
    """
    mask, known = canvas.mask(), colouring.known
    n = max(int(mask.sum()), 1)
    seen, colours, alpha = int((known & mask).sum()) / n, colouring.colours, known
    filled = 0.0
    if config.gaps == "fill":
        colours, alpha, filled = diffuse(colours, known, mask), mask, 1.0 - seen
    else:
        colours = np.where(known[..., None], colours, colours[known].mean(axis=0))
    rgb = np.clip(bleed(colours, mask), 0.0, 255.0).round().astype(np.uint8)
    opaque = np.where(alpha, 255, 0).astype(np.uint8)
    return FaceTexture(
        face=canvas.face.id,
        origin_m=canvas.origin_m,
        right=canvas.right,
        down=canvas.down,
        pixel_m=canvas.pixel_m,
        rgba=np.dstack([rgb, opaque]),
        source=source,
        seen=seen,
        filled=filled,
    )
