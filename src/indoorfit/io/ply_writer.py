"""Writing PLY: one form only, the one that loses nothing."""

from pathlib import Path

import numpy as np

from indoorfit.files import atomic_file

from ..errors import OutputError
from ..model import Scan


def write_ply(path: str | Path, scan: Scan, *, comment: str | None = None, overwrite: bool = True) -> None:
    """Write a scan as binary little endian PLY: double coordinates, uchar colours, int frame.

    The same scan gives the same bytes. Sensor poses go to a sidecar, see `write_frames_json`.

    Args:
        path: target file.
        scan: metres, written as they are.
        comment: text for the header; other than ascii is escaped, for readers expect ascii.
        overwrite: whether an existing file may be replaced.

    Raises:
        OutputError: the file cannot be written, or a frame id does not fit 32 bits.
    """
    fields = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")]
    if scan.colours is not None:
        fields += [("red", "u1"), ("green", "u1"), ("blue", "u1")]
    if scan.frame_ids is not None:
        fields.append(("frame", "<i4"))
    rows = np.empty(scan.n_points, dtype=fields)
    for axis, name in enumerate("xyz"):
        rows[name] = scan.points_m[:, axis]
    if scan.colours is not None:
        for channel, name in enumerate(("red", "green", "blue")):
            rows[name] = scan.colours[:, channel]
    if scan.frame_ids is not None:
        limits = np.iinfo(np.int32)
        if scan.n_points and (scan.frame_ids.min() < limits.min or scan.frame_ids.max() > limits.max):
            raise OutputError(
                f"{Path(path).name}: the scan has frame ids beyond 32 bits, which PLY's int cannot hold. "
                "Fix: number the frames from 0."
            )
        rows["frame"] = scan.frame_ids
    with atomic_file(path, overwrite=overwrite) as file:
        file.write(_header(scan.n_points, fields, comment))
        file.write(rows.data)


_TYPE_NAMES = {"<f8": "double", "u1": "uchar", "<i4": "int"}


def _header(n_points: int, fields: list[tuple[str, str]], comment: str | None) -> bytes:
    lines = ["ply", "format binary_little_endian 1.0"]
    lines += [f"comment {line}".rstrip() for line in (comment or "").splitlines()]
    lines.append(f"element vertex {n_points}")
    lines += [f"property {_TYPE_NAMES[code]} {name}" for name, code in fields]
    lines.append("end_header")
    return ("\n".join(lines) + "\n").encode("ascii", errors="backslashreplace")
