"""The table that is taken on site."""

import csv
import io

from indoorfit.model import FitResult

from .table import what_is_measured


def tape_template(result: FitResult) -> str:
    """A CSV table with one row for each length of a model, values left empty.

    Lengths between the same two planes (both long walls of a box and its overall extent) are one length: the
    first of them has the row.
    """
    text = io.StringIO(newline="")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(
        ("dimension", "face_1", "face_2", "value", "unit", "std_mm", "instrument", "reading", "remark")
    )
    several = len(result.rooms) > 1
    done: set[frozenset[int]] = set()
    for d in result.dimensions:
        planes = frozenset(result.face(face).plane for face in d.faces)
        if planes in done:
            continue
        done.add(planes)
        about = f"{what_is_measured(d, several)}; the model says {d.quantity.value:.2f} m"
        rows.writerow((d.id, *d.faces, "", "m", "", "tape", "", about))
    return text.getvalue()
