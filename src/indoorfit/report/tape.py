"""The comparison with a tape, for page and terminal."""

from html import escape
from statistics import NormalDist

from indoorfit.export import quantity_text
from indoorfit.model import Dimension, FitResult, TapeCheck, TapeVerdict

from .facts import level_text
from .html_table import Cell, Row, html_table


def tape_spread_m(check: TapeCheck) -> float:
    """Expanded uncertainty of the combined reading at 95 %, metres."""
    return NormalDist().inv_cdf(0.975) * check.std_m


def tape_summary(tape: TapeVerdict) -> str:
    """The comparison with a tape in one sentence."""
    n = len(tape.checks)
    if not n:
        return f"No row of {tape.source} is a length of this model."
    agree, held = sum(check.e_n <= 1.0 for check in tape.checks), sum(check.holds for check in tape.checks)
    lengths = "1 length was" if n == 1 else f"{n} lengths were"
    return (
        f"{lengths} measured ({tape.source}): {agree} agree with the tape (E_n up to 1), {held} of the "
        f"model's intervals hold the reading; chi² {tape.chi2:.1f} with {n} degree(s) of freedom, "
        f"probability {tape.p_value:.2g}."
    )


def tape_table(tape: TapeVerdict) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Head and rows of the table for the terminal."""
    head = ("id", "value of the tape m", "± at 95 %", "model - tape mm", "E_n", "interval holds it")
    rows = [
        (
            check.dimension,
            f"{check.value_m:.4f}",
            f"{tape_spread_m(check):.4f}",
            f"{1e3 * check.deviation_m:+.1f}",
            f"{check.e_n:.2f}",
            "yes" if check.holds else "no",
        )
        for check in tape.checks
    ]
    return head, rows


def tape_section(result: FitResult) -> list[str]:
    """The lengths against a tape, where there was one."""
    if result.tape is None:
        return []
    tape = result.tape
    known = {d.id: d for d in result.dimensions}
    rows = [
        Row(
            (
                Cell(check.dimension, "id"),
                *_value_cells(known[check.dimension]),
                Cell(f"{check.value_m:.4f} ± {tape_spread_m(check):.4f}", "number", sort=check.value_m),
                Cell(f"{1e3 * check.deviation_m:+.1f}", "number"),
                Cell(f"{check.e_n:.2f}", "number"),
                Cell("yes" if check.holds else "no", "" if check.holds else "inferred"),
            ),
            pick=check.dimension,
        )
        for check in tape.checks
    ]
    head = (
        "Id", "Value, m", f"Interval, {level_text(result.level)}", "Tape, m (95 %)", "Model minus tape, mm",
        "E_n", "Interval holds it",
    )  # fmt: skip
    parts = [
        '<section id="tape"><h2>Against the tape</h2>',
        f"<p>{escape(tape_summary(tape))}</p>",
        html_table(head, rows, "Lengths against the tape", sortable=True) if rows else "",
        '<p class="quiet">E_n = |model minus tape| / √(U² + U_tape²), both at 95 %: up to 1 the two agree. '
        "The last column asks whether the model's interval alone holds the reading.</p>",
    ]
    refused = "".join(f"<li>line {row.line} {escape(row.reason)}</li>" for row in tape.refused)
    return [*parts, f"<p>Rows that were not used:</p><ul>{refused}</ul>" if refused else "", "</section>"]


def _value_cells(dimension: Dimension) -> tuple[Cell, Cell]:
    text = quantity_text(dimension.quantity)
    return Cell(text.value, "number"), Cell(text.spread, "number")
