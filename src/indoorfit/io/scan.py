"""From a file or from arrays to a checked `Scan` in metres."""

import hashlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..model import Scan
from .arrays import read_npy, read_npz
from .checked_scan import checked_scan, frame_notes
from .frames import frames_path, read_frames_json
from .pcd import read_pcd
from .ply import read_ply
from .raw import RawCloud, colours_to_uint8
from .text import looks_like_text, read_text
from .text_names import printable_name
from .units import Unit, metres_per_unit

_READERS: dict[str, Callable[[Path], RawCloud]] = {
    ".ply": read_ply,
    ".pcd": read_pcd,
    ".npy": read_npy,
    ".npz": read_npz,
} | dict.fromkeys((".xyz", ".txt", ".csv", ".pts", ".asc"), read_text)

_CONVERT = dict.fromkeys((".e57", ".las", ".laz", ".ptx", ".rcp", ".rcs", ".fls", ".zfs"), "PLY")

_MAGIC = (
    (b"ply", ".ply"), (b"# .PCD", ".pcd"), (b"VERSION", ".pcd"), (b"\x93NUMPY", ".npy"),
    (b"PK\x03\x04", ".npz"), (b"ASTM-E57", ".e57"), (b"LASF", ".las"),
)  # fmt: skip


def read_scan(path: str | Path, *, unit: Unit = "m") -> Scan:
    """Read a point cloud: PLY, PCD, plain text (xyz, txt, csv, pts, asc), NPY or NPZ.

    Coordinates are converted to metres and otherwise kept. Points that are not finite are dropped and
    counted in the notes. Sensor poses are taken from ``SCAN.frames.json`` beside the file; their
    positions are in the scan's unit.

    Args:
        path: the file; the extension tells the format, the first bytes do where it is unknown.
        unit: unit of the file's coordinates.

    Raises:
        InputError: the file is missing, unreadable, damaged, of an unsupported format, has too few
            points, or coordinates beyond 1e8 m.
        ConfigError: unknown unit.
    """
    path = Path(path)
    scale = metres_per_unit(unit)
    try:
        reader = _reader_for(path)
        raw = reader(path)
        with open(path, "rb") as file:
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
        sidecar = frames_path(path)
        frames = read_frames_json(sidecar, scale) if sidecar.is_file() else ()
    except OSError as e:
        reason = e.strerror or type(e).__name__
        raise InputError(f"{path.name}: cannot be read: {reason}. Fix: check the file's permissions.") from e
    scan = checked_scan(raw, printable_name(path.name), unit)
    notes = scan.notes + frame_notes(scan, frames)
    return replace(scan, frames=frames, sha256=sha256, notes=notes)


def scan_from_arrays(
    points: ArrayLike,
    colours: ArrayLike | None = None,
    frame_ids: ArrayLike | None = None,
    unit: Unit = "m",
) -> Scan:
    """A `Scan` from NumPy arrays or lists, checked like a file. The arrays are copied.

    Args:
        points: (n, 3) coordinates in `unit`.
        colours: (n, 3) or (n, 4) red, green, blue (alpha ignored), 0 to 255 or 0.0 to 1.0.
        frame_ids: n whole numbers, the frame that saw each point.
        unit: unit of the coordinates.

    Raises:
        InputError: wrong shapes or kinds, too few points, or coordinates beyond 1e8 m.
        ConfigError: unknown unit.
    """
    xyz = _numbers("points", points)
    if xyz.ndim != 2 or xyz.shape[1] != 3:
        raise InputError(
            f"points: got shape {xyz.shape}; (n, 3) is needed. Fix: pass one row x, y, z per point."
        )
    converted = None
    if colours is not None:
        rgb = _numbers("colours", colours)
        if rgb.ndim != 2 or rgb.shape[1] not in (3, 4) or len(rgb) != len(xyz):
            raise InputError(
                f"colours: got shape {rgb.shape}; ({len(xyz)}, 3) is needed. Fix: one row per point."
            )
        converted = colours_to_uint8(rgb[:, :3])
        if converted is None:
            raise InputError(
                f"colours: got values from {rgb.min()} to {rgb.max()}; 0 to 255 or 0.0 to 1.0 is needed. "
                "Fix: scale them."
            )
        converted = converted.copy()
    ids = None
    if frame_ids is not None:
        ids = _numbers("frame_ids", frame_ids)
        if ids.shape != (len(xyz),) or ids.dtype.kind not in "iu":
            raise InputError(
                f"frame_ids: got {ids.dtype} of shape {ids.shape}; {len(xyz)} integers are needed. "
                "Fix: one integer per point."
            )
        ids = ids.astype(np.int64)
    single = xyz.dtype.kind == "f" and xyz.dtype.itemsize <= 4
    return checked_scan(RawCloud(np.array(xyz, dtype=np.float64), converted, ids, single), "array", unit)


def _numbers(name: str, values: ArrayLike) -> np.ndarray:
    try:
        array = np.asarray(values)
    except ValueError as e:
        raise InputError(
            f"{name}: got rows of different length; equal rows are needed. Fix: check the data."
        ) from e
    if array.dtype.kind not in "fiu":
        raise InputError(
            f"{name}: got values of type {array.dtype}; real numbers are needed. Fix: convert them."
        )
    return array


def _reader_for(path: Path) -> Callable[[Path], RawCloud]:
    if not path.exists():
        raise InputError(f"{path.name}: no such file. Fix: check the path {str(path)!r}.")
    if not path.is_file():
        what = "a directory" if path.is_dir() else "no regular file"
        raise InputError(f"{path.name or path}: is {what}; a point cloud file is needed. Fix: name the file.")
    with open(path, "rb") as file:
        head = file.read(4096)
    if not head:
        raise InputError(
            f"{path.name}: the file is empty; a point cloud is needed. Fix: copy or export it again."
        )
    suffix = path.suffix.lower()
    if suffix not in _READERS and suffix not in _CONVERT:
        known = next((ext for magic, ext in _MAGIC if head.startswith(magic)), None)
        suffix = known or (".xyz" if looks_like_text(head) else suffix)
    if suffix in _CONVERT:
        raise InputError(
            f"{path.name}: {suffix[1:]} files cannot be read. Fix: convert it to {_CONVERT[suffix]} "
            "(binary, double precision), for example with CloudCompare."
        )
    if suffix not in _READERS:
        raise InputError(
            f"{path.name}: unknown format; one of {', '.join(ext[1:] for ext in _READERS)} is needed. "
            "Fix: convert the scan to PLY."
        )
    return _READERS[suffix]
