"""The output contract ``indoorfit.model/1``: a `FitResult` as a JSON document.

Field names are the contract's. Beyond it, so that nothing is lost: top-level ``planes``, ``converged``,
``adjacency`` and, where known, ``textures``, ``plane_covariance`` and ``tape``; ``sides`` of cubes, ``side``
and ``plane`` of faces, ``room``, ``wall`` and ``loa`` of dimensions, ``coverage_factor``, ``budget`` and
``intervals`` of quantities, ``faces`` of warnings.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from indoorfit.files import atomic_file

from ..model import (
    SIDES,
    TEXTURE_FOLDER,
    Cube,
    Dimension,
    Doorway,
    Face,
    FitResult,
    Interval,
    Note,
    Plane,
    Quantity,
    Room,
    Shape,
    TapeVerdict,
    TextureSet,
)

SCHEMA_NAME = "indoorfit.model/1"

SCHEMA_PATH = Path(__file__).with_name("model.schema.json")
"""The JSON schema (draft 2020-12) of the document, shipped with the package."""


def to_document(result: FitResult) -> dict[str, Any]:
    """The result as plain dicts, lists, strings and numbers, in the order of the contract.

    Numbers without a value (NaN, infinity) may occur only in the noise model and the provenance, where
    they become null; JSON has no others.

    Raises:
        ValueError: another number is not finite, or something has no JSON form: a fault of the caller.
    """
    bounds_m = result.cube_bounds_m()
    document = {
        "schema": SCHEMA_NAME,
        "unit": "m",
        "level": float(result.level),
        "method": result.method,
        "converged": bool(result.converged),
        "frame": {
            "R_manhattan_scan": _numbers(result.frame.R_manhattan_scan),
            "origin_scan": _numbers(result.frame.origin_scan_m),
        },
        "rooms": [_room(room) for room in result.rooms],
        "cubes": [_cube(cube, bounds_m[cube.id], result.shape) for cube in result.shape.cubes],
        "planes": [_plane(plane) for plane in result.shape.planes],
        "faces": [_face(face) for face in result.faces],
        "dimensions": [_dimension(dimension) for dimension in result.dimensions],
        "adjacency": [_doorway(doorway) for doorway in result.adjacency],
        # Left out where there are none, as in documents from before there were textures.
        **({} if result.textures is None else {"textures": _textures(result.textures)}),
        "noise": _plain(result.noise, "noise"),
        "warnings": [_warning(note) for note in result.notes],
        "provenance": _plain(result.provenance, "provenance"),
    }
    if result.plane_covariance_m2 is not None:
        document["plane_covariance"] = _numbers(result.plane_covariance_m2)
    if result.tape is not None:
        document["tape"] = _tape(result.tape)
    _require_finite(document, "")
    return document


def document_bytes(document: Mapping[str, Any]) -> bytes:
    """The document as UTF-8 JSON; floats as Python's shortest text that reads back to the same bits."""
    return (json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode("utf-8")


def write_model_json(path: str | Path, result: FitResult, *, overwrite: bool = True) -> None:
    """Write ``model.json``. The same result gives the same bytes.

    Raises:
        OutputError: the file cannot be written.
        ValueError: as `to_document`.
    """
    content = document_bytes(to_document(result))
    with atomic_file(path, overwrite=overwrite) as file:
        file.write(content)


def _warning(note: Note) -> dict[str, Any]:
    about = {"faces": list(note.faces)} if note.faces else {}
    return {"code": note.code, "message": note.message, **about}


def _numbers(array: np.ndarray) -> list:
    return np.asarray(array, dtype=np.float64).tolist()


def _quantity(quantity: Quantity) -> dict[str, Any]:
    document = {
        "value": float(quantity.value),
        "std": float(quantity.std),
        "interval": _interval(quantity.interval),
        "coverage_factor": quantity.coverage_factor,
        "budget": None,
        "intervals": [_interval(interval) for interval in quantity.intervals],
    }
    budget = quantity.budget
    if budget is not None:
        finite = math.isfinite(budget.effective_dof)
        document["budget"] = {
            "data_std": float(budget.data_std),
            "scale_std": float(budget.scale_std),
            "definition_std": float(budget.definition_std),
            "effective_dof": float(budget.effective_dof) if finite else None,
        }
    return document


def _interval(interval: Interval) -> dict[str, float]:
    return {"level": float(interval.level), "low": float(interval.low), "high": float(interval.high)}


def _room(room: Room) -> dict[str, Any]:
    return {
        "id": room.id,
        "cube": room.cube,
        "floor_area": _quantity(room.floor_area),
        "volume": _quantity(room.volume),
        "perimeter": _quantity(room.perimeter),
    }


def _cube(cube: Cube, bounds_m: np.ndarray, shape: Shape) -> dict[str, Any]:
    centre_m = 0.5 * (bounds_m[0] + bounds_m[1])
    if cube.front is not None:
        centre_m = shape.planes[cube.front].from_own(centre_m[None])[0]
    return {
        "id": cube.id,
        "role": cube.role,
        "parent": cube.parent,
        "centre": _numbers(centre_m),
        "size": _numbers(bounds_m[1] - bounds_m[0]),
        "open": list(cube.open_sides),
        "sides": {side: _index_or_none(cube.sides[side]) for side in SIDES},
        **({} if cube.between is None else {"yaw": shape.yaw_of(cube), "between": list(cube.between)}),
    }


def _index_or_none(index: int | None) -> int | None:
    return None if index is None else int(index)


def _plane(plane: Plane) -> dict[str, Any]:
    return {
        "axis": "xyz"[plane.axis],
        "outward": int(plane.outward),
        "offset": float(plane.offset_m),
        "status": plane.status,
        **({"yaw": float(plane.yaw_rad)} if plane.oblique else {}),
    }


def _face(face: Face) -> dict[str, Any]:
    return {
        "id": face.id,
        "kind": face.kind,
        "class": face.face_class,
        "room": face.room,
        "cube": face.cube,
        "side": face.side,
        "plane": int(face.plane),
        "normal": _numbers(face.normal),
        "offset_std": float(face.offset_std_m),
        "rings": [_numbers(ring) for ring in face.rings_m],
        "points": int(face.n_points),
        "coverage": float(face.coverage),
        "rms": float(face.rms_m),
        "status": face.status,
    }


def _dimension(dimension: Dimension) -> dict[str, Any]:
    return {
        "id": dimension.id,
        "kind": dimension.kind,
        "room": dimension.room,
        "faces": list(dimension.faces),
        "wall": dimension.wall,
        "from": _numbers(dimension.from_m),
        "to": _numbers(dimension.to_m),
        **_quantity(dimension.quantity),
        "status": dimension.status,
        "loa": dimension.loa,
    }


def _textures(textures: TextureSet) -> dict[str, Any]:
    """Where which image lies; the images themselves are files beside the document."""
    return {
        "folder": TEXTURE_FOLDER,
        "images": [
            {"file": image.name, "format": image.format, "width": image.width, "height": image.height}
            for image in textures.images
        ],
        "faces": [
            {
                "face": placement.face,
                "image": placement.image,
                "origin": _numbers(placement.origin_m),
                "origin_uv": _numbers(placement.origin_uv),
                "u_per_m": _numbers(placement.u_per_m),
                "v_per_m": _numbers(placement.v_per_m),
                "pixel": float(placement.pixel_m),
                "source": placement.source,
                "seen": float(placement.seen),
                "filled": float(placement.filled),
            }
            for placement in textures.placements.values()
        ],
    }


def _doorway(doorway: Doorway) -> dict[str, Any]:
    return {
        "id": doorway.id,
        "rooms": list(doorway.rooms),
        "faces": list(doorway.faces),
        "sill": _numbers(doorway.sill_m),
        "width": float(doorway.width_m),
        **({} if doorway.height_m is None else {"height": float(doorway.height_m)}),
        "evidence": list(doorway.evidence),
    }


def _tape(tape: TapeVerdict) -> dict[str, Any]:
    return {
        "source": tape.source,
        "sha256": tape.sha256,
        "chi2": float(tape.chi2),
        "p_value": float(tape.p_value),
        "checks": [
            {
                "dimension": check.dimension,
                "lines": list(check.lines),
                "value": float(check.value_m),
                "std": float(check.std_m),
                "deviation": float(check.deviation_m),
                "e_n": float(check.e_n),
                "holds": bool(check.holds),
            }
            for check in tape.checks
        ],
        "refused": [{"line": row.line, "reason": row.reason} for row in tape.refused],
    }


def _plain(value: Any, where: str) -> Any:
    """Free-form values for JSON: arrays as lists, numbers without a value as null."""
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist(), where)
    if isinstance(value, Mapping):
        return {str(key): _plain(item, f"{where}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, f"{where}[{index}]") for index, item in enumerate(value)]
    raise ValueError(f"{where} is of type {type(value).__name__}, which has no JSON form")


def _require_finite(value: Any, where: str) -> None:
    if isinstance(value, dict):
        for key, item in value.items():
            _require_finite(item, f"{where}.{key}" if where else key)
    elif isinstance(value, list):
        for index, item in enumerate(value):
            _require_finite(item, f"{where}[{index}]")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{where} is {value}; model.json holds finite numbers only")
