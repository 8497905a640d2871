"""Rasters as the bytes of image files."""

import io

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from indoorfit.model import TextureImage

from .config import TextureConfig

_SUFFIX = {"png": "png", "jpeg": "jpg", "webp": "webp"}


def encoded(stem: str, rgba: UInt8[np.ndarray, "rows columns 4"], config: TextureConfig) -> TextureImage:
    """An image file of a raster; alpha is left out where nothing is transparent, and by JPEG."""
    opaque = config.format == "jpeg" or bool((rgba[..., 3] == 255).all())
    picture = Image.fromarray(rgba[..., :3] if opaque else rgba)
    if config.power_of_two:
        picture = picture.resize(
            (_power_of_two(picture.width), _power_of_two(picture.height)), Image.Resampling.BILINEAR
        )
    content = io.BytesIO()
    if config.format == "png":
        # Point colours are mostly noise: more effort than 3 of 9 saves a few per cent and costs seconds.
        picture.save(content, "PNG", compress_level=3)
    elif config.format == "jpeg":
        picture.save(content, "JPEG", quality=config.quality, subsampling=0)
    else:
        # exact: the colours under alpha 0 are part of the contract of `FaceTexture`.
        picture.save(content, "WEBP", quality=config.quality, exact=True, method=4)
    name = f"{stem}.{_SUFFIX[config.format]}"
    return TextureImage(name, config.format, picture.width, picture.height, content.getvalue())


def _power_of_two(n: int) -> int:
    """The next power of two that is not smaller."""
    return 1 << (n - 1).bit_length()
