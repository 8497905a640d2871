"""Project, site, building, storeys, spaces and what bounds them."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from indoorfit.files import replace_file
from indoorfit.model import Face, FitResult, RoomMesh

from ..levelled import levelled
from .document import IfcDocument, name_of
from .facts import add_face_facts, add_model_facts, add_room_facts
from .geometry import face_surface, room_body
from .openings import add_doorways

_PRECISION_M = 1e-6
"""Points closer than this count as one."""

_DATE = "1970-01-01T00:00:00"
"""Of the header; the time of writing would give other bytes every time."""


def write_ifc(path: Path, result: FitResult) -> None:
    """Write the rooms as IFC4: an IfcSpace per room, an IfcWall or IfcSlab per face that bounds it.

    Spaces are closed bodies with base quantities. Faces are surfaces, for their thickness was not measured.
    Doorways are openings that void the walls on both sides, filled by an IfcDoor.
    Ceilings are slabs of the user-defined type CEILING. Intervals, standard uncertainties, levels and status
    are property sets ``Indoorfit_*``. The site is placed in the scan's coordinates turned level, its own
    axes along the walls; the exact pose is a property set of the site.

    Raises:
        OutputError: ifcopenshell is not installed, or the file cannot be written.
    """
    ifc = IfcDocument(seed=_seed(result))
    project, body = _project(ifc)
    frame = levelled(result.frame)
    site_place = ifc.placement(
        None, ifc.axes(frame.origin_m.tolist(), (math.cos(frame.yaw_rad), math.sin(frame.yaw_rad), 0.0))
    )
    site = _spatial(ifc, "IfcSite", "Site", site_place)
    building_place = ifc.placement(site_place)
    building = _spatial(ifc, "IfcBuilding", "Building", building_place)
    ifc.relate("IfcRelAggregates", "project", ("RelatingObject", project), ("RelatedObjects", [site]))
    ifc.relate("IfcRelAggregates", "site", ("RelatingObject", site), ("RelatedObjects", [building]))
    add_model_facts(ifc, site, result, frame.R_scan_levelled.tolist())
    storeys, spaces, elements = [], {}, {}
    for number, (floor_m, meshes) in enumerate(_storeys(result), start=1):
        place = ifc.placement(building_place, ifc.axes((0.0, 0.0, floor_m)))
        storey = _spatial(ifc, "IfcBuildingStorey", f"Storey {number}", place, Elevation=floor_m)
        storeys.append(storey)
        filled = _fill_storey(ifc, body, result, storey, meshes, floor_m)
        spaces.update(filled[0])
        elements.update(filled[1])
    add_doorways(ifc, body, result, elements, spaces)
    ifc.relate("IfcRelAggregates", "building", ("RelatingObject", building), ("RelatedObjects", storeys))
    replace_file(path, _content(ifc))


def _seed(result: FitResult) -> str:
    """What tells this model from others: its planes and its pose."""
    return repr((result.shape.offsets_m.tolist(), result.frame.origin_scan_m.tolist(), result.method))


def _project(ifc: IfcDocument) -> tuple[Any, Any]:
    """The project and the context of its bodies."""
    context = ifc.make(
        "IfcGeometricRepresentationContext", None, "Model", 3, _PRECISION_M, ifc.axes((0.0, 0.0, 0.0)), None
    )
    body = ifc.make(
        "IfcGeometricRepresentationSubContext",
        ContextIdentifier="Body",
        ContextType="Model",
        ParentContext=context,
        TargetView="MODEL_VIEW",
    )
    units = [
        ifc.make("IfcSIUnit", UnitType=kind, Name=name)
        for kind, name in (
            ("LENGTHUNIT", "METRE"),
            ("AREAUNIT", "SQUARE_METRE"),
            ("VOLUMEUNIT", "CUBIC_METRE"),
            ("PLANEANGLEUNIT", "RADIAN"),
        )
    ]
    project = ifc.rooted(
        "IfcProject",
        "project",
        Name="indoorfit model",
        RepresentationContexts=[context],
        UnitsInContext=ifc.make("IfcUnitAssignment", units),
    )
    return project, body


def _spatial(ifc: IfcDocument, kind: str, name: str, place: Any, **attributes: Any) -> Any:
    return ifc.rooted(kind, name, Name=name, ObjectPlacement=place, CompositionType="ELEMENT", **attributes)


def _storeys(result: FitResult) -> list[tuple[float, list[RoomMesh]]]:
    """Rooms that share a height range, with their lowest floor, from below; Manhattan frame."""
    ranges = []
    for mesh in result.meshes:
        heights = result.frame.to_manhattan(mesh.vertices_m)[:, 2]
        ranges.append((float(heights.min()), float(heights.max()), mesh))
    storeys: list[tuple[float, list[RoomMesh]]] = []
    lowest_ceiling = -math.inf
    # Rounding decides nothing: rooms on one level stay in their order.
    for floor_m, ceiling_m, mesh in sorted(ranges, key=lambda item: round(item[0], 6)):
        if floor_m >= lowest_ceiling - _PRECISION_M:
            storeys.append((floor_m, [mesh]))
            lowest_ceiling = ceiling_m
        elif storeys:
            storeys[-1][1].append(mesh)
            lowest_ceiling = min(lowest_ceiling, ceiling_m)
    return storeys


def _fill_storey(
    ifc: IfcDocument, body: Any, result: FitResult, storey: Any, meshes: Sequence[RoomMesh], floor_m: float
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Add the rooms of a storey; returns its spaces by room and its building elements by face."""
    rooms = {room.id: room for room in result.rooms}
    spaces, elements = {}, {}
    for mesh in meshes:
        space = ifc.rooted(
            "IfcSpace",
            mesh.room,
            Name=name_of(mesh.room),
            ObjectPlacement=ifc.placement(storey.ObjectPlacement),
            Representation=room_body(ifc, body, result, mesh, floor_m),
            CompositionType="ELEMENT",
            PredefinedType="INTERNAL",
        )
        add_room_facts(ifc, space, result, rooms[mesh.room])
        spaces[mesh.room] = space
        seen = set(mesh.face_ids)
        for face in result.faces:
            if face.room == mesh.room and face.id in seen:
                place = ifc.placement(storey.ObjectPlacement)
                shape = face_surface(ifc, body, result, face, floor_m)
                elements[face.id] = _element(ifc, face, place, shape)
                add_face_facts(ifc, elements[face.id], result, face)
                _bound(ifc, space, elements[face.id], face)
    key = str(storey.Name)
    ifc.relate("IfcRelAggregates", key, ("RelatingObject", storey), ("RelatedObjects", list(spaces.values())))
    contained = ("RelatedElements", list(elements.values()))
    ifc.relate("IfcRelContainedInSpatialStructure", key, ("RelatingStructure", storey), contained)
    return spaces, elements


def _element(ifc: IfcDocument, face: Face, place: Any, shape: Any) -> Any:
    user_type = {"PredefinedType": "USERDEFINED", "ObjectType": face.kind.upper()}
    kind, extra = {
        "wall": ("IfcWall", {"PredefinedType": "NOTDEFINED"}),
        "floor": ("IfcSlab", {"PredefinedType": "FLOOR"}),
        "ceiling": ("IfcSlab", user_type),
    }.get(face.kind, ("IfcWall", user_type))
    name = name_of(face.id)
    return ifc.rooted(
        kind, face.id, Name=name, Tag=name, ObjectPlacement=place, Representation=shape, **extra
    )


def _bound(ifc: IfcDocument, space: Any, element: Any, face: Face) -> None:
    ifc.rooted(
        "IfcRelSpaceBoundary",
        face.id,
        Name="1stLevel",
        RelatingSpace=space,
        RelatedBuildingElement=element,
        PhysicalOrVirtualBoundary="PHYSICAL",
        InternalOrExternalBoundary="NOTDEFINED",
    )


def _content(ifc: IfcDocument) -> bytes:
    header = ifc.file.header
    header.file_description.description = ("ViewDefinition [notYetAssigned]",)
    header.file_name.name = "indoorfit model"
    header.file_name.time_stamp = _DATE
    header.file_name.originating_system = "indoorfit"
    return ifc.file.to_string().encode("utf-8")
