"""The joint and the greedy model of one scan side by side: as a table, as JSON values, as a picture."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from indoorfit.evaluate import Comparison
from indoorfit.export import quantity_text
from indoorfit.model import Dimension, FitResult, Quantity

from .facts import level_text
from .table import aligned, what_is_measured

VERSUS_SCHEMA = "indoorfit.compare/1"


def versus_document(
    joint: FitResult | None,
    greedy: FitResult | None,
    matched: Comparison | None,
    refusals: Mapping[str, str],
) -> dict[str, Any]:
    """Everything that is compared, as plain values: metres, square metres, cubic metres, seconds.

    Args:
        joint, greedy: the two models; None where a way of fitting found none.
        matched: which faces and lengths of the two belong together; None unless there are both.
        refusals: by method, why there is no model.
    """
    pairs = length_pairs(joint, greedy, matched)
    return {
        "schema": VERSUS_SCHEMA,
        "methods": {
            name: {"refused": refusals.get(name)} if result is None else _method(result)
            for name, result in (("joint", joint), ("greedy", greedy))
        },
        "dimensions": [
            {
                "joint": None if a is None else _length(a),
                "greedy": None if b is None else _length(b),
                "difference": None if a is None or b is None else b.quantity.value - a.quantity.value,
            }
            for a, b in pairs
        ],
        "structure": None
        if matched is None
        else {
            "greedy_lacks": list(matched.missing),
            "only_greedy_has": list(matched.extra),
            "moved": [
                {"joint": item.truth, "greedy": item.model, "distance": item.distance_m}
                for item in matched.misplaced
            ],
            "footprint_iou": matched.footprint_iou,
        },
    }


def versus_table(
    joint: FitResult | None,
    greedy: FitResult | None,
    matched: Comparison | None,
    refusals: Mapping[str, str],
) -> str:
    """The same as aligned lines for the terminal."""
    blocks = []
    either = joint or greedy
    assert either is not None, "at least one way of fitting found a model"
    level = level_text(either.level)
    several = len(either.rooms) > 1
    rows = []
    for a, b in length_pairs(joint, greedy, matched):
        named = a or b
        assert named is not None, "a pair has at least one side"
        difference = "" if a is None or b is None else f"{1e3 * (b.quantity.value - a.quantity.value):+.1f}"
        ids = f"{a.id if a else '-'} / {b.id if b else '-'}"
        rows.append((ids, what_is_measured(named, several), _text(a), _text(b), difference))
    head = ("joint / greedy", "what", f"joint m, {level}", f"greedy m, {level}", "greedy - joint mm")
    blocks.append(aligned(head, rows))
    blocks.append(aligned(("", "joint", "greedy"), _facts(joint, greedy)))
    if matched is not None and matched.faults:
        blocks.append("The greedy model against the joint one: " + "; ".join(matched.faults) + ".")
    blocks += [f"No {method} model: {reason}" for method, reason in refusals.items()]
    return "\n\n".join(blocks) + "\n"


def _text(dimension: Dimension | None) -> str:
    if dimension is None:
        return "-"
    text = quantity_text(dimension.quantity)
    return text.together + (" inferred" if dimension.status == "inferred" else "")


def length_pairs(
    joint: FitResult | None, greedy: FitResult | None, matched: Comparison | None
) -> list[tuple[Dimension | None, Dimension | None]]:
    """Dimensions that belong together, then those that one model has alone.

    A length that comes several times (both long walls of a box and its overall extent) counts once.
    """
    if joint is None or greedy is None or matched is None:
        return [*((d, None) for d in _once(joint)), *((None, d) for d in _once(greedy))]
    known_joint = {d.id: d for d in joint.dimensions}
    known_greedy = {d.id: d for d in greedy.dimensions}
    found = {check.truth: check.model for check in matched.lengths}
    pairs: list[tuple[Dimension | None, Dimension | None]] = [
        (d, known_greedy[found[d.id]] if d.id in found else None) for d in _once(joint)
    ]
    taken = {greedy.decided_by(known_greedy[name]) for name in found.values()}
    assert set(found) <= set(known_joint), "matched lengths are the joint model's"
    return pairs + [(None, d) for d in _once(greedy) if greedy.decided_by(d) not in taken]


def _once(result: FitResult | None) -> list[Dimension]:
    first: dict[frozenset[int], Dimension] = {}
    if result is not None:
        for dimension in result.dimensions:
            first.setdefault(result.decided_by(dimension), dimension)
    return list(first.values())


def _method(result: FitResult) -> dict[str, Any]:
    timings = dict(result.provenance["timings_s"])
    return {
        "level": result.level,
        "converged": result.converged,
        "seconds": sum(timings.values()),
        "timings_s": timings,
        "rms": pooled_rms_m(result),
        "faces": [
            {"id": f.id, "rms": f.rms_m, "points": f.n_points, "coverage": f.coverage, "status": f.status}
            for f in result.faces
        ],
        "rooms": [
            {
                "id": room.id,
                "floor_area": _quantity(room.floor_area),
                "volume": _quantity(room.volume),
                "perimeter": _quantity(room.perimeter),
            }
            for room in result.rooms
        ],
        "warnings": [{"code": note.code, "message": note.message} for note in result.notes],
    }


def _length(dimension: Dimension) -> dict[str, Any]:
    return {
        "id": dimension.id,
        "faces": list(dimension.faces),
        "status": dimension.status,
        "loa": dimension.loa,
        **_quantity(dimension.quantity),
    }


def _quantity(quantity: Quantity) -> dict[str, Any]:
    interval = quantity.interval
    return {
        "value": quantity.value,
        "std": quantity.std,
        "low": interval.low,
        "high": interval.high,
    }


def pooled_rms_m(result: FitResult) -> float:
    """Robust spread of all points about their planes, metres: the faces' own, weighted by points."""
    planes = {face.plane: face for face in result.faces}.values()
    n = sum(face.n_points for face in planes)
    return float(np.sqrt(sum(face.n_points * face.rms_m**2 for face in planes) / n)) if n else 0.0


def _facts(joint: FitResult | None, greedy: FitResult | None) -> list[tuple[str, str, str]]:
    """What is not a length: one row each, a column per model."""

    def both(name: str, say) -> tuple[str, str, str]:
        a, b = ("-" if result is None else say(result) for result in (joint, greedy))
        return name, a, b

    def rooms(what: str, unit: str):
        def say(result: FitResult) -> str:
            texts = [quantity_text(getattr(room, what), 2, 3) for room in result.rooms]
            return "; ".join(f"{text.together} {unit}" for text in texts)

        return say

    return [
        both("walls", lambda r: str(sum(face.kind == "wall" for face in r.faces))),
        both("inferred faces", lambda r: str(sum(face.status == "inferred" for face in r.faces))),
        both("floor area", rooms("floor_area", "m²")),
        both("volume", rooms("volume", "m³")),
        both("perimeter", rooms("perimeter", "m")),
        both("spread about the planes", lambda r: f"{1e3 * pooled_rms_m(r):.1f} mm"),
        both("points on the planes", lambda r: str(sum({f.plane: f.n_points for f in r.faces}.values()))),
        both("time of the fit", lambda r: f"{r.provenance['timings_s'].get('fit', 0.0):.2f} s"),
        both("time in all", lambda r: f"{sum(r.provenance['timings_s'].values()):.2f} s"),
        both("warnings", lambda r: ", ".join(sorted({note.code for note in r.notes})) or "none"),
    ]
