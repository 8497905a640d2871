"""Quantities, intervals and status as property sets."""

from typing import Any

from indoorfit.model import Dimension, Face, FitResult, Quantity, Room

from .document import IfcDocument, name_of
from .geometry import face_area_m2, opening_area_m2


def add_model_facts(ifc: IfcDocument, site: Any, result: FitResult, R_scan_levelled: list) -> None:
    """Method, level, pose and warnings, on the site."""
    frame = result.frame
    values = {
        "Method": ifc.label(result.method),
        "Level": ifc.measure("Ratio", result.level),
        "Converged": ifc.make("IfcBoolean", bool(result.converged)),
        "ScanNote": ifc.text(
            "World coordinates are the scan's, turned level about the origin of the scan: "
            "p_scan = R_scan_levelled (p_world - origin_scan) + origin_scan, metres. "
            "The reference system of the scan is not known."
        ),
        **{f"OriginScan{'XYZ'[k]}": ifc.measure("Length", v) for k, v in enumerate(frame.origin_scan_m)},
        **{
            f"R_scan_levelled_{i + 1}{j + 1}": ifc.make("IfcReal", float(R_scan_levelled[i][j]))
            for i in range(3)
            for j in range(3)
        },
        **{
            f"Warning{k}": ifc.text(f"{note.code}: {note.message}")
            for k, note in enumerate(result.notes, start=1)
        },
    }
    ifc.properties(site, "site", "Indoorfit_Model", values)


def add_room_facts(ifc: IfcDocument, space: Any, result: FitResult, room: Room) -> None:
    """Base quantities by their standard names, the same with intervals, and the room's dimensions."""
    heights = [d for d in result.dimensions if d.room == room.id and d.kind == "height"]
    quantities = {
        "NetFloorArea": ("Area", room.floor_area),
        "NetVolume": ("Volume", room.volume),
        "NetPerimeter": ("Length", room.perimeter),
    }
    if heights:
        quantities["Height"] = ("Length", heights[0].quantity)
    base = {name: (kind, quantity.value) for name, (kind, quantity) in quantities.items()}
    ifc.quantities(space, room.id, "Qto_SpaceBaseQuantities", base)
    values: dict[str, Any] = {}
    for name, (kind, quantity) in quantities.items():
        values.update(_quantity(ifc, name, kind, quantity))
    ifc.properties(space, room.id, "Indoorfit_Room", {"RoomId": ifc.text(room.id), **values})
    for dimension in result.dimensions:
        if dimension.room == room.id and dimension.wall is None:
            _add_dimension(ifc, space, dimension)


def add_face_facts(ifc: IfcDocument, element: Any, result: FitResult, face: Face) -> None:
    """Identity, status and uncertainty of a face, its area, and the clear length of a wall."""
    values = {
        "FaceId": ifc.text(face.id),
        "Kind": ifc.label(face.kind),
        "Class": ifc.label(face.face_class),
        "Room": ifc.text(face.room),
        "Status": ifc.label(face.status),
        "OffsetStd": ifc.measure("Length", face.offset_std_m),
        "Points": ifc.make("IfcInteger", int(face.n_points)),
        "Coverage": ifc.measure("Ratio", face.coverage),
        "Rms": ifc.measure("Length", face.rms_m),
        "Thickness": ifc.label("not measured: the geometry is the surface seen from the room"),
    }
    ifc.properties(element, face.id, "Indoorfit_Face", values)
    area_m2 = face_area_m2(face)
    if face.kind in ("floor", "ceiling"):
        ifc.quantities(element, face.id, "Qto_SlabBaseQuantities", {"NetArea": ("Area", area_m2)})
    else:
        net_m2 = area_m2 - opening_area_m2(result, face)
        sides = {"GrossSideArea": ("Area", area_m2), "NetSideArea": ("Area", net_m2)}
        ifc.quantities(element, face.id, "Qto_WallBaseQuantities", sides)
    for dimension in result.dimensions:
        if dimension.wall == face.id:
            _add_dimension(ifc, element, dimension)


def _add_dimension(ifc: IfcDocument, target: Any, dimension: Dimension) -> None:
    values = {
        "DimensionId": ifc.text(dimension.id),
        "Kind": ifc.label(dimension.kind),
        "FaceFrom": ifc.text(dimension.faces[0]),
        "FaceTo": ifc.text(dimension.faces[1]),
        "Status": ifc.label(dimension.status),
        **_quantity(ifc, "Value", "Length", dimension.quantity),
    }
    key = f"dimension/{dimension.id}"
    ifc.properties(target, key, name_of(f"Indoorfit_Dimension_{dimension.id}"), values)


def _quantity(ifc: IfcDocument, name: str, kind: str, quantity: Quantity) -> dict[str, Any]:
    """The interval as a bounded value around its set point, the standard uncertainty and the level."""
    low, value, high = (
        ifc.measure(kind, number)
        for number in (quantity.interval.low, quantity.value, quantity.interval.high)
    )
    return {
        name: (low, value, high),
        f"{name}Std": ifc.measure(kind, quantity.std),
        f"{name}Level": ifc.measure("Ratio", quantity.interval.level),
    }
