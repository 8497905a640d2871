"""Doorways: holes through the walls of two rooms, and the doors that fill them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.model import Doorway, FitResult

from .document import IfcDocument, name_of
from .geometry import opening_height_m

_CLEAR_M = 0.05
"""How far an opening reaches into the room, so that the surface of the wall lies inside of it."""


@dataclass(frozen=True)
class _Hole:
    """A doorway in the Manhattan frame."""

    axis: int
    """Across the wall."""
    sill_m: Float[np.ndarray, " 3"]
    width_m: float
    height_m: float


def add_doorways(
    ifc: IfcDocument, body: Any, result: FitResult, walls: Mapping[str, Any], spaces: Mapping[str, Any]
) -> None:
    """Cut every doorway out of the wall on either side, and put one door into it.

    Each side of a wall is an IfcWall, so each has an IfcOpeningElement of its own: they meet in the middle
    between the two faces. The IfcDoor fills the first of them. Its representation is the standard's
    ``Profile``, the outline of the clear opening: whether a leaf hangs in it was not seen. Where no lintel
    was seen, the opening ends with the wall and the door has no OverallHeight.

    Args:
        ifc: the file.
        body: representation context of bodies.
        result: the model.
        walls: the building elements by face id.
        spaces: the spaces by room id.
    """
    profile = ifc.make(
        "IfcGeometricRepresentationSubContext",
        ContextIdentifier="Profile",
        ContextType="Model",
        ParentContext=body.ParentContext,
        TargetView="MODEL_VIEW",
    ) if result.adjacency else None  # fmt: skip
    doors: dict[Any, list[Any]] = {}
    for doorway in result.adjacency:
        if not all(face in walls for face in doorway.faces):
            continue  # walls without area are no building elements
        hole = _hole(result, doorway)
        openings = [_void(ifc, body, result, doorway, hole, k, walls[doorway.faces[k]]) for k in (0, 1)]
        door = _door(ifc, profile, doorway, hole, openings[0])
        _describe(ifc, door, openings, doorway, hole)
        for room in dict.fromkeys(doorway.rooms):
            _bound(ifc, spaces[room], door, f"{doorway.id}/{room}")
        storey = spaces[doorway.rooms[0]].Decomposes[0].RelatingObject
        doors.setdefault(storey, []).append(door)
    for storey, contained in doors.items():
        related = ("RelatedElements", contained)
        name = f"{storey.Name}/doors"
        ifc.relate("IfcRelContainedInSpatialStructure", name, ("RelatingStructure", storey), related)


def _hole(result: FitResult, doorway: Doorway) -> _Hole:
    sill_m = result.frame.to_manhattan(doorway.sill_m)
    axis = result.shape.planes[result.face(doorway.faces[0]).plane].axis
    return _Hole(axis, sill_m, doorway.width_m, opening_height_m(result, doorway))


def _void(
    ifc: IfcDocument, body: Any, result: FitResult, doorway: Doorway, hole: _Hole, side: int, wall: Any
) -> Any:
    """The half of a doorway that lies on one side of the middle of the wall."""
    plane = result.shape.planes[result.face(doorway.faces[side]).plane]
    ends_m = (plane.offset_m - plane.outward * _CLEAR_M, float(hole.sill_m[hole.axis]))
    size = [hole.width_m, hole.width_m]
    size[hole.axis] = abs(ends_m[1] - ends_m[0])
    middle = hole.sill_m.copy()
    middle[hole.axis] = 0.5 * (ends_m[0] + ends_m[1])
    outline = ifc.make("IfcRectangleProfileDef", "AREA", None, None, float(size[0]), float(size[1]))
    upward = ifc.make("IfcDirection", (0.0, 0.0, 1.0))
    item = ifc.make("IfcExtrudedAreaSolid", outline, None, upward, float(hole.height_m))
    shape = ifc.make("IfcShapeRepresentation", body, "Body", "SweptSolid", [item])
    storey_m = _storey_m(wall)
    place = ifc.placement(wall.ObjectPlacement, ifc.axes((middle - [0.0, 0.0, storey_m]).tolist()))
    key = f"{doorway.id}/{side + 1}"
    opening = ifc.rooted(
        "IfcOpeningElement",
        key,
        Name=name_of(key),
        ObjectPlacement=place,
        Representation=ifc.make("IfcProductDefinitionShape", None, None, [shape]),
        PredefinedType="OPENING",
    )
    voids = {"RelatingBuildingElement": wall, "RelatedOpeningElement": opening}
    ifc.rooted("IfcRelVoidsElement", key, **voids)
    return opening


def _storey_m(wall: Any) -> float:
    """Height of the wall's storey, Manhattan frame: where its coordinates begin."""
    return float(wall.ObjectPlacement.PlacementRelTo.RelativePlacement.Location.Coordinates[2])


def _door(ifc: IfcDocument, profile: Any, doorway: Doorway, hole: _Hole, opening: Any) -> Any:
    # In the coordinates of the opening, whose origin is above the sill but beside the middle of the wall.
    across = (
        hole.sill_m[hole.axis] - opening.ObjectPlacement.RelativePlacement.Location.Coordinates[hole.axis]
    )
    origin = [0.0, 0.0, 0.0]
    origin[hole.axis] = float(across)
    along = (0.0, 1.0, 0.0) if hole.axis == 0 else (1.0, 0.0, 0.0)
    half = 0.5 * hole.width_m
    corners = [[-half, 0.0, 0.0], [half, 0.0, 0.0], [half, 0.0, hole.height_m], [-half, 0.0, hole.height_m]]
    points = ifc.points(np.array(corners))
    line = ifc.make("IfcPolyline", [*points, points[0]])
    shape = ifc.make("IfcShapeRepresentation", profile, "Profile", "Curve3D", [line])
    door = ifc.rooted(
        "IfcDoor",
        doorway.id,
        Name=name_of(doorway.id),
        Tag=name_of(doorway.id),
        ObjectPlacement=ifc.placement(opening.ObjectPlacement, ifc.axes(origin, along)),
        Representation=ifc.make("IfcProductDefinitionShape", None, None, [shape]),
        OverallHeight=None if doorway.height_m is None else float(doorway.height_m),
        OverallWidth=float(doorway.width_m),
        PredefinedType="NOTDEFINED",
        OperationType="NOTDEFINED",
    )
    fills = {"RelatingOpeningElement": opening, "RelatedBuildingElement": door}
    ifc.rooted("IfcRelFillsElement", doorway.id, **fills)
    return door


def _describe(ifc: IfcDocument, door: Any, openings: Sequence[Any], doorway: Doorway, hole: _Hole) -> None:
    """Which rooms it joins, what speaks for it, and its size."""
    seen = "seen" if doorway.height_m is not None else "not seen: the opening ends with the wall"
    values = {
        "DoorwayId": ifc.text(doorway.id),
        **{f"Room{k}": ifc.text(room) for k, room in enumerate(doorway.rooms, start=1)},
        **{f"Face{k}": ifc.text(face) for k, face in enumerate(doorway.faces, start=1)},
        "Evidence": ifc.label(", ".join(doorway.evidence)),
        "Lintel": ifc.label(seen),
        "Accuracy": ifc.label("width and height approximate, to about a decimetre"),
    }
    ifc.properties(door, doorway.id, "Indoorfit_Doorway", values)
    sizes = {"Width": ("Length", hole.width_m), "Height": ("Length", hole.height_m)}
    for k, opening in enumerate(openings, start=1):
        ifc.quantities(opening, f"{doorway.id}/{k}", "Qto_OpeningElementBaseQuantities", sizes)


def _bound(ifc: IfcDocument, space: Any, door: Any, key: str) -> None:
    ifc.rooted(
        "IfcRelSpaceBoundary",
        key,
        Name="1stLevel",
        RelatingSpace=space,
        RelatedBuildingElement=door,
        PhysicalOrVirtualBoundary="PHYSICAL",
        InternalOrExternalBoundary="INTERNAL",
    )
