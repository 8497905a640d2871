"""The dimension table for spreadsheets."""

import csv
import io
import math
from pathlib import Path

from indoorfit.files import replace_file
from indoorfit.model import Dimension, FitResult, TapeCheck

_COLUMNS = (
    "id", "kind", "room", "wall", "face_from", "face_to", "value_m", "std_m", "level", "low_m", "high_m",
    "status", "from_x_m", "from_y_m", "from_z_m", "to_x_m", "to_y_m", "to_z_m", "data_std_m", "scale_std_m",
    "definition_std_m", "coverage_factor", "effective_dof", "loa",
)  # fmt: skip
_TAPE_COLUMNS = ("tape_m", "tape_std_m", "deviation_m", "e_n", "holds")


def write_dimensions_csv(path: Path, result: FitResult) -> None:
    """Write every dimension as one row: UTF-8, RFC 4180, metres, points in the scan frame.

    Numbers are rounded to a nanometre, which is below every uncertainty and keeps the last bits of
    the arithmetic out of the file. A number that is not known is left empty.
    Where the model was compared with a tape, its columns follow.

    Raises:
        OutputError: the file cannot be written.
    """
    text = io.StringIO(newline="")
    rows = csv.writer(text, lineterminator="\r\n")
    tape = {} if result.tape is None else {check.dimension: check for check in result.tape.checks}
    rows.writerow(_COLUMNS if result.tape is None else (*_COLUMNS, *_TAPE_COLUMNS))
    for d in result.dimensions:
        interval = d.quantity.interval
        numbers = (d.quantity.value, d.quantity.std)
        names = (d.id, d.kind, d.room, d.wall or "", *d.faces)
        points = (*d.from_m.tolist(), *d.to_m.tolist())
        rows.writerow(
            [
                *names,
                *map(_number, numbers),
                f"{interval.level:g}",
                _number(interval.low),
                _number(interval.high),
                d.status,
                *map(_number, points),
                *_uncertainty(d),
                *([] if result.tape is None else _tape_cells(tape.get(d.id))),
            ]
        )
    replace_file(path, text.getvalue().encode())


def _uncertainty(dimension: Dimension) -> list[str]:
    """Budget, coverage factor, degrees of freedom (empty where infinite) and Level of Accuracy."""
    factor, budget = dimension.quantity.coverage_factor, dimension.quantity.budget
    numbers = [""] * 5
    if budget is not None:
        parts = (budget.data_std, budget.scale_std, budget.definition_std)
        numbers = [*map(_number, parts), "", _number(budget.effective_dof)]
    numbers[3] = "" if factor is None else _number(factor)
    return [*numbers, dimension.loa or ""]


def _tape_cells(check: TapeCheck | None) -> list[str]:
    if check is None:
        return [""] * len(_TAPE_COLUMNS)
    numbers = (check.value_m, check.std_m, check.deviation_m, check.e_n)
    return [*map(_number, numbers), "yes" if check.holds else "no"]


def _number(value: float) -> str:
    # Adding zero turns -0.0 into 0.0, which would otherwise depend on the order of a sum.
    return repr(round(value, 9) + 0.0) if math.isfinite(value) else ""
