"""The dimensions as a table of the page."""

import math

from indoorfit.export import quantity_text
from indoorfit.model import FitResult, Quantity, TapeCheck

from .facts import level_text
from .html_table import Cell, Row, html_table
from .table import what_is_measured

_NOTE = (
    '<p class="quiet">Clear lengths between mean wall planes. The columns u are standard uncertainties: '
    "what the residuals of the scan show, a possible error of its scale, and where the wall is (plaster, "
    "skirting). Their squares add up; k times the root is half the interval (JCGM 100). Accuracy is the "
    "USIBD Level of Accuracy that the half width at 95 % belongs to: LOA20 15 to 50 mm, LOA30 5 to 15, "
    "LOA40 1 to 5 mm, LOA50 below 1 mm; LOA10 is worse than 50 mm. An inferred dimension ends at a face "
    "without points.</p>"
)


def dimension_section(result: FitResult) -> str:
    """Heading, table and explanation."""
    several = len(result.rooms) > 1
    checks = {} if result.tape is None else {check.dimension: check for check in result.tape.checks}
    rows = [
        Row(
            (
                Cell(d.id, "id"),
                Cell(what_is_measured(d, several), "what"),
                *number_cells(d.quantity, 3, 4),
                Cell(d.loa or ""),
                Cell(d.status, d.status),
                *(_tape_cells(checks.get(d.id)) if checks else ()),
                *_budget_cells(d.quantity),
            ),
            pick=d.id,
        )
        for d in result.dimensions
    ]
    tape = ("Tape, m", "Model minus tape, mm") if checks else ()
    budget = ("u scan, mm", "u scale, mm", "u definition, mm", "k", "Degrees of freedom")
    head = ("Id", "What", "Value, m", interval_head(result.level, "m"), "Accuracy", "Status", *tape, *budget)
    table = html_table(head, rows, "Dimensions with their intervals", sortable=True)
    return f'<section id="dimensions"><h2>Dimensions</h2>\n{table}\n{_NOTE}</section>'


def interval_head(level: float, unit: str) -> Cell:
    """Title of the column of intervals; copied as two, the ends."""
    text = level_text(level)
    return Cell(f"Interval, {text}", "number", copied=f"Low at {text}, {unit}\tHigh at {text}, {unit}")


def number_cells(quantity: Quantity, min_decimals: int, max_decimals: int) -> tuple[Cell, Cell]:
    """Value and interval; sorted by value and by width."""
    text, interval = quantity_text(quantity, min_decimals, max_decimals), quantity.interval
    ends = "\t".join(f"{end:.{max_decimals + 1}f}" for end in (interval.low, interval.high))
    width = round(interval.high - interval.low, 9)
    return (
        Cell(text.value, "number", sort=round(quantity.value, 9)),
        Cell(text.spread, "number", sort=width, copied=ends),
    )


def _tape_cells(check: TapeCheck | None) -> tuple[Cell, Cell]:
    """Reading and deviation; empty where nothing was measured."""
    if check is None:
        return Cell("", "number"), Cell("", "number")
    return Cell(f"{check.value_m:.4f}", "number"), Cell(f"{1e3 * check.deviation_m:+.1f}", "number")


def _budget_cells(quantity: Quantity) -> tuple[Cell, ...]:
    """Parts of the standard uncertainty in millimetres, coverage factor, degrees of freedom."""
    factor, budget = quantity.coverage_factor, quantity.budget
    k = Cell("" if factor is None else f"{factor:.2f}", "number")
    nothing = Cell("", "number")
    if budget is None:
        return nothing, nothing, nothing, k, nothing
    parts = (budget.data_std, budget.scale_std, budget.definition_std)
    finite = math.isfinite(budget.effective_dof)
    # Beyond ten thousand the quantile is the normal one to all digits that are shown.
    dof = "∞" if not finite else f"{budget.effective_dof:.0f}" if budget.effective_dof < 1e4 else "> 9999"
    last = Cell(dof, "number", sort=budget.effective_dof if finite else 1e300)
    return (*(Cell(_mm_text(1e3 * part), "number") for part in parts), k, last)


def _mm_text(value_mm: float) -> str:
    """Two significant digits, never as a power of ten."""
    return f"{value_mm:.2g}" if value_mm < 99.5 else f"{value_mm:.0f}"
