"""Reading pictures, with limits: a file from anywhere may be huge or made to fill the memory."""

import warnings
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image, ImageOps

from indoorfit.errors import InputError

MAX_PICTURE_PIXELS = 80_000_000
"""Larger pictures are refused: 80 megapixels take 240 MB, and more than any wall can show."""

_FORMATS = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")
"""Pillow knows others that start programs or have had no reader's care for years."""


def read_picture(path: str | Path) -> UInt8[np.ndarray, "height width 3"]:
    """The pixels of a picture, turned as its EXIF orientation says, alpha dropped.

    Raises:
        InputError: no such file, no picture, or one with more than `MAX_PICTURE_PIXELS`.
    """
    name = Path(path).name
    try:
        with warnings.catch_warnings():
            # Pillow warns of what is refused below.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=_FORMATS) as picture:
                _check_size(picture, name)
                # 16 bits would be cut off at 255, not scaled.
                if picture.mode.startswith("I;16"):
                    picture = Image.fromarray((np.asarray(picture) >> 8).astype(np.uint8))
                upright = ImageOps.exif_transpose(picture)
                return np.asarray(upright.convert("RGB"))
    except Image.DecompressionBombError as error:
        raise _too_large(name, "more than twice as many") from error
    except OSError as error:
        reason = error.strerror or "not a JPEG, PNG, WebP, TIFF or BMP picture, or damaged"
        raise InputError(f"{path}: cannot be read ({reason}). Fix: check the file.") from error
    except (ValueError, SyntaxError, MemoryError) as error:
        raise InputError(
            f"{name}: damaged ({error}); a whole picture is needed. Fix: save it again."
        ) from error


def _check_size(picture: Image.Image, name: str) -> None:
    n_pixels = picture.width * picture.height
    if n_pixels > MAX_PICTURE_PIXELS:
        raise _too_large(name, f"{picture.width} x {picture.height}")


def _too_large(name: str, found: str) -> InputError:
    return InputError(
        f"{name}: {found} pixels; at most {MAX_PICTURE_PIXELS // 10**6} million are read. "
        "Fix: make it smaller."
    )
