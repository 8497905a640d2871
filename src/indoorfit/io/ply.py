"""Reading PLY: ascii and both binary byte orders, any extra properties and elements."""

from pathlib import Path
from typing import NoReturn

import numpy as np
from jaxtyping import Int

from ..errors import InputError
from .ply_header import PlyElement, PlyHeader, read_ply_header
from .raw import RawCloud, cloud_from_columns
from .table import TableLayout, count_rows, open_text, read_table


def read_ply(path: Path) -> RawCloud:
    """The vertices of a PLY file; faces and other elements are skipped.

    Raises:
        InputError: no PLY file, no vertices, or fewer bytes than the header promises.
    """
    header = read_ply_header(path)
    names = [element.name for element in header.elements]
    if names.count("vertex") != 1:
        raise InputError(
            f"{path.name}: the PLY header has {names.count('vertex')} elements 'vertex' "
            f"(found: {', '.join(names) or 'none'}); one is needed. Fix: export the scan as points."
        )
    columns = _ascii_columns(path, header) if header.format == "ascii" else _binary_columns(path, header)
    return cloud_from_columns(path.name, columns)


def _promised(where: str, element: PlyElement, held: int, n_bytes: int) -> NoReturn:
    raise InputError(
        f"{where}: the header promises {element.count} rows of '{element.name}', "
        f"the file holds {held} ({n_bytes} bytes of data); it is cut off or its header is wrong. "
        "Fix: copy or export the scan again."
    )


def _ascii_columns(path: Path, header: PlyHeader) -> dict[str, np.ndarray]:
    before, vertex = _split_at_vertex(header)
    skipped = header.n_lines + sum(element.count for element in before)
    layout = TableLayout(columns=len(vertex.properties), skip_lines=skipped, max_rows=vertex.count)
    n_bytes = path.stat().st_size - header.n_bytes
    # loadtxt may allocate by max_rows. A value takes two bytes, so this bounds what can be true.
    if vertex.count * 2 * max(1, layout.columns) > n_bytes + 1 or skipped > header.n_lines + n_bytes:
        held = count_rows(path, TableLayout(columns=1, skip_lines=min(skipped, 1 << 40)))
        _promised(path.name, vertex, held, n_bytes)
    if vertex.has_lists:
        rows = _ascii_rows_with_lists(path, vertex, layout)
    else:
        rows = read_table(path, layout)
    if len(rows) < vertex.count:
        _promised(path.name, vertex, len(rows), n_bytes)
    columns = {}
    for index, prop in enumerate(p for p in vertex.properties if p.count_type is None):
        column = rows[:, index]
        # An integer type tells a colour of 1 of 255 from a colour of 1.0.
        integral = prop.type[0] in "iu" and bool(np.all(np.abs(column) < 2.0**53))
        columns[prop.name] = np.rint(column).astype(np.int64) if integral else column
    return columns


def _ascii_rows_with_lists(path: Path, vertex: PlyElement, layout: TableLayout) -> np.ndarray:
    """Single values of each row, the lists left out. Rare, so a plain loop serves."""
    rows: list[list[float]] = []
    with open_text(path) as file:
        for number, line in enumerate(file, start=1):
            words = line.split()
            if number <= layout.skip_lines or not words:
                continue
            if len(rows) == vertex.count:
                break
            try:
                rows.append(_values_without_lists(vertex, words))
            except (ValueError, IndexError) as e:
                raise InputError(
                    f"{path.name}, line {number} (row {len(rows) + 1} of {vertex.count}): "
                    f"found {line.strip()[:60]!r}, which does not fit the header. Fix: export the scan again."
                ) from e
    n_singles = sum(prop.count_type is None for prop in vertex.properties)
    return np.array(rows, dtype=np.float64).reshape(len(rows), n_singles)


def _values_without_lists(vertex: PlyElement, words: list[str]) -> list[float]:
    values, at = [], 0
    for prop in vertex.properties:
        if prop.count_type is None:
            values.append(float(words[at]))
            at += 1
        else:
            length = int(words[at])
            if length < 0:
                raise ValueError("a list of negative length")
            at += 1 + length
    if at != len(words):
        raise ValueError("more or fewer values than the header names")
    return values


def _binary_columns(path: Path, header: PlyHeader) -> dict[str, np.ndarray]:
    order = "<" if header.format == "binary_little_endian" else ">"
    before, vertex = _split_at_vertex(header)
    n_bytes = path.stat().st_size - header.n_bytes
    if n_bytes <= 0:
        if vertex.count > 0:
            _promised(path.name, vertex, 0, n_bytes)
        return {prop.name: np.empty(0) for prop in vertex.properties}
    data = np.memmap(path, dtype=np.uint8, mode="r", offset=header.n_bytes)
    at = 0
    for element in before:
        _, at = _read_element(path.name, data, at, element, order)
    columns, at = _read_element(path.name, data, at, vertex, order)
    for element in header.elements[len(before) + 1 :]:
        # What follows is not read, but a file that lacks it was cut off and should not pass unseen.
        least = element.count * sum(_size(p.count_type or p.type) for p in element.properties)
        if least > n_bytes - at:
            per_row = least // element.count
            _promised(path.name, element, (n_bytes - at) // per_row, n_bytes)
        at += least
    return columns


def _split_at_vertex(header: PlyHeader) -> tuple[tuple[PlyElement, ...], PlyElement]:
    index = [element.name for element in header.elements].index("vertex")
    return header.elements[:index], header.elements[index]


def _size(code: str) -> int:
    return int(code[1:])


def _read_element(
    where: str, data: np.ndarray, at: int, element: PlyElement, order: str
) -> tuple[dict[str, np.ndarray], int]:
    """Columns of the element's single values, and the offset behind its last row."""
    if not element.properties:
        return {}, at
    lengths = _first_row_lengths(data, at, element, order)
    row_type, list_names = _row_type(element, lengths, order)
    held = (len(data) - at) // row_type.itemsize
    if held < element.count and not element.has_lists:
        _promised(where, element, held, len(data))
    if held >= element.count:
        end = at + element.count * row_type.itemsize
        rows = data[at:end].view(row_type)
        # If every row gives the length of the first, the rows are what the first one looks like.
        if all(np.all(rows[name] == lengths[i]) for i, name in enumerate(list_names)):
            singles = (p.name for p in element.properties if p.count_type is None)
            return {name: rows[name] for name in singles}, end
    return _walk_element(where, data, at, element, order)


def _first_row_lengths(data: np.ndarray, at: int, element: PlyElement, order: str) -> list[int]:
    lengths: list[int] = []
    for prop in element.properties:
        if prop.count_type is None:
            at += _size(prop.type)
            continue
        count = data[at : at + _size(prop.count_type)]
        whole = len(count) == _size(prop.count_type)
        length = int(count.view(order + prop.count_type)[0]) if whole else 0
        # A hostile length only has to fail the comparison below, so it need not be kept.
        lengths.append(length if 0 <= length * _size(prop.type) <= len(data) else 0)
        at += _size(prop.count_type) + lengths[-1] * _size(prop.type)
    return lengths


def _row_type(element: PlyElement, lengths: list[int], order: str) -> tuple[np.dtype, list[str]]:
    """Row layout if every list is as long as in the first row, and the names of the length fields."""
    fields: list[tuple] = []
    names: list[str] = []
    for prop in element.properties:
        if prop.count_type is None:
            fields.append((prop.name, order + prop.type))
        else:
            # A blank cannot occur in a property's name, so these cannot clash with one.
            names.append(f"{prop.name} length")
            fields.append((names[-1], order + prop.count_type))
            fields.append((f"{prop.name} items", f"V{lengths[len(names) - 1] * _size(prop.type)}"))
    # NumPy rejects a void of size 0 in some versions; an empty list has no items to skip anyway.
    return np.dtype([field for field in fields if field[1] != "V0"]), names


def _walk_element(
    where: str, data: np.ndarray, at: int, element: PlyElement, order: str
) -> tuple[dict[str, np.ndarray], int]:
    """The same for lists of varying length: row by row for the offsets, then columns at once."""
    least = sum(_size(p.count_type or p.type) for p in element.properties)
    if element.count * least > len(data) - at:
        _promised(where, element, (len(data) - at) // least, len(data))
    byte_order = "little" if order == "<" else "big"
    offsets: dict[str, Int[np.ndarray, " rows"]] = {
        p.name: np.empty(element.count, dtype=np.int64) for p in element.properties if p.count_type is None
    }
    for row in range(element.count):
        for prop in element.properties:
            if prop.count_type is None:
                offsets[prop.name][row] = at
                at += _size(prop.type)
                continue
            count = data[at : at + _size(prop.count_type)].tobytes()
            length = int.from_bytes(count, byte_order, signed=prop.count_type[0] == "i")
            at += _size(prop.count_type) + length * _size(prop.type)
            if length < 0 or at > len(data):
                _promised(where, element, row, len(data))
        if at > len(data):
            _promised(where, element, row, len(data))
    columns = {}
    for prop in element.properties:
        if prop.count_type is None:
            size = _size(prop.type)
            bytes_of = data[offsets[prop.name][:, None] + np.arange(size)]
            columns[prop.name] = np.ascontiguousarray(bytes_of).view(order + prop.type)[:, 0]
    return columns, at
