"""Reading ``model.json`` back, for later conversion."""

import math
from pathlib import Path
from typing import get_args

import numpy as np

from ..model import (
    SIDES,
    Budget,
    Cube,
    Dimension,
    DimensionKind,
    DoorEvidence,
    Doorway,
    Face,
    FaceClass,
    FaceKind,
    FitResult,
    Frame,
    Interval,
    LoaClass,
    Method,
    Note,
    Plane,
    PlaneStatus,
    Quantity,
    RefusedRow,
    Role,
    Room,
    Shape,
    Side,
    TapeCheck,
    TapeVerdict,
)
from .checked_json import JsonNode, read_json
from .model_json import SCHEMA_NAME
from .textures import read_textures


def read_model_json(path: str | Path) -> FitResult:
    """The result that a ``model.json`` holds; without meshes, which follow from the shape.

    Textures are read from the folder beside it; a model that was copied without them has none.

    Raises:
        InputError: no JSON, another schema, a field that is missing or of the wrong kind, or a
            reference to something that is not in the file.
    """
    root = read_json(Path(path))
    root["schema"].choice(SCHEMA_NAME)
    root["unit"].choice("m")
    planes = tuple(_plane(node) for node in root["planes"].items())
    cubes = _cubes(root["cubes"], planes)
    cube_ids = tuple(cube.id for cube in cubes)
    rooms = tuple(_room(node, cube_ids) for node in root["rooms"].items())
    room_ids = _all_different(root["rooms"], [room.id for room in rooms])
    faces = tuple(_face(node, room_ids, cube_ids, len(planes)) for node in root["faces"].items())
    face_ids = _all_different(root["faces"], [face.id for face in faces])
    dimensions = tuple(_dimension(node, room_ids, face_ids) for node in root["dimensions"].items())
    _all_different(root["dimensions"], [dimension.id for dimension in dimensions])
    return FitResult(
        method=root["method"].choice(*get_args(Method)),
        level=root["level"].number(),
        frame=Frame(
            R_manhattan_scan=root["frame"]["R_manhattan_scan"].array(3, 3),
            origin_scan_m=root["frame"]["origin_scan"].array(3),
        ),
        shape=Shape(planes, cubes),
        rooms=rooms,
        faces=faces,
        dimensions=dimensions,
        meshes=(),
        noise=root["noise"].mapping(),
        notes=tuple(_note(node) for node in root["warnings"].items()),
        provenance=root["provenance"].mapping(),
        converged=root["converged"].truth(),
        adjacency=tuple(_doorway(node, room_ids, face_ids) for node in root["adjacency"].items()),
        textures=read_textures(root, Path(path).parent, face_ids),
        plane_covariance_m2=_covariance(root, len(planes)),
        tape=_tape(root["tape"]) if "tape" in root.mapping() else None,
    )


def _note(node: JsonNode) -> Note:
    faces = node["faces"].items() if "faces" in node.mapping() else ()
    return Note(node["code"].text(), node["message"].text(), tuple(face.text() for face in faces))


def _covariance(root: JsonNode, n_planes: int) -> np.ndarray | None:
    if "plane_covariance" not in root.mapping():
        return None
    return root["plane_covariance"].array(n_planes, n_planes)


def _tape(node: JsonNode) -> TapeVerdict:
    return TapeVerdict(
        source=node["source"].text(),
        sha256=node["sha256"].text(),
        checks=tuple(
            TapeCheck(
                dimension=check["dimension"].text(),
                lines=tuple(line.integer(1) for line in check["lines"].items()),
                value_m=check["value"].number(),
                std_m=check["std"].number(),
                deviation_m=check["deviation"].number(),
                e_n=check["e_n"].number(),
                holds=check["holds"].truth(),
            )
            for check in node["checks"].items()
        ),
        refused=tuple(RefusedRow(r["line"].integer(1), r["reason"].text()) for r in node["refused"].items()),
        chi2=node["chi2"].number(),
        p_value=node["p_value"].number(),
    )


def _plane(node: JsonNode) -> Plane:
    return Plane(
        axis="xyz".index(node["axis"].choice("x", "y", "z")),
        outward=_sign(node["outward"]),
        offset_m=node["offset"].number(),
        status=node["status"].choice(*get_args(PlaneStatus)),
        yaw_rad=node["yaw"].number() if "yaw" in node.mapping() else 0.0,
    )


def _sign(node: JsonNode) -> int:
    value = node.integer()
    if value not in (-1, 1):
        node.fail(str(value), "1 or -1")
    return value


def _cubes(node: JsonNode, planes: tuple[Plane, ...]) -> tuple[Cube, ...]:
    cubes: dict[str, Cube] = {}
    for item in node.items():
        cube_id = item["id"].text()
        if cube_id in cubes:
            item["id"].fail(f"{cube_id!r} for the second time", "an id of its own")
        parent = item["parent"].text_or_none()
        if parent is not None and parent not in cubes:
            item["parent"].fail(repr(parent), "a cube that comes before in the list")
        sides: dict[Side, int | None] = {
            side: _side_plane(item["sides"][side], planes, side, parent) for side in SIDES
        }
        between = _between(item, planes, sides)
        cubes[cube_id] = Cube(cube_id, item["role"].choice(*get_args(Role)), parent, sides, between)
    return tuple(cubes.values())


def _between(
    item: JsonNode, planes: tuple[Plane, ...], sides: dict[Side, int | None]
) -> tuple[int, int] | None:
    """The walls of the corner that an oblique wall cuts off; None for a cube along the axes."""
    turned = [k for k in sides.values() if k is not None and planes[k].oblique]
    if "between" not in item.mapping():
        if turned:
            item.fail(f"a cube with the oblique plane {turned[0]}", "the key 'between' with two planes")
        return None
    if len(turned) != 1:
        item["sides"].fail(f"{len(turned)} oblique planes", "one, as the cube lies between two others")
    ends = [node.integer(0, len(planes) - 1) for node in item["between"].items()]
    if len(ends) != 2 or sorted(planes[k].axis for k in ends if not planes[k].oblique) != [0, 1]:
        item["between"].fail(f"the planes {ends}", "one plane across x and one across y")
    return ends[0], ends[1]


def _side_plane(node: JsonNode, planes: tuple[Plane, ...], side: str, parent: str | None) -> int | None:
    if node.value is None:
        if parent is None:
            node.fail("open", "a plane (a cube without a parent is closed on all sides)")
        return None
    index = node.integer(0, len(planes) - 1)
    if "xyz"[planes[index].axis] != side[1]:
        node.fail(f"the plane {index} across {'xyz'[planes[index].axis]}", f"a plane across {side[1]}")
    return index


def _quantity(node: JsonNode) -> Quantity:
    budget, others = node.optional("budget"), node.optional("intervals")
    return Quantity(
        value=node["value"].number(),
        std=node["std"].number(),
        interval=_interval(node["interval"]),
        budget=None if budget.value is None else _budget(budget),
        intervals=() if others.value is None else tuple(_interval(item) for item in others.items()),
    )


def _interval(node: JsonNode) -> Interval:
    return Interval(node["level"].number(), node["low"].number(), node["high"].number())


def _budget(node: JsonNode) -> Budget:
    dof = node["effective_dof"]
    return Budget(
        data_std=node["data_std"].number(),
        scale_std=node["scale_std"].number(),
        definition_std=node["definition_std"].number(),
        effective_dof=math.inf if dof.value is None else dof.number(),
    )


def _room(node: JsonNode, cube_ids: tuple[str, ...]) -> Room:
    return Room(
        id=node["id"].text(),
        cube=_reference(node["cube"], cube_ids, "cube"),
        floor_area=_quantity(node["floor_area"]),
        volume=_quantity(node["volume"]),
        perimeter=_quantity(node["perimeter"]),
    )


def _face(node: JsonNode, room_ids: tuple[str, ...], cube_ids: tuple[str, ...], n_planes: int) -> Face:
    return Face(
        id=node["id"].text(),
        kind=node["kind"].choice(*get_args(FaceKind)),
        face_class=node["class"].choice(*get_args(FaceClass)),
        room=_reference(node["room"], room_ids, "room"),
        cube=_reference(node["cube"], cube_ids, "cube"),
        side=node["side"].choice(*SIDES),
        plane=node["plane"].integer(0, n_planes - 1),
        normal=node["normal"].array(3),
        rings_m=tuple(_ring(ring) for ring in node["rings"].items()),
        offset_std_m=node["offset_std"].number(),
        n_points=node["points"].integer(0),
        coverage=node["coverage"].number(),
        rms_m=node["rms"].number(),
        status=node["status"].choice(*get_args(PlaneStatus)),
    )


def _ring(node: JsonNode) -> np.ndarray:
    ring = node.array(None, 3)
    if len(ring) < 3:
        node.fail(f"a ring of {len(ring)} corners", "a ring of at least 3")
    return ring


def _dimension(node: JsonNode, room_ids: tuple[str, ...], face_ids: tuple[str, ...]) -> Dimension:
    faces = [_reference(face, face_ids, "face") for face in node["faces"].items()]
    if len(faces) != 2:
        node["faces"].fail(f"a list of {len(faces)}", "a list of 2")
    loa = node.optional("loa")
    return Dimension(
        id=node["id"].text(),
        kind=node["kind"].choice(*get_args(DimensionKind)),
        room=_reference(node["room"], room_ids, "room"),
        faces=(faces[0], faces[1]),
        wall=None if node["wall"].value is None else _reference(node["wall"], face_ids, "face"),
        from_m=node["from"].array(3),
        to_m=node["to"].array(3),
        quantity=_quantity(node),
        status=node["status"].choice(*get_args(PlaneStatus)),
        loa=None if loa.value is None else loa.choice(*get_args(LoaClass)),
    )


def _all_different(node: JsonNode, ids: list[str]) -> tuple[str, ...]:
    for item, text in zip(node.items(), ids, strict=True):
        if ids.count(text) > 1:
            item["id"].fail(f"{text!r}"[:60] + ", like another", "an id of its own")
    return tuple(ids)


def _doorway(node: JsonNode, room_ids: tuple[str, ...], face_ids: tuple[str, ...]) -> Doorway:
    rooms = [_reference(room, room_ids, "room") for room in node["rooms"].items()]
    faces = [_reference(face, face_ids, "face") for face in node["faces"].items()]
    for key, ids in (("rooms", rooms), ("faces", faces)):
        if len(ids) != 2:
            node[key].fail(f"a list of {len(ids)}", "a list of 2")
    return Doorway(
        id=node["id"].text(),
        rooms=(rooms[0], rooms[1]),
        faces=(faces[0], faces[1]),
        sill_m=node["sill"].array(3),
        width_m=node["width"].number(),
        evidence=tuple(item.choice(*get_args(DoorEvidence)) for item in node["evidence"].items()),
        height_m=node["height"].number() if "height" in node.mapping() else None,
    )


def _reference(node: JsonNode, ids: tuple[str, ...], kind: str) -> str:
    target = node.text()
    if target not in ids:
        node.fail(repr(target)[:60], f"the id of a {kind} in this file")
    return target
