"""The display list as SVG."""

from xml.sax.saxutils import escape, quoteattr

import numpy as np
from jaxtyping import Float

from .display import CAP_HEIGHT, Dots, Item, Label, Picture, Region, Stroke
from .lettering import text_width

_FONTS = "Aileron, Helvetica, Arial, 'Liberation Sans', sans-serif"


def to_svg(picture: Picture, unit_mm: float | None = None) -> str:
    """The picture as one SVG element, fit for a file of its own or inside a page.

    Texts are escaped and control characters dropped, so no name can add an element.

    Args:
        picture: what to draw.
        unit_mm: length of a page unit on paper; without it the size is in pixels of the screen.
    """
    size = f'width="{picture.width:.0f}" height="{picture.height:.0f}"'
    view = f'viewBox="0 0 {picture.width:.0f} {picture.height:.0f}"'
    if unit_mm is not None:
        size = f'width="{picture.width * unit_mm:.3f}mm" height="{picture.height * unit_mm:.3f}mm"'
        view = f'viewBox="0 0 {picture.width:.4f} {picture.height:.4f}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {view} role="img" font-family={quoteattr(_FONTS)}>',
        f"<title>{_text(picture.title)}</title>",
        f"<desc>{_text(picture.description)}</desc>",
        f'<rect width="100%" height="100%" fill="{picture.background}"/>',
        *(_element(item) for item in picture.items),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _element(item: Item) -> str:
    match item:
        case Region():
            path = "".join(f"M{_points(ring)}Z" for ring in item.rings)
            outline = f' stroke="{item.stroke}" stroke-width="{item.width:g}"' if item.stroke else ""
            fill = f'fill="{item.fill or "none"}" fill-rule="evenodd"'
            return f'<path d="{path}" {fill}{outline}{_shows(item.shows)}/>'
        case Stroke():
            dash = f' stroke-dasharray="{item.dash[0]:g} {item.dash[1]:g}"' if item.dash else ""
            ink = f'stroke="{item.colour}" stroke-width="{item.width:g}"{dash}'
            return f'<path d="M{_points(item.points)}" fill="none" {ink}{_shows(item.shows)}/>'
        case Dots():
            return _dots(item)
        case Label():
            return _label(item)


def _dots(dots: Dots) -> str:
    # One path of zero-length strokes with round caps: a tenth of the bytes of as many circles.
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in dots.centres.tolist())
    ink = f'stroke="{dots.colour}" stroke-width="{dots.diameter:g}" stroke-linecap="round"'
    return f'<path d="{path}" fill="none" {ink}/>'


def _label(label: Label) -> str:
    drop = 0.5 * CAP_HEIGHT * label.size
    x, y = label.at
    place = f'x="{x:.2f}" y="{y + drop:.2f}"'
    if label.upright:
        place = f'x="0" y="{drop:.2f}" transform="translate({x:.2f} {y:.2f}) rotate(-90)"'
    halo = ""
    if label.halo:
        halo = f' stroke="{label.halo}" stroke-width="{0.28 * label.size:.2f}" paint-order="stroke"'
        halo += ' stroke-linejoin="round"'
    # The layout counts on the width, whatever font the viewer has.
    width = f'textLength="{text_width(label.text, label.size):.2f}" lengthAdjust="spacingAndGlyphs"'
    look = f'font-size="{label.size:g}" fill="{label.colour}" text-anchor="{label.anchor}" {width}{halo}'
    return f'<text {place} {look} xml:space="preserve"{_shows(label.shows)}>{_text(label.text)}</text>'


def _shows(ids: tuple[str, ...]) -> str:
    return f" data-shows={quoteattr(' '.join(ids))}" if ids else ""


def _points(points: Float[np.ndarray, "points 2"]) -> str:
    return "L".join(f"{x:.2f} {y:.2f}" for x, y in points.tolist())


def _text(text: str) -> str:
    return escape("".join(c if c.isprintable() else " " for c in text))
