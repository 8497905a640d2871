"""Pages and tables in HTML, all texts escaped."""

from collections.abc import Iterable, Sequence
from html import escape

from .style import STYLE


def html_page(title: str, body: Iterable[str]) -> str:
    """A whole page that needs nothing else: no scripts, no fonts, no network.

    Args:
        title: plain text.
        body: ready markup.
    """
    head = (
        '<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style>"
    )
    content = "\n".join(body)
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{content}\n</body></html>\n'


def html_table(head: Sequence[str], rows: Iterable[Sequence[tuple[str, str]]]) -> str:
    """A table of (class, text) cells; a head cell above numbers is set to the right like them."""
    rows = list(rows)
    classes = [cell[0] for cell in rows[0]] if rows else [""] * len(head)
    titles = "".join(
        f'<th scope="col"{_class("number" * (kind == "number"))}>{escape(text)}</th>'
        for text, kind in zip(head, classes, strict=True)
    )
    lines = [
        "<tr>" + "".join(f"<td{_class(kind)}>{escape(text)}</td>" for kind, text in row) + "</tr>"
        for row in rows
    ]
    content = "\n".join(lines)
    return (
        f'<div class="wide"><table><thead><tr>{titles}</tr></thead>\n<tbody>{content}</tbody></table></div>'
    )


def _class(kind: str) -> str:
    return f' class="{escape(kind)}"' if kind else ""
