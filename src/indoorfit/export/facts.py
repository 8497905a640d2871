"""What every format says of a face, a room, a dimension and the whole model, as flat plain values.

The keys carry their units, so that a reader of any of the files needs no other page.
"""

import json
from collections.abc import Mapping

from indoorfit.model import Dimension, Face, FitResult, Quantity, Room

Fact = str | int | float
Facts = dict[str, Fact]


def face_facts(face: Face) -> Facts:
    """Identity, status and standard uncertainty of a face."""
    return {
        "id": face.id,
        "kind": face.kind,
        "class": face.face_class,
        "room": face.room,
        "status": face.status,
        "offset_std_m": float(face.offset_std_m),
        "points": int(face.n_points),
        "coverage": float(face.coverage),
        "rms_m": float(face.rms_m),
    }


def dimension_facts(dimension: Dimension) -> Facts:
    """A length with its interval; `wall` is empty for heights and overall extents."""
    return {
        "id": dimension.id,
        "kind": dimension.kind,
        "room": dimension.room,
        "wall": dimension.wall or "",
        "face_from": dimension.faces[0],
        "face_to": dimension.faces[1],
        **quantity_facts("", dimension.quantity, "m"),
        "status": dimension.status,
    }


def room_facts(room: Room) -> Facts:
    """Floor area, volume and perimeter with their intervals."""
    return {
        "id": room.id,
        **quantity_facts("floor_area_", room.floor_area, "m2"),
        **quantity_facts("volume_", room.volume, "m3"),
        **quantity_facts("perimeter_", room.perimeter, "m"),
    }


def quantity_facts(prefix: str, quantity: Quantity, unit: str) -> Facts:
    """Value, standard uncertainty and interval under keys that begin with the prefix."""
    return {
        f"{prefix}value_{unit}": float(quantity.value),
        f"{prefix}std_{unit}": float(quantity.std),
        f"{prefix}low_{unit}": float(quantity.interval.low),
        f"{prefix}high_{unit}": float(quantity.interval.high),
        f"{prefix}level": float(quantity.interval.level),
    }


def model_facts(result: FitResult) -> dict[str, object]:
    """How the model came about, and the pose of the Manhattan frame in the scan."""
    return {
        "generator": "indoorfit",
        "unit": "m",
        "method": result.method,
        "level": float(result.level),
        "converged": str(bool(result.converged)).lower(),
        "R_manhattan_scan": result.frame.R_manhattan_scan.tolist(),
        "origin_scan_m": result.frame.origin_scan_m.tolist(),
    }


def one_line(facts: Mapping[str, object]) -> str:
    """Facts as JSON in ASCII on one line, for formats that have only comments and texts."""
    return json.dumps(facts, ensure_ascii=True, separators=(", ", ": "))
