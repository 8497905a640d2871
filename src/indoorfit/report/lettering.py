"""The font that pillow carries, and what it lacks."""

import unicodedata
from functools import lru_cache

from PIL import ImageFont

_SUPERSCRIPTS = {"²": "2", "³": "3"}
SUPERSCRIPT_SIZE = 0.62
SUPERSCRIPT_RISE = 0.34
_REPLACEMENTS = str.maketrans({0x2013: "-", 0x2014: "-", 0x2212: "-", 0xD7: "x"})
"""En dash, em dash, minus and multiplication sign."""

_PRESENT = frozenset("±°·…")


@lru_cache(maxsize=64)
def font(pixels: float) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Pillow's own font at a size in pixels: no font file of the machine changes the picture."""
    return ImageFont.load_default(size=pixels)


def runs(text: str) -> tuple[tuple[str, bool], ...]:
    """Split a text into pieces that the font has, each marked as superscript or not."""
    pieces: list[tuple[str, bool]] = []
    for character in text.translate(_REPLACEMENTS):
        raised = character in _SUPERSCRIPTS
        drawn = _SUPERSCRIPTS.get(character) or _drawable(character)
        if pieces and pieces[-1][1] == raised:
            pieces[-1] = (pieces[-1][0] + drawn, raised)
        else:
            pieces.append((drawn, raised))
    return tuple(pieces)


def drawable(text: str) -> str:
    """A text in letters that simple fonts have; superscripts stay as they are."""
    characters = text.translate(_REPLACEMENTS)
    return "".join(c if c in _SUPERSCRIPTS else _drawable(c) for c in characters)


@lru_cache(maxsize=4096)
def text_width(text: str, size: float) -> float:
    """Width of a line of text, in the unit of `size`."""
    # Measured at 100 pixels, where hinting rounds no letter noticeably.
    return sum(
        float(font(100.0).getlength(piece)) / 100.0 * size * (SUPERSCRIPT_SIZE if raised else 1.0)
        for piece, raised in runs(text)
    )


def _drawable(character: str) -> str:
    if " " <= character <= "~" or character in _PRESENT:
        return character
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return plain if plain.isprintable() and plain else "?"
