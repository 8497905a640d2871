"""The header of a PLY file (Turk 1994), read without trusting it."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ..errors import InputError

PlyFormat = Literal["ascii", "binary_little_endian", "binary_big_endian"]
_FORMATS: dict[str, PlyFormat] = {
    "ascii": "ascii",
    "binary_little_endian": "binary_little_endian",
    "binary_big_endian": "binary_big_endian",
}

MAX_HEADER_BYTES = 1 << 20
"""Real headers have some hundred bytes; a megabyte leaves room for long comments."""

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip


@dataclass(frozen=True)
class PlyProperty:
    """One value of an element, or one list of values."""

    name: str
    type: str
    """NumPy code without byte order, e.g. ``f4``; of the items, for a list."""
    count_type: str | None = None
    """Code of a list's length; None for a single value."""


@dataclass(frozen=True)
class PlyElement:
    """A table of the file, e.g. ``vertex``."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...]

    @property
    def has_lists(self) -> bool:
        """Whether rows may differ in length."""
        return any(prop.count_type is not None for prop in self.properties)


@dataclass(frozen=True)
class PlyHeader:
    """What the file promises."""

    format: PlyFormat
    elements: tuple[PlyElement, ...]
    n_bytes: int
    """Offset of the data."""
    n_lines: int
    """Lines of the header, for the line numbers of ascii data."""


def read_ply_header(path: Path) -> PlyHeader:
    """The header, checked for sense but not against the file's size.

    Raises:
        InputError: not a PLY file, no end of the header, or a line in it makes no sense.
    """
    with open(path, "rb") as file:
        head = file.read(MAX_HEADER_BYTES)
    if not re.match(rb"ply[ \t]*[\r\n]", head):
        raise InputError(
            f"{path.name}: does not begin with 'ply'; a PLY file is needed. "
            "Fix: give the file the extension of its real format."
        )
    # Only a file that begins with a bare CR may end its header with one: the next byte is data.
    old_mac = re.match(rb"ply[ \t]*\r(?!\n)", head) is not None
    end_pattern = rb"[\r\n]end_header[ \t]*\r" if old_mac else rb"[\r\n]end_header[ \t]*\r?\n"
    end = re.search(end_pattern, head)
    if end is None:
        raise InputError(
            f"{path.name}: no line 'end_header' in the first {len(head)} bytes; a PLY header needs one. "
            "Fix: the file is cut off or damaged, export the scan again."
        )
    # Only keywords matter to us and they are ascii; latin-1 lets comments be in any encoding.
    text = head[: end.end()].decode("latin-1")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")[:-1]
    return _parse_lines(path.name, lines, end.end())


def _parse_lines(where: str, lines: list[str], n_bytes: int) -> PlyHeader:
    found: PlyFormat | None = None
    elements: list[PlyElement] = []
    for number, line in enumerate(lines, start=1):
        words = line.split()
        at = f"{where}, header line {number}"
        match words:
            case [] | ["ply" | "comment" | "obj_info" | "end_header", *_]:
                continue
            case ["format", name, *_] if name in _FORMATS:
                found = _FORMATS[name]
            case ["element", name, count]:
                elements.append(PlyElement(name, _count(at, count), ()))
            case ["property", *rest] if elements:
                last = elements[-1]
                elements[-1] = PlyElement(
                    last.name, last.count, (*last.properties, _property(at, rest, last))
                )
            case _:
                raise InputError(f"{at}: found {line.strip()[:80]!r}, which is no PLY header line. {_FIX}")
    if found is None:
        raise InputError(
            f"{where}: the PLY header has no format line; {' or '.join(_FORMATS)} is needed. {_FIX}"
        )
    return PlyHeader(found, tuple(elements), n_bytes, len(lines))


_FIX = "Fix: export the scan again."


def _count(at: str, text: str) -> int:
    # ASCII digits only: int() would take '-1', '1_000' and digits of other scripts.
    if not re.fullmatch("[0-9]{1,18}", text):
        raise InputError(f"{at}: found the count {text[:40]!r}; a number >= 0 is needed. {_FIX}")
    return int(text)


def _property(at: str, words: list[str], element: PlyElement) -> PlyProperty:
    match words:
        case ["list", count_type, item_type, name]:
            prop = PlyProperty(name, _type(at, item_type), _type(at, count_type))
            if prop.count_type is not None and prop.count_type[0] == "f":
                raise InputError(
                    f"{at}: a list's length is of type {count_type!r}; an integer is needed. {_FIX}"
                )
        case [type_name, name]:
            prop = PlyProperty(name, _type(at, type_name))
        case _:
            raise InputError(f"{at}: found {' '.join(words)[:80]!r}; a type and a name are needed. {_FIX}")
    if any(other.name == prop.name for other in element.properties):
        raise InputError(f"{at}: the property {prop.name[:40]!r} comes twice. {_FIX}")
    return prop


def _type(at: str, name: str) -> str:
    if name not in _TYPES:
        raise InputError(
            f"{at}: found the unknown type {name[:40]!r}; one of {', '.join(_TYPES)} is needed. {_FIX}"
        )
    return _TYPES[name]
