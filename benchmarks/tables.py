"""Plain tables, and what the machine was doing meanwhile."""

import os
import platform
from collections.abc import Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns as wide as their longest cell, numbers set to the right."""
    whole = [list(head), *[list(row) for row in rows]]
    widths = [max(len(row[k]) for row in whole) for k in range(len(head))]
    lines = []
    for number, row in enumerate(whole):
        cells = [
            cell.rjust(width) if _is_number(cell) else cell.ljust(width)
            for cell, width in zip(row, widths, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
        if number == 0:
            lines.append("  ".join("-" * width for width in widths))
    return "\n".join(lines)


def machine() -> str:
    """One line: processors, and the load average, without which no time means anything."""
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
    return (
        f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}, load {load}"
    )


def _is_number(cell: str) -> bool:
    return bool(cell) and (cell[0].isdigit() or (cell[0] in "-+" and cell[1:2].isdigit()))
