"""Reading NumPy files. Pickled objects are never loaded: they can run code."""

import re
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError

import numpy as np

from ..errors import InputError
from .raw import RawCloud, cloud_from_columns, colours_to_uint8

_FIX = "Fix: save with numpy.save(path, points) or numpy.savez(path, points=..., colours=..., frame=...)."
_POINT_KEYS = ("points", "xyz")
_COLOUR_KEYS = ("colours", "colors", "rgb")

# The array header is a Python literal, so a damaged one can fail in as many ways as a program can.
_DAMAGE = (ValueError, TypeError, SyntaxError, TokenError, OverflowError, MemoryError, EOFError, OSError)


def read_npy(path: Path) -> RawCloud:
    """An (n, 3) or (n, 6) array (colours last), or a structured array with fields x, y, z.

    Raises:
        InputError: no array file, an object array, another shape, or a truncated file.
    """
    try:
        # Mapped, so that a header that promises 1e12 rows fails at once and not in the allocator.
        with _quiet():
            array = np.load(path, mmap_mode="r", allow_pickle=False)
    except _DAMAGE as e:
        raise InputError(f"{path.name}: not a readable array file: {_short(e)}. {_FIX}") from e
    return _cloud_from_array(path.name, array)


def read_npz(path: Path) -> RawCloud:
    """Arrays under ``points`` or ``xyz``, ``colours``, ``colors`` or ``rgb``, and ``frame``.

    An archive of one array may call it anything.

    Raises:
        InputError: no archive, no points in it, lengths that differ, or damaged contents.
    """
    try:
        with zipfile.ZipFile(path) as archive, _quiet():
            members = {n.removesuffix(".npy"): n for n in archive.namelist() if n.endswith(".npy")}
            key = _pick(members, _POINT_KEYS) or (next(iter(members)) if len(members) == 1 else None)
            if key is None:
                raise InputError(
                    f"{path.name}: holds {', '.join(members) or 'no arrays'}; 'points' is needed. {_FIX}"
                )
            points = _member(archive, members[key])
            colour_key = _pick(members, _COLOUR_KEYS)
            colours = _member(archive, members[colour_key]) if colour_key else None
            frame = _member(archive, members["frame"]) if "frame" in members else None
    except (*_DAMAGE, zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError) as e:
        raise InputError(f"{path.name}: not a readable array archive: {_short(e)}. {_FIX}") from e
    raw = _cloud_from_array(path.name, points)
    if colours is None and frame is None:
        return raw
    columns = {name: raw.points[:, axis] for axis, name in enumerate("xyz")}
    if colours is not None:
        _check_length(path.name, "colours", colours, len(raw.points), (3, 4))
        columns |= {name: colours[:, axis] for axis, name in enumerate(("red", "green", "blue"))}
    if frame is not None:
        _check_length(path.name, "frame", frame, len(raw.points), None)
        columns["frame"] = frame
    combined = cloud_from_columns(path.name, columns)
    kept = raw.colours if colours is None else combined.colours
    notes = raw.notes + combined.notes
    return RawCloud(raw.points, kept, combined.frame_ids, raw.single_precision, notes)


@contextmanager
def _quiet() -> Iterator[None]:
    """NumPy warns of headers from Python 2, which it reads all the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        yield


def _member(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    info = archive.getinfo(name)
    with archive.open(info) as file:
        version = np.lib.format.read_magic(file)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get(version)
        if read_header is None:
            raise ValueError(f"the array {name} has the format version {version}; 1.0 or 2.0 is needed")
        shape, _, dtype = read_header(file)
        # NumPy allocates what the array's header says; the archive knows what is really there.
        n_bytes = int(np.prod([int(extent) for extent in shape], dtype=object)) * dtype.itemsize
        if n_bytes > info.file_size:
            raise ValueError(f"the array {name} promises {n_bytes} bytes, the archive holds {info.file_size}")
    with archive.open(info) as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _cloud_from_array(where: str, array: np.ndarray) -> RawCloud:
    names = array.dtype.names
    if names is not None and array.ndim == 1:
        odd = [name for name in names if array.dtype[name].kind not in "fiu"]
        return cloud_from_columns(where, {name: array[name] for name in names if name not in odd})
    if array.ndim != 2 or array.shape[1] not in (3, 6) or array.dtype.kind not in "fiu":
        raise InputError(
            f"{where}: found an array of {array.dtype} and shape {array.shape}; real numbers of shape "
            f"(n, 3) or (n, 6), or a structured array with x, y, z are needed. {_FIX}"
        )
    colours = colours_to_uint8(array[:, 3:]) if array.shape[1] == 6 else None
    single = array.dtype.kind == "f" and array.dtype.itemsize <= 4
    with np.errstate(over="ignore", invalid="ignore"):  # longdouble may overflow to inf, dropped later
        points = np.array(array[:, :3], dtype=np.float64)
    return RawCloud(points, colours, single_precision=single)


def _check_length(where: str, name: str, array: np.ndarray, n: int, widths: tuple[int, ...] | None) -> None:
    sound = array.ndim == 1 if widths is None else array.ndim == 2 and array.shape[1] in widths
    if not sound or len(array) != n or array.dtype.kind not in "fiu":
        needed = (n,) if widths is None else (n, widths[0])
        raise InputError(
            f"{where}: '{name}' has type {array.dtype} and shape {array.shape}; numbers of shape {needed} "
            f"are needed. {_FIX}"
        )


def _pick(members: dict[str, str], keys: Sequence[str]) -> str | None:
    return next((key for key in keys if key in members), None)


def _short(error: Exception) -> str:
    # NumPy's own messages advise allow_pickle, which is what must not happen.
    text = str(error).split("\n")[0]
    return (
        "it holds pickled objects, which are not loaded"
        if re.search("pickle|Python object", text)
        else text[:120]
    )
