"""A result together with what a tape says of it."""

from dataclasses import replace

from indoorfit.evaluate import check_tape, tape_notes
from indoorfit.model import FitResult, TapeTable


def held_again(result: FitResult) -> FitResult:
    """The same result with `holds` asked again: its intervals have come to another level."""
    if result.tape is None:
        return result
    ends = {d.id: d.quantity.interval for d in result.dimensions}
    checks = tuple(
        replace(c, holds=ends[c.dimension].low <= c.value_m <= ends[c.dimension].high)
        for c in result.tape.checks
    )
    return replace(result, tape=replace(result.tape, checks=checks))


def with_tape(result: FitResult, table: TapeTable, scan: str | None = None) -> FitResult:
    """The same result with every reading's deviation, E_n and verdict, and warnings where they are due.

    The values and intervals stay as they are: a few readings test them, they cannot calibrate them.

    Args:
        result: as `fit_scan` returns it.
        table: readings, as `io.read_tape` returns them.
        scan: as for `evaluate.check_tape`.
    """
    verdict = check_tape(result, table, scan)
    return replace(result, tape=verdict, notes=(*result.notes, *tape_notes(verdict)))
