"""From a file or from arrays to a checked `Scan` in metres."""

import hashlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from ..errors import InputError
from ..model import Note, Scan, SensorFrame
from .arrays import read_npy, read_npz
from .frames import frames_path, read_frames_json
from .pcd import read_pcd
from .ply import read_ply
from .raw import RawCloud, colours_to_uint8
from .text import looks_like_text, read_text
from .units import Unit, implausible_unit_note, metres_per_unit

MIN_POINTS = 9
"""A box has nine unknowns (rotation and six planes); each point settles at most one."""

MAX_COORDINATE_M = 1e8
"""National grids (with zone numbers) and geocentric coordinates stay below 4e7 m, so more is a wrong
unit or damage. Up to here float64 steps by at most 1.5e-8 m: digits enough for a tenth of a millimetre
after the centroid is taken off; at 1e9 m and beyond the margin for the arithmetic is gone."""

MAX_FAR_SHARE = 0.01
"""So many points beyond `MAX_COORDINATE_M` are dropped as a sensor's errors; more are a wrong unit."""

COARSE_STEP_M = 1e-4
"""Steps of 32-bit coordinates above this are worth a note: a tenth of a millimetre."""

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
    scan = _checked(raw, path.name, unit)
    notes = scan.notes + _frame_notes(scan, frames)
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
    return _checked(RawCloud(np.array(xyz, dtype=np.float64), converted, ids, single), "array", unit)


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


def _checked(raw: RawCloud, name: str, unit: Unit) -> Scan:
    """Metres, without the points that are no points, and with the notes about them."""
    if unit != "m":
        np.multiply(raw.points, metres_per_unit(unit), out=raw.points)
    raw = _without_invalid(raw, name, unit)
    n_points = len(raw.points)
    if n_points < MIN_POINTS:
        dropped = " ".join(note.message for note in raw.notes if note.code == "POINTS_DROPPED")
        raise InputError(
            f"{name}: found {n_points} points; at least {MIN_POINTS} are needed for a box, and thousands "
            f"for a room. {dropped}{' ' if dropped else ''}Fix: check that the file holds the scan's points."
        )
    notes = list(raw.notes)
    if raw.colours is None:
        notes.append(Note("COLOURS_MISSING", f"{name} has no colours; surfaces will be grey."))
    if raw.single_precision:
        notes.extend(_coarse_notes(raw.points / metres_per_unit(unit), name, unit))
    implausible = implausible_unit_note(raw.points, unit)
    if implausible is not None:
        notes.append(implausible)
    return Scan(raw.points, raw.colours, raw.frame_ids, name=name, notes=tuple(notes))


def _without_invalid(raw: RawCloud, name: str, unit: Unit) -> RawCloud:
    points_m = raw.points
    # One NaN or infinity makes the sum one: the common case costs one pass and no mask.
    with np.errstate(over="ignore", invalid="ignore"):
        if len(points_m) == 0 or (np.isfinite(points_m.sum()) and np.abs(points_m).max() <= MAX_COORDINATE_M):
            return raw
    finite = np.isfinite(points_m).all(axis=1)
    n_finite = int(finite.sum())
    if n_finite == 0:
        raise InputError(
            f"{name}: none of the {len(points_m)} points has finite coordinates (all are NaN or infinite). "
            "Fix: export the scan again."
        )
    with np.errstate(invalid="ignore"):
        # A NaN compares as false, an infinity is beyond: what is near is also finite.
        kept = np.all(np.abs(points_m) <= MAX_COORDINATE_M, axis=1)
    n_far = n_finite - int(kept.sum())
    if n_far > MAX_FAR_SHARE * n_finite:
        largest_m = np.abs(points_m[finite]).max()
        raise InputError(
            f"{name}: {n_far} of {n_finite} points have coordinates beyond {MAX_COORDINATE_M:g} m (largest "
            f"{largest_m:.3g} m, read as {unit}); no map reaches so far. Fix: give the file's unit with "
            f"--unit ({', '.join(get_args(Unit))}), or subtract an offset."
        )
    return _keep(raw, np.asarray(kept), len(points_m) - n_finite, n_far)


def _keep(raw: RawCloud, kept: Bool[np.ndarray, " points"], n_bad: int, n_far: int) -> RawCloud:
    far = f" and {n_far} beyond {MAX_COORDINATE_M:g} m" if n_far else ""
    text = f"Dropped {n_bad} of {len(kept)} points with NaN or infinite coordinates{far}."
    return replace(
        raw,
        points=raw.points[kept],
        colours=None if raw.colours is None else raw.colours[kept],
        frame_ids=None if raw.frame_ids is None else raw.frame_ids[kept],
        notes=(*raw.notes, Note("POINTS_DROPPED", text)),
    )


def _coarse_notes(points: Float[np.ndarray, "points 3"], name: str, unit: Unit) -> list[Note]:
    """A note if 32-bit coordinates (file units) are so far out that they have lost digits."""
    largest = np.abs(points).max()
    step_m = float(np.spacing(np.float32(largest))) * metres_per_unit(unit)
    if step_m <= COARSE_STEP_M:
        return []
    text = (
        f"{name} stores coordinates up to {largest:.6g} {unit} as 32-bit floats, which there lie "
        f"{step_m * 1000:.2g} mm apart: digits are lost. Export as double, or subtract an offset before the export."
    )
    return [Note("COORDINATES_COARSE", text)]


def _frame_notes(scan: Scan, frames: tuple[SensorFrame, ...]) -> tuple[Note, ...]:
    if scan.frame_ids is None or not frames:
        return ()
    unknown = np.setdiff1d(scan.frame_ids, [frame.id for frame in frames])
    if len(unknown) == 0:
        return ()
    n_points = int(np.isin(scan.frame_ids, unknown).sum())
    text = (
        f"{n_points} points are of {len(unknown)} frames without a pose in the sidecar (first: {unknown[0]})."
    )
    return (Note("FRAMES_UNKNOWN", text),)
