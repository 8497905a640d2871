"""Reading PCD 0.7 of the Point Cloud Library: ascii, binary and binary_compressed."""

import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from ..errors import InputError
from .lzf import MAX_RATIO, lzf_decompress
from .raw import RawCloud, cloud_from_columns
from .table import TableLayout, read_table

MAX_HEADER_BYTES = 1 << 16
"""A header has eleven lines; 64 KiB leave room for comments."""

_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_FIX = "Fix: export the scan again."


@dataclass(frozen=True)
class _Field:
    name: str
    code: str
    """NumPy code, e.g. ``<f4``; PCD is little endian."""
    count: int
    """Values per point; padding often has several."""

    @property
    def n_bytes(self) -> int:
        """Per point."""
        return int(self.code[2:]) * self.count


@dataclass(frozen=True)
class _Header:
    fields: tuple[_Field, ...]
    n_points: int
    data: str
    n_bytes: int
    n_lines: int


def read_pcd(path: Path) -> RawCloud:
    """The points of a PCD file.

    Raises:
        InputError: no PCD file, or fewer bytes than the header promises.
    """
    header = _read_header(path)
    if header.data == "ascii":
        columns = _ascii_columns(path, header)
    elif header.data == "binary":
        columns = _binary_columns(path, header)
    else:
        columns = _compressed_columns(path, header)
    return cloud_from_columns(path.name, _with_unpacked_colours(columns))


def _read_header(path: Path) -> _Header:
    with open(path, "rb") as file:
        head = file.read(MAX_HEADER_BYTES)
    end = re.search(rb"^DATA[ \t]+(\w+)[ \t]*\r?(\n|\Z)", head, re.MULTILINE)
    if end is None:
        raise InputError(
            f"{path.name}: no line 'DATA ...' in the first {len(head)} bytes; a PCD header ends with one. "
            "Fix: the file is cut off or no PCD file, export the scan again."
        )
    entries: dict[str, list[str]] = {}
    lines = head[: end.end()].decode("latin-1").splitlines()
    for line in lines:
        words = line.split()
        if words and not words[0].startswith("#"):
            entries[words[0].upper()] = words[1:]
    data = end.group(1).decode("ascii").lower()
    if data not in ("ascii", "binary", "binary_compressed"):
        raise InputError(
            f"{path.name}: DATA is {data[:40]!r}; ascii, binary or binary_compressed is needed. {_FIX}"
        )
    return _Header(_fields(path.name, entries), _n_points(path.name, entries), data, end.end(), len(lines))


def _fields(where: str, entries: dict[str, list[str]]) -> tuple[_Field, ...]:
    names = entries.get("FIELDS") or entries.get("COLUMNS") or []
    sizes, types = entries.get("SIZE", []), entries.get("TYPE", [])
    counts = entries.get("COUNT", ["1"] * len(names))
    if not names or not len(names) == len(sizes) == len(types) == len(counts):
        raise InputError(
            f"{where}: the PCD header has {len(names)} FIELDS, {len(sizes)} SIZE, {len(types)} TYPE and "
            f"{len(counts)} COUNT; equal numbers above 0 are needed. {_FIX}"
        )
    fields = []
    for name, size, kind, count in zip(names, sizes, types, counts, strict=True):
        n_bytes, n_values = _natural(where, "SIZE", size), _natural(where, "COUNT", count)
        if n_bytes not in _SIZES.get(kind.upper(), ()) or not 1 <= n_values <= 100_000:
            raise InputError(
                f"{where}: the field {name[:40]!r} has TYPE {kind[:8]} SIZE {size} COUNT {count}; F of 4 or "
                f"8, I or U of 1, 2, 4 or 8 bytes, and 1 to 100000 values are needed. {_FIX}"
            )
        fields.append(_Field(name, f"<{kind.lower()}{n_bytes}", n_values))
    return tuple(fields)


def _n_points(where: str, entries: dict[str, list[str]]) -> int:
    def entry(key: str) -> int | None:
        words = entries.get(key)
        return _natural(where, key, words[0]) if words else None

    width, height, points = entry("WIDTH"), entry("HEIGHT"), entry("POINTS")
    product = None if width is None else width * (1 if height is None else height)
    if points is None and product is None:
        raise InputError(f"{where}: the PCD header has neither POINTS nor WIDTH. {_FIX}")
    if points is not None and product is not None and points != product:
        raise InputError(
            f"{where}: the PCD header has POINTS {points} but WIDTH x HEIGHT {product}; "
            f"equal numbers are needed. {_FIX}"
        )
    return points if points is not None else product or 0


def _natural(where: str, key: str, text: str) -> int:
    if not re.fullmatch("[0-9]{1,15}", text):
        raise InputError(f"{where}: {key} is {text[:40]!r}; a number >= 0 is needed. {_FIX}")
    return int(text)


def _promised(where: str, header: _Header, held: int) -> NoReturn:
    raise InputError(
        f"{where}: the header promises {header.n_points} points, the file holds {held}; it is cut off or "
        "its header is wrong. Fix: copy or export the scan again."
    )


def _ascii_columns(path: Path, header: _Header) -> dict[str, np.ndarray]:
    n_columns = sum(field.count for field in header.fields)
    layout = TableLayout(n_columns, skip_lines=header.n_lines, max_rows=header.n_points)
    table = read_table(path, layout)
    if len(table) < header.n_points:
        _promised(path.name, header, len(table))
    columns, at = {}, 0
    for field in header.fields:
        column = table[:, at]
        at += field.count
        # An integer type tells a colour of 1 of 255 from a colour of 1.0; NaN stays a float.
        integral = field.code[1] in "iu" and bool(np.all(np.abs(column) < 2.0**53))
        columns[field.name] = np.rint(column).astype(np.int64) if integral else column
    return columns


def _binary_columns(path: Path, header: _Header) -> dict[str, np.ndarray]:
    stride = sum(field.n_bytes for field in header.fields)
    n_bytes = path.stat().st_size - header.n_bytes
    if n_bytes < header.n_points * stride:
        _promised(path.name, header, max(0, n_bytes) // stride)
    if header.n_points == 0:
        return {field.name: np.empty(0) for field in header.fields}
    # Named by position, for padding fields all share the name '_'.
    row_type = np.dtype([(f"f{i}", f.code, (f.count,)) for i, f in enumerate(header.fields)])
    rows = np.memmap(path, dtype=row_type, mode="r", offset=header.n_bytes, shape=(header.n_points,))
    return {field.name: rows[f"f{i}"][:, 0] for i, field in enumerate(header.fields)}


def _compressed_columns(path: Path, header: _Header) -> dict[str, np.ndarray]:
    with open(path, "rb") as file:
        file.seek(header.n_bytes)
        sizes = file.read(8)
        if len(sizes) < 8:
            _promised(path.name, header, 0)
        n_packed, n_out = struct.unpack("<II", sizes)
        packed = file.read(n_packed)
    if len(packed) < n_packed:
        raise InputError(
            f"{path.name}: the header promises {n_packed} compressed bytes ({header.n_points} points), the "
            f"file holds {len(packed)}; it is cut off. Fix: copy or export the scan again."
        )
    stored = header.fields
    if n_out != header.n_points * sum(field.n_bytes for field in stored):
        # PCL leaves the padding out when it compresses.
        stored = tuple(field for field in stored if field.name != "_")
    stride = sum(field.n_bytes for field in stored)
    if n_out != header.n_points * stride or n_out > MAX_RATIO * n_packed:
        _promised(path.name, header, n_out // stride if stride and n_out <= MAX_RATIO * n_packed else 0)
    block = lzf_decompress(path.name, packed, n_out)
    columns, at = {}, 0
    for field in stored:
        # Compressed data goes field by field, not point by point.
        values = np.frombuffer(block, dtype=field.code, count=header.n_points * field.count, offset=at)
        columns[field.name] = values[:: field.count]
        at += field.n_bytes * header.n_points
    return columns


def _with_unpacked_colours(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """A packed rgb or rgba column (0xAARRGGBB) as red, green and blue."""
    by_name = {name.lower(): column for name, column in columns.items()}
    packed = by_name.get("rgb", by_name.get("rgba"))
    if packed is None:
        return columns
    bits = _packed_bits(packed)
    channels = {name: (bits >> shift & 255).astype(np.uint8) for name, shift in _SHIFTS}
    return {**columns, **channels}


_SHIFTS = (("red", 16), ("green", 8), ("blue", 0))


def _packed_bits(packed: np.ndarray) -> np.ndarray:
    if packed.dtype.kind in "iu":
        return packed.astype(np.int64)
    # A colour seen as a float is below 1e-37, or huge and negative where alpha is set; so whole
    # numbers within 32 bits were printed as integers under TYPE F, as PCL's ascii writer does.
    whole = packed.dtype.itemsize == 8 and bool(
        np.all((packed >= 0) & (packed < 2.0**32) & (packed == np.rint(packed)))
    )
    if whole and bool(np.any(packed >= 1)):
        return packed.astype(np.int64)
    with np.errstate(over="ignore", invalid="ignore"):
        return np.ascontiguousarray(packed, dtype=np.float32).view(np.uint32)
