"""What every format's reader hands to `scan`: columns of the file, not yet converted or checked."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8

from ..errors import InputError
from ..model import Note

_COLOUR_NAMES = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
    ("rf", "gf", "bf"),
)


@dataclass(frozen=True)
class RawCloud:
    """A cloud as the file holds it: file units, non-finite points included."""

    points: Float[np.ndarray, "points 3"]
    """File units, float64, owned by this object (callers may write to it)."""
    colours: UInt8[np.ndarray, "points 3"] | None = None
    frame_ids: Int[np.ndarray, " points"] | None = None
    single_precision: bool = False
    """The file stores coordinates as 32-bit floats."""
    notes: tuple[Note, ...] = ()


def cloud_from_columns(where: str, columns: Mapping[str, np.ndarray]) -> RawCloud:
    """Coordinates, colours and frame ids picked from named columns; other columns are ignored.

    Args:
        where: file name for messages.
        columns: real-valued columns of equal length; names are compared in lower case.

    Raises:
        InputError: x, y or z is missing.
    """
    by_name = {name.lower(): column for name, column in columns.items()}
    missing = [axis for axis in "xyz" if axis not in by_name]
    if missing:
        raise InputError(
            f"{where}: the points have no {', '.join(missing)} among {', '.join(by_name) or 'no columns'}; "
            "x, y and z are needed. Fix: export the cloud with its coordinates."
        )
    points = np.empty((len(by_name["x"]), 3))
    with np.errstate(invalid="ignore"):  # a signalling NaN in the file is dropped later, with a count
        for axis, name in enumerate("xyz"):
            points[:, axis] = by_name[name]
    colours, colour_notes = _colours_of(by_name)
    frame_ids, frame_notes = _frame_ids_of(by_name)
    single = by_name["x"].dtype.kind == "f" and by_name["x"].dtype.itemsize <= 4
    return RawCloud(points, colours, frame_ids, single, colour_notes + frame_notes)


def colours_to_uint8(values: np.ndarray) -> UInt8[np.ndarray, "points 3"] | None:
    """Colours on any usual scale as 0 to 255.

    Integers up to 255 are taken as they are, larger ones as 16 bit. Floats up to 1 are scaled by
    255, up to 255 rounded, larger ones taken as 16 bit. A NaN becomes 0.

    Returns:
        None where the values are on none of these scales (negative, or beyond 65535).
    """
    if values.dtype == np.uint8:
        return np.ascontiguousarray(values)
    is_float = values.dtype.kind == "f"
    if is_float:
        values = np.nan_to_num(values.astype(np.float64), nan=0.0, posinf=-1.0, neginf=-1.0)
    low, high = (values.min(), values.max()) if values.size else (0, 0)
    if low < 0 or high > 65535:
        return None
    # Resampling overshoots: 1.01 is still the scale that ends at 1.
    if is_float and high <= 1.01:
        return np.rint(np.minimum(values, 1.0) * 255.0).astype(np.uint8)
    if high <= 255:
        return np.rint(values).astype(np.uint8)
    return np.rint(values / 257.0).astype(np.uint8)


def _colours_of(
    columns: Mapping[str, np.ndarray],
) -> tuple[UInt8[np.ndarray, "points 3"] | None, tuple[Note, ...]]:
    for names in _COLOUR_NAMES:
        if all(name in columns for name in names):
            first, second, third = (columns[name] for name in names)
            stacked = np.empty((len(first), 3), dtype=np.result_type(first, second, third))
            stacked[:, 0], stacked[:, 1], stacked[:, 2] = first, second, third
            colours = colours_to_uint8(stacked)
            if colours is None:
                text = f"The columns {', '.join(names)} have no known scale (0 to 1, 255 or 65535); ignored."
                return None, (Note("COLOURS_UNREADABLE", text),)
            return colours, ()
    return None, ()


def _frame_ids_of(
    columns: Mapping[str, np.ndarray],
) -> tuple[Int[np.ndarray, " points"] | None, tuple[Note, ...]]:
    column = columns.get("frame")
    if column is None:
        return None, ()
    if column.dtype.kind not in "iu":
        # Beyond 2^53 neighbouring integers are no longer apart in a float.
        sound = np.isfinite(column) & (np.abs(np.nan_to_num(column)) < 2.0**53)
        if not (sound.all() and np.array_equal(column, np.rint(column))):
            return None, (Note("FRAMES_UNREADABLE", "The column frame holds non-integers; ignored."),)
    return column.astype(np.int64), ()
