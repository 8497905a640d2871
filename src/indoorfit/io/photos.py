"""Photos for faces, named on the command line or in a TOML file."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from indoorfit.errors import InputError
from indoorfit.model import Photo

from .pictures import read_picture

_FORM = "FACE=FILE:x1,y1,x2,y2,x3,y3,x4,y4"


def photo_from_text(text: str) -> Photo:
    """A photo as the command line names it: ``wall-3=img.jpg:x1,y1,x2,y2,x3,y3,x4,y4``.

    The corners are the face's upper left, upper right, lower right and lower left as seen from inside, in
    pixels from the upper left corner of the photo as a viewer shows it (EXIF orientation applied).

    Raises:
        InputError: the text has another form, or the photo cannot be read.
    """
    face, equals, rest = text.partition("=")
    # The last colon: a path may have others.
    path, colon, numbers = rest.rpartition(":")
    if not (face and equals and path and colon):
        raise InputError(
            f"--photo {text}: needed {_FORM}. Fix: e.g. wall-3=img.jpg:10,5,900,8,890,600,12,610."
        )
    return _photo(face, Path(path), numbers.split(","), f"--photo {text}")


def read_photos(path: str | Path) -> tuple[Photo, ...]:
    """The photos of a TOML file; paths in it are relative to it.

    ::

        [wall-3]
        file = "img.jpg"
        corners = [[10, 5], [900, 8], [890, 600], [12, 610]]

    Raises:
        InputError: the file is missing or wrong, or a photo cannot be read.
    """
    path = Path(path)
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}). Fix: check the path.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path.name}: not TOML ({error}). Fix: see docs/textures.md.") from error
    return tuple(_entry(face, table, path) for face, table in tables.items())


def _entry(face: str, table: Any, path: Path) -> Photo:
    where = f"{path.name}: [{face}]"
    if not isinstance(table, dict) or set(table) != {"file", "corners"} or not isinstance(table["file"], str):
        raise InputError(f"{where}: needed file and corners, and nothing else. Fix: see docs/textures.md.")
    corners = table["corners"]
    flat = (
        [x for pair in corners for x in (pair if isinstance(pair, list) else [pair])]
        if (isinstance(corners, list))
        else []
    )
    return _photo(face, path.parent / table["file"], flat, where)


def _photo(face: str, path: Path, numbers: list[Any], where: str) -> Photo:
    try:
        corners = np.array([float(number) for number in numbers]).reshape(4, 2)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{where}: got {len(numbers)} values for the corners; needed 8 numbers, x and y of upper left, "
            "upper right, lower right, lower left. Fix: give them in pixels."
        ) from error
    if not np.isfinite(corners).all() or np.abs(corners).max() > 1e6:
        raise InputError(f"{where}: corners must be finite and within a million pixels. Fix: correct them.")
    return Photo(face, path.name, read_picture(path), corners)
