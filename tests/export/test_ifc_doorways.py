"""Doorways in IFC: holes in both walls, a door in one of them, at the right place."""

import gc
import warnings
from dataclasses import replace

import ifcopenshell
import ifcopenshell.geom
import ifcopenshell.util.element
import ifcopenshell.util.placement
import ifcopenshell.util.shape
import ifcopenshell.validate
import numpy as np
import pytest
from rooms import FLAT, make_result

from indoorfit.export import write_ifc
from indoorfit.model import Doorway

# Between x = 4.2 and 4.3 m, and between y = 3.1 and 3.22 m; the second shows no lintel.
SILLS_M = {"door-1": (4.25, 1.5, -1.3), "door-2": (2.0, 3.16, -1.3)}
SIZES_M = {"door-1": (0.9, 2.05), "door-2": (0.8, 2.7)}
JOINED = {"door-1": ("room-1", "room-2"), "door-2": ("room-1", "room-3")}
FACES = {"door-1": ("wall-2", "wall-10"), "door-2": ("wall-3", "wall-11")}


@pytest.fixture(scope="module")
def house():
    result = make_result(*FLAT)
    doors = tuple(
        Doorway(
            name,
            JOINED[name],
            FACES[name],
            result.frame.to_scan(np.array(SILLS_M[name])),
            SIZES_M[name][0],
            ("holes", "floor"),
            2.05 if name == "door-1" else None,
        )
        for name in SILLS_M
    )
    return replace(result, adjacency=doors)


@pytest.fixture(scope="module")
def ifc_file(house, tmp_path_factory):
    path = tmp_path_factory.mktemp("ifc") / "model.ifc"
    write_ifc(path, house)
    return ifcopenshell.open(str(path))


def area_m2(element, subtract: bool) -> float:
    settings = ifcopenshell.geom.settings()
    settings.set("disable-opening-subtractions", not subtract)
    return ifcopenshell.util.shape.get_area(ifcopenshell.geom.create_shape(settings, element).geometry)


def test_a_house_with_doorways_is_valid_by_schema_and_express_rules(ifc_file):
    logger = ifcopenshell.validate.json_logger()
    with warnings.catch_warnings():
        # ifcopenshell leaves the file of its rules to the garbage collector.
        warnings.simplefilter("ignore", ResourceWarning)
        ifcopenshell.validate.validate(ifc_file, logger, express_rules=True)
        gc.collect()
    assert logger.statements == []


def test_every_doorway_is_cut_out_of_both_its_walls_by_its_area(ifc_file):
    voided = {}
    for relation in ifc_file.by_type("IfcRelVoidsElement"):
        wall = relation.RelatingBuildingElement
        voided[wall.Name] = relation.RelatedOpeningElement.Name
        said = ifcopenshell.util.element.get_psets(wall)["Qto_WallBaseQuantities"]
        width_m, height_m = SIZES_M[relation.RelatedOpeningElement.Name.split("/")[0]]
        # The kernel joins within 1e-6 m: of 8 m of edges less than 1e-5 m².
        assert area_m2(wall, False) == pytest.approx(said["GrossSideArea"], abs=1e-5)
        assert area_m2(wall, True) == pytest.approx(said["NetSideArea"], abs=1e-5)
        assert said["GrossSideArea"] - said["NetSideArea"] == pytest.approx(width_m * height_m, abs=1e-9)
    assert voided == {face: f"{n}/{k + 1}" for n, faces in FACES.items() for k, face in enumerate(faces)}


def test_a_door_fills_every_doorway_and_joins_its_rooms(ifc_file):
    doors = {door.Name: door for door in ifc_file.by_type("IfcDoor")}
    assert set(doors) == set(JOINED)
    for name, door in doors.items():
        (filled,) = door.FillsVoids
        assert filled.RelatingOpeningElement.Name == f"{name}/1"
        assert {bound.RelatingSpace.Name for bound in door.ProvidesBoundaries} == set(JOINED[name])
        facts = ifcopenshell.util.element.get_psets(door)["Indoorfit_Doorway"]
        assert (facts["Room1"], facts["Room2"]) == JOINED[name]
        assert (facts["Face1"], facts["Face2"]) == FACES[name]
        assert door.OverallWidth == SIZES_M[name][0]
        assert ifcopenshell.util.element.get_container(door).is_a("IfcBuildingStorey")
    assert doors["door-1"].OverallHeight == 2.05
    # Nobody saw how high it is.
    assert doors["door-2"].OverallHeight is None


def test_doors_and_openings_lie_where_the_doorways_are(house, ifc_file):
    settings = ifcopenshell.geom.settings()
    settings.set("use-world-coords", True)
    site = ifcopenshell.util.element.get_psets(ifc_file.by_type("IfcSite")[0])["Indoorfit_Model"]
    R = np.array([[site[f"R_scan_levelled_{i}{j}"] for j in (1, 2, 3)] for i in (1, 2, 3)])
    origin = house.frame.origin_scan_m

    def extent(element):
        if element.is_a("IfcDoor"):
            # The kernel makes faces only; the outline is a line.
            (line,) = element.Representation.Representations[0].Items
            place = ifcopenshell.util.placement.get_local_placement(element.ObjectPlacement)
            world = np.array([p.Coordinates for p in line.Points]) @ place[:3, :3].T + place[:3, 3]
        else:
            verts = ifcopenshell.geom.create_shape(settings, element).geometry.verts
            world = np.array(verts).reshape(-1, 3)
        corners = house.frame.to_manhattan((world - origin) @ R.T + origin)
        return corners.min(axis=0), corners.max(axis=0)

    for door in ifc_file.by_type("IfcDoor"):
        sill, (width_m, height_m) = np.array(SILLS_M[door.Name]), SIZES_M[door.Name]
        axis = 0 if door.Name == "door-1" else 1
        reach = np.array([0.5 * width_m, 0.5 * width_m, 0.0])
        reach[axis] = 0.0
        low, high = extent(door)
        # Map coordinates of 5e6 m leave 1e-9 m; the kernel joins within 1e-6 m.
        np.testing.assert_allclose(low, sill - reach, rtol=0, atol=2e-6)
        np.testing.assert_allclose(high, sill + reach + [0.0, 0.0, height_m], rtol=0, atol=2e-6)
        for opening in ifc_file.by_type("IfcOpeningElement"):
            if opening.Name.startswith(door.Name):
                low, high = extent(opening)
                assert high[2] - low[2] == pytest.approx(height_m, abs=2e-6)
                # Each half ends in the middle of the wall and holds the surface of its own side.
                face = FACES[door.Name][int(opening.Name[-1]) - 1]
                plane = house.shape.planes[house.face(face).plane]
                assert min(abs(low[axis] - sill[axis]), abs(high[axis] - sill[axis])) < 2e-6
                assert low[axis] + 0.01 < plane.offset_m < high[axis] - 0.01
