"""Numbers and names as text, safe in the formats that consist of it."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping

import numpy as np

from indoorfit.model import FitResult

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What an XML 1.0 document may not hold, not even escaped (2.2 Characters)."""

_NOT_NAME = re.compile(r"[^A-Za-z0-9_.-]")
_NOT_NAME_NOR_DOT = re.compile(r"[^A-Za-z0-9_-]")

OWN = "indoorfit."
"""How names begin that are not those of rooms and faces."""


def numbers(values: np.ndarray) -> str:
    """Floats with all their digits, separated by spaces; -0.0 as 0.0."""
    return " ".join(repr(value + 0.0) for value in np.asarray(values, dtype=np.float64).ravel().tolist())


def safe_names(ids: Iterable[str], dots: bool = True) -> dict[str, str]:
    """A name of letters, digits and ``_ . -`` for every id (an NCName of XML), all different.

    Ids that are such names already stay as they are; no name begins with `OWN`.

    Args:
        ids: any texts.
        dots: whether a name may hold dots; VRML97's may not.
    """
    ids = list(dict.fromkeys(ids))
    names: dict[str, str] = {}
    taken = {text for text in ids if _is_name(text, dots)}
    for text in ids:
        name = text
        if not _is_name(text, dots):
            stem = name = "_" + (_NOT_NAME if dots else _NOT_NAME_NOR_DOT).sub("_", text)
            k = 1
            while name in taken:
                k += 1
                name = f"{stem}_{k}"
            taken.add(name)
        names[text] = name
    return names


def _is_name(text: str, dots: bool) -> bool:
    plain = re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.-]*", text) and not text.startswith(OWN)
    return bool(plain) and (dots or "." not in text)


def node_names(result: FitResult, dots: bool = True) -> dict[tuple[str, str], str]:
    """Safe names of all rooms and faces, by ``("room" | "face", id)``; none of them twice."""
    rooms = [("room", room.id) for room in result.rooms]
    faces = [("face", face.id) for face in result.faces]
    # A face and a room may share an id; with the kind in front they cannot share a name.
    shared = {room for _, room in rooms} & {face for _, face in faces}
    keys = {key: f"{key[0]} {key[1]}" if key[1] in shared else key[1] for key in (*rooms, *faces)}
    names = safe_names(keys.values(), dots)
    return {key: names[text] for key, text in keys.items()}


def xml_text(text: str) -> str:
    """A text that any XML document may hold: other characters become U+FFFD."""
    return _NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


def element(parent: ET.Element, tag: str, attributes: Mapping[str, object] | None = None, text: str = ""):
    """Add an element; attributes and text may hold anything."""
    child = ET.SubElement(parent, tag, {key: xml_text(str(v)) for key, v in (attributes or {}).items()})
    if text:
        child.text = xml_text(text)
    return child


def xml_bytes(root: ET.Element) -> bytes:
    """The document in UTF-8 with its declaration, indented."""
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
