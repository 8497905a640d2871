"""Whole pages in HTML."""

from collections.abc import Iterable
from html import escape

from .style import STYLE


def html_page(title: str, body: Iterable[str], policy: str | None = None, scripts: str = "") -> str:
    """A whole page that needs nothing else: no fonts, no network.

    Args:
        title: plain text.
        body: ready markup; empty parts are left out.
        policy: a content security policy, where there are scripts.
        scripts: ready markup, at the end of the page.
    """
    guard = f'<meta http-equiv="Content-Security-Policy" content="{escape(policy)}">' if policy else ""
    head = (
        f'<meta charset="utf-8">{guard}<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style>"
    )
    content = "\n".join(part for part in body if part)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n<main>{content}</main>\n'
        f"{scripts}</body></html>\n"
    )
