"""Every format against its own rules: validators, schemas and the specifications' texts."""

import gc
import json
import re
import subprocess
import sys
import warnings
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace

import ifcopenshell
import ifcopenshell.geom
import ifcopenshell.util.element
import ifcopenshell.util.shape
import ifcopenshell.validate
import jsonschema
import numpy as np
import plyfile
import pytest
from cityjson_schema import CITYJSON
from collada.schema import ColladaValidator
from gltf_validator import assert_nothing_found
from lxml import etree
from rooms import BOX, FLAT, L_ROOM, PILLAR, RAGGED, make_result, plan_area_m2
from scipy.spatial.transform import Rotation

from indoorfit.errors import OutputError
from indoorfit.export import (
    optional_module,
    write_3mf,
    write_cityjson,
    write_collada,
    write_glb,
    write_ifc,
    write_mesh_ply,
    write_stl,
    write_x3d,
)
from indoorfit.export.levelled import levelled
from indoorfit.model import Frame

HOUSES = {"l": (L_ROOM,), "ragged": (RAGGED,), "pillar": (PILLAR,), "flat": FLAT}


@pytest.fixture(params=HOUSES, scope="module")
def house(request):
    return make_result(*HOUSES[request.param])


def ifc_psets(element, name: str) -> dict:
    return ifcopenshell.util.element.get_psets(element)[name]


@pytest.fixture(scope="module")
def ifc_file(house, tmp_path_factory):
    path = tmp_path_factory.mktemp("ifc") / "model.ifc"
    write_ifc(path, house)
    return ifcopenshell.open(str(path))


def test_ifc_is_valid_by_schema_and_express_rules(tmp_path):
    # Takes seconds: one house with everything but doorways, which have a test of their own.
    write_ifc(tmp_path / "model.ifc", make_result(PILLAR, RAGGED, *FLAT))
    ifc_file = ifcopenshell.open(str(tmp_path / "model.ifc"))
    logger = ifcopenshell.validate.json_logger()
    with warnings.catch_warnings():
        # ifcopenshell leaves the file of its rules to the garbage collector.
        warnings.simplefilter("ignore", ResourceWarning)
        ifcopenshell.validate.validate(ifc_file, logger, express_rules=True)
        gc.collect()
    assert logger.statements == []
    ids = [entity.GlobalId for entity in ifc_file.by_type("IfcRoot")]
    assert len(set(ids)) == len(ids)


def test_ifc_spaces_have_the_volume_of_the_kernel_and_say_so(house, ifc_file):
    spaces = {space.Name: space for space in ifc_file.by_type("IfcSpace")}
    assert set(spaces) == {room.id for room in house.rooms}
    for room in house.rooms:
        shape = ifcopenshell.geom.create_shape(ifcopenshell.geom.settings(), spaces[room.id])
        volume_m3 = ifcopenshell.util.shape.get_volume(shape.geometry)
        assert volume_m3 == pytest.approx(room.volume.value, rel=1e-6)
        quantities = ifc_psets(spaces[room.id], "Qto_SpaceBaseQuantities")
        height = next(d for d in house.dimensions if d.room == room.id and d.kind == "height")
        expected = {
            "NetFloorArea": room.floor_area.value,
            "NetVolume": room.volume.value,
            "NetPerimeter": room.perimeter.value,
            "Height": height.quantity.value,
        }
        assert {key: quantities[key] for key in expected} == expected


def test_ifc_bounds_every_space_by_its_faces(house, ifc_file):
    bounded = {}
    for relation in ifc_file.by_type("IfcRelSpaceBoundary"):
        facts = ifc_psets(relation.RelatedBuildingElement, "Indoorfit_Face")
        bounded[facts["FaceId"]] = (relation.RelatingSpace.Name, relation.RelatedBuildingElement)
    assert {name: room for name, (room, _) in bounded.items()} == {f.id: f.room for f in house.faces}
    for face in house.faces:
        element = bounded[face.id][1]
        kind = {"wall": "IfcWall", "floor": "IfcSlab", "ceiling": "IfcSlab"}[face.kind]
        assert element.is_a(kind)
        facts = ifc_psets(element, "Indoorfit_Face")
        assert (facts["Status"], facts["OffsetStd"]) == (face.status, face.offset_std_m)
        shape = ifcopenshell.geom.create_shape(ifcopenshell.geom.settings(), element)
        area_m2 = ifcopenshell.util.shape.get_area(shape.geometry)
        quantity = "NetSideArea" if face.kind == "wall" else "NetArea"
        (said,) = (
            p[quantity] for p in ifcopenshell.util.element.get_psets(element).values() if quantity in p
        )
        assert said == pytest.approx(area_m2, rel=1e-6)


def test_ifc_holds_every_dimension_as_a_bounded_value(house, ifc_file):
    found = {}
    for pset in ifc_file.by_type("IfcPropertySet"):
        if pset.Name.startswith("Indoorfit_Dimension_"):
            values = {p.Name: p for p in pset.HasProperties}
            bounds = values["Value"]
            found[values["DimensionId"].NominalValue.wrappedValue] = (
                bounds.LowerBoundValue.wrappedValue,
                bounds.SetPointValue.wrappedValue,
                bounds.UpperBoundValue.wrappedValue,
                values["ValueStd"].NominalValue.wrappedValue,
                values["ValueLevel"].NominalValue.wrappedValue,
                values["Status"].NominalValue.wrappedValue,
            )
    expected = {}
    for d in house.dimensions:
        i = d.quantity.interval
        expected[d.id] = (i.low, d.quantity.value, i.high, d.quantity.std, i.level, d.status)
    assert found == expected


def test_ifc_puts_rooms_above_each_other_on_storeys(tmp_path):
    upper = replace(BOX, z_m=(1.7, 4.3))
    write_ifc(tmp_path / "model.ifc", make_result(BOX, upper))
    file = ifcopenshell.open(str(tmp_path / "model.ifc"))
    storeys = file.by_type("IfcBuildingStorey")
    assert [round(storey.Elevation, 6) for storey in storeys] == [-1.3, 1.7]
    assert [[s.Name for s in storey.IsDecomposedBy[0].RelatedObjects] for storey in storeys] == [
        ["room-1"],
        ["room-2"],
    ]


def test_cityjson_keeps_to_the_specification(house, tmp_path):
    write_cityjson(tmp_path / "model.city.json", house)
    document = json.loads((tmp_path / "model.city.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(CITYJSON).validate(document)
    objects, vertices = document["CityObjects"], document["vertices"]
    # 2 and 3 of the specification: children and parents name each other, and no vertex twice or unused.
    for key, item in objects.items():
        assert all(key in objects[child]["parents"] for child in item.get("children", []))
        assert all(key in objects[parent]["children"] for parent in item.get("parents", []))
    assert len({tuple(v) for v in vertices}) == len(vertices)
    used = set()
    for item in objects.values():
        for solid in item.get("geometry", []):
            (shell,), (values,) = solid["boundaries"], solid["semantics"]["values"]
            assert len(values) == len(shell)
            assert set(values) == set(range(len(solid["semantics"]["surfaces"])))
            used |= {k for surface in shell for ring in surface for k in ring}
    assert used == set(range(len(vertices)))
    extent = np.array(document["metadata"]["geographicalExtent"]).reshape(2, 3)
    corners = np.array(vertices) * document["transform"]["scale"] + document["transform"]["translate"]
    np.testing.assert_allclose(extent, [corners.min(axis=0), corners.max(axis=0)], rtol=0, atol=1e-9)


def test_cityjson_surfaces_are_interior_and_floors_are_level(house, tmp_path):
    write_cityjson(tmp_path / "model.city.json", house)
    document = json.loads((tmp_path / "model.city.json").read_text(encoding="utf-8"))
    heights = np.array(document["vertices"])[:, 2]
    kinds = {"wall": "InteriorWallSurface", "floor": "FloorSurface", "ceiling": "CeilingSurface"}
    found = {}
    for item in document["CityObjects"].values():
        for solid in item.get("geometry", []):
            semantics = solid["semantics"]
            for surface, value in zip(solid["boundaries"][0], semantics["values"][0], strict=True):
                facts = semantics["surfaces"][value]
                found[facts["id"]] = facts["type"]
                if facts["kind"] != "wall":
                    # One unit is 1e-7 m.
                    assert np.ptp(heights[[k for ring in surface for k in ring]]) <= 1
    assert found == {face.id: kinds[face.kind] for face in house.faces}


@pytest.mark.parametrize("plans", [(PILLAR,), FLAT], ids=["pillar", "flat"])
def test_cjio_opens_cityjson_with_the_same_rooms(plans, tmp_path):
    """The CityJSON developers' own tool.

    In a process of its own: to import it changes how json writes numbers.
    """
    result = make_result(*plans)
    write_cityjson(tmp_path / "model.city.json", result)
    cjio = [sys.executable, "-c", "from cjio.cjio import cli; cli()"]
    files = [str(tmp_path / "model.city.json"), "info"]
    done = subprocess.run([*cjio, *files], capture_output=True, text=True, check=True, timeout=60)
    assert f"BuildingRoom ({len(result.rooms)})" in done.stdout


def test_collada_is_valid_by_the_schema(house, tmp_path):
    write_collada(tmp_path / "model.dae", house)
    assert ColladaValidator().validate(etree.parse(tmp_path / "model.dae"))


def test_gltf_validator_finds_nothing(house, tmp_path):
    write_glb(tmp_path / "model.glb", house)
    assert_nothing_found(tmp_path / "model.glb")


def test_glb_extras_hold_faces_rooms_and_dimensions(house, tmp_path):
    import struct

    write_glb(tmp_path / "model.glb", house)
    content = (tmp_path / "model.glb").read_bytes()
    tree = json.loads(content[20 : 20 + struct.unpack("<I", content[12:16])[0]])
    extras = {node["name"]: node["extras"] for node in tree["nodes"] if "extras" in node}
    assert set(extras) == {item.id for item in (*house.rooms, *house.faces)}
    for face in house.faces:
        assert (extras[face.id]["status"], extras[face.id]["room"]) == (face.status, face.room)
    assert [d["id"] for d in tree["scenes"][0]["extras"]["dimensions"]] == [d.id for d in house.dimensions]


def test_3mf_bodies_are_manifold_outward_and_in_metres(house, tmp_path):
    write_3mf(tmp_path / "model.3mf", house)
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    with zipfile.ZipFile(tmp_path / "model.3mf") as package:
        assert {"[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"} == set(package.namelist())
        for name in package.namelist():
            etree.fromstring(package.read(name))
        root = etree.fromstring(package.read("3D/3dmodel.model"))
    # 3MF core 4.1: vertices of a model-type object form a closed, consistently oriented surface.
    for body in root.iter(f"{core}object"):
        edges = []
        for t in body.iter(f"{core}triangle"):
            a, b, c = (int(t.get(k)) for k in ("v1", "v2", "v3"))
            edges += [(a, b), (b, c), (c, a)]
        assert len(set(edges)) == len(edges)
        assert {(b, a) for a, b in edges} == set(edges)
    number = re.compile(r"[-+]?(\d+(\.\d+)?|\.\d+)([eE][-+]?\d+)?")
    assert all(number.fullmatch(v.get(k)) for v in root.iter(f"{core}vertex") for k in "xyz")


def test_ply_comments_explain_the_faces_in_ascii(house, tmp_path):
    write_mesh_ply(tmp_path / "model.ply", house)
    data = plyfile.PlyData.read(tmp_path / "model.ply")
    kinds = [comment.partition(" ")[0] for comment in data.comments]
    assert kinds.count("face") == len(house.faces)
    found = [json.loads(c.partition(" ")[2]) for c in data.comments if c.startswith("dimension ")]
    assert [(d["id"], d["low_m"], d["high_m"]) for d in found] == [
        (d.id, d.quantity.interval.low, d.quantity.interval.high) for d in house.dimensions
    ]


def test_stl_has_unit_normals_that_agree_with_its_corners(house, tmp_path):
    write_stl(tmp_path / "model.stl", house)
    text = (tmp_path / "model.stl").read_text(encoding="ascii")
    normals = np.array([line.split()[2:] for line in text.splitlines() if line.startswith("facet")], float)
    corners = [line.split()[1:] for line in text.splitlines() if line.startswith("  vertex")]
    a, b, c = np.moveaxis(np.array(corners, float).reshape(-1, 3, 3), 1, 0)
    across = np.cross(b - a, c - a)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    np.testing.assert_allclose(normals, across, rtol=0.0, atol=1e-6)
    assert text.count("\nendsolid ") == len(house.faces)


X3D_FIELDS = {
    "X3D": {"profile", "version"},
    "head": set(),
    "unit": {"category", "name", "conversionFactor"},
    "meta": {"name", "content"},
    "Scene": set(),
    "WorldInfo": {"title"},
    "NavigationInfo": {"type"},
    "Transform": {"DEF", "translation"},
    "Group": {"DEF"},
    "Viewpoint": {"description", "position", "orientation"},
    "Shape": {"DEF"},
    "Appearance": set(),
    "Material": {"DEF", "USE", "diffuseColor", "ambientIntensity"},
    "ImageTexture": {"url", "repeatS", "repeatT"},
    "IndexedFaceSet": {"ccw", "solid", "coordIndex"},
    "Coordinate": {"point"},
    "TextureCoordinate": {"point"},
    "MetadataSet": {"name", "containerField"},
    "MetadataString": {"name", "value", "containerField"},
    "MetadataDouble": {"name", "value", "containerField"},
    "MetadataInteger": {"name", "value", "containerField"},
}
"""The elements and attributes that we use, as ISO/IEC 19775-1 (V3.3) names them."""


def test_x3d_uses_only_nodes_and_fields_of_the_standard(house, tmp_path):
    write_x3d(tmp_path / "model.x3d", house)
    root = ET.parse(tmp_path / "model.x3d").getroot()
    for item in root.iter():
        named = {name for name in item.attrib if not name.startswith("{")}
        assert named <= X3D_FIELDS[item.tag], item.tag
    # 4.3.2 of ISO/IEC 19776-1: head comes first, units before the other statements of the header.
    assert [child.tag for child in root] == ["head", "Scene"]
    assert [child.tag for child in root[0]] == ["unit", "meta", "meta"]
    for item in root.iter("MetadataDouble"):
        assert np.isfinite(float(item.get("value")))
    sets = root.findall("Scene/Transform/MetadataSet/MetadataSet")
    assert [item.get("name") for item in sets] == [d.id for d in house.dimensions]


@pytest.mark.parametrize(
    "angles", [(0, 0, 0), (40, 0, 0), (-170, 5, -3), (10, 0, 90), (10, 90, 0), (0, 0, 180)]
)
def test_levelled_frames_turn_only_as_much_as_the_tilt(angles):
    R = Rotation.from_euler("zyx", angles, degrees=True).as_matrix()
    frame = Frame(R, np.array([3e5, 5e6, 1.0]))
    found = levelled(frame)
    # R_scan_levelled R_levelled_manhattan is the pose itself; rounding of a few sines.
    np.testing.assert_allclose(found.R_scan_levelled @ found.R_levelled_manhattan, R.T, rtol=0, atol=1e-12)
    tilt = np.arccos(np.clip(R[2, 2], -1.0, 1.0))
    turn = Rotation.from_matrix(found.R_scan_levelled).magnitude()
    # The arc cosine loses half the digits near 0 and pi.
    assert turn == pytest.approx(tilt, abs=1e-7)


def test_a_missing_library_is_named_with_its_extra():
    with pytest.raises(OutputError, match=r"pip install 'indoorfit\[ifc\]'"):
        optional_module("a_library_that_is_nowhere", "ifc", "IFC")


def test_areas_of_the_file_formats_come_from_rings_with_holes():
    from indoorfit.export.ifc.geometry import face_area_m2

    result = make_result(PILLAR)
    floor = result.face("floor-1")
    # 1e-9 m of rounding at map distance along some 20 m of edges.
    assert face_area_m2(floor) == pytest.approx(plan_area_m2(PILLAR), abs=1e-7)
