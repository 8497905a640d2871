"""Tables of the page: cells that a reader sees, and beside them what to sort by and what to copy."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any


@dataclass(frozen=True)
class Cell:
    """One cell; all texts are escaped."""

    text: str
    look: str = ""
    """Its class: ``id``, ``number``, ``what``, ``inferred`` or nothing."""
    sort: float | None = None
    """What the page sorts by; None sorts by the text."""
    copied: str | None = None
    """What is copied in its place; a tab makes two cells of it."""

    def html(self, tag: str = "td") -> str:
        """The cell as an element."""
        attributes = {
            "scope": "col" if tag == "th" else None,
            "class": self.look or None,
            "data-sort": None if self.sort is None else repr(self.sort),
            "data-copy": self.copied,
        }
        said = "".join(f' {key}="{escape(text)}"' for key, text in attributes.items() if text is not None)
        return f"<{tag}{said}>{escape(self.text)}</{tag}>"


@dataclass(frozen=True)
class Row:
    """Cells, and the id that the row stands for where it can be pointed out in plan and 3D view."""

    cells: tuple[Cell, ...]
    pick: str | None = None


def html_table(head: Sequence[Cell | str], rows: Iterable[Row], caption: str, sortable: bool = False) -> str:
    """A table that scrolls by itself where the page is narrow.

    Args:
        head: a title per column; a plain one above numbers is set to the right like them.
        rows: each with as many cells.
        caption: what the table shows, for those who listen to the page.
        sortable: with tools to sort and copy it.
    """
    rows = tuple(rows)
    looks = [cell.look for cell in rows[0].cells] if rows else [""] * len(head)
    titles = "".join(
        (Cell(title, "number" * (look == "number")) if isinstance(title, str) else title).html("th")
        for title, look in zip(head, looks, strict=True)
    )
    lines = []
    for row in rows:
        assert len(row.cells) == len(head), "a cell per column"
        pick = "" if row.pick is None else f' data-pick="{escape(row.pick)}"'
        lines.append(f"<tr{pick}>{''.join(cell.html() for cell in row.cells)}</tr>")
    content = "\n".join(lines)
    look = ' class="sortable"' if sortable else ""
    return (
        f'<div class="wide" tabindex="0" role="region" aria-label="{escape(caption)}"><table{look}>'
        f'<caption class="unseen">{escape(caption)}</caption>'
        f"<thead><tr>{titles}</tr></thead>\n<tbody>{content}</tbody></table></div>"
    )


def pairs(values: Mapping[str, Any], prefix: str = "") -> list[Row]:
    """Nested settings as dotted names, so that a long configuration stays readable."""
    rows = []
    for key, value in values.items():
        if isinstance(value, Mapping) and value:
            rows += pairs(value, f"{prefix}{key}.")
        else:
            text = value if isinstance(value, str) else json.dumps(value, default=str)
            rows.append(Row((Cell(f"{prefix}{key}"), Cell(text))))
    return rows
