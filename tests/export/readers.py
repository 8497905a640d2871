"""Every 3D format read back by a library or a parser that is not ours, into one simple form."""

import json
import os
import re
import struct
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import collada
import ifcopenshell
import ifcopenshell.geom
import ifcopenshell.util.element
import numpy as np
import plyfile
import pytest
import trimesh


@dataclass(frozen=True)
class Surface:
    """What a file holds: closed loops of corners per named face, in the scan frame as the file says."""

    faces: Mapping[str, list[np.ndarray]]
    rooms: tuple[str, ...]

    def volume_m3(self, near: np.ndarray) -> float:
        """Volume by the divergence theorem, positive for faces that look outward."""
        total = 0.0
        for loops in self.faces.values():
            for loop in loops:
                local = loop - near
                area = 0.5 * np.cross(local - local[0], np.roll(local, -1, axis=0) - local[0]).sum(axis=0)
                total += float(local[0] @ area) / 3.0
        return total

    def is_closed(self, near: np.ndarray) -> bool:
        """Whether every directed edge has its opposite; corners are matched to a micrometre."""
        edges: dict[tuple, int] = {}
        for loops in self.faces.values():
            for loop in loops:
                corners = [tuple(row) for row in np.round((loop - near) / 4e-6).astype(int).tolist()]
                for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
                    key, sign = ((a, b), 1) if a < b else ((b, a), -1)
                    edges[key] = edges.get(key, 0) + sign
        return not any(edges.values())


def loops_of(vertices: np.ndarray, triangles: np.ndarray) -> list[np.ndarray]:
    return list(np.asarray(vertices, float)[np.asarray(triangles)])


def read_glb(path: Path) -> Surface:
    content = path.read_bytes()
    (length,) = struct.unpack("<I", content[12:16])
    tree = json.loads(content[20 : 20 + length])
    T = np.array(tree["asset"]["extras"]["T_scan_gltf"])
    scene = trimesh.load_scene(path)
    faces = {
        name: loops_of(mesh.vertices @ T[:3, :3].T + T[:3, 3], mesh.faces)
        for name, mesh in scene.geometry.items()
    }
    for node in tree["nodes"]:
        if "mesh" in node:
            assert node["extras"]["id"] == node["name"]
    rooms = [n["name"] for n in tree["nodes"] if "children" in n and "mesh" not in n and n["name"] != "model"]
    return Surface(faces, tuple(rooms))


def read_obj(path: Path) -> Surface:
    vertices: list[list[float]] = []
    faces: dict[str, list[np.ndarray]] = {}
    rooms, name = [], ""
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word == "v":
            vertices.append([float(x) for x in rest])
        elif word == "o":
            rooms.append(rest[0])
        elif word == "g":
            name = rest[0]
        elif word == "f":
            corners = [vertices[int(corner.split("/")[0]) - 1] for corner in rest]
            faces.setdefault(name, []).append(np.array(corners))
    return Surface(faces, tuple(rooms))


def read_ply(path: Path) -> Surface:
    data = plyfile.PlyData.read(path)
    vertices = np.column_stack([data["vertex"][axis] for axis in "xyz"])
    facts = {}
    rooms = []
    for comment in data.comments:
        kind, _, rest = comment.partition(" ")
        if kind == "face":
            number, _, text = rest.partition(" ")
            facts[int(number)] = json.loads(text)
        elif kind == "room":
            rooms.append(json.loads(rest)["id"])
    faces: dict[str, list[np.ndarray]] = {facts[k]["id"]: [] for k in sorted(facts)}
    for corners, number in zip(data["face"]["vertex_indices"], data["face"]["face"], strict=True):
        faces[facts[int(number)]["id"]].append(vertices[corners])
    return Surface(faces, tuple(rooms))


def read_stl(path: Path, R_scan_manhattan: np.ndarray) -> Surface:
    scene = trimesh.load_scene(path, file_type="stl_ascii")
    faces, rooms = {}, []
    for title, mesh in scene.geometry.items():
        name, *pairs = title.split()
        facts = dict(pair.split("=") for pair in pairs)
        origin = np.array([float(x) for x in facts["origin_scan"].split(",")])
        assert facts["unit"] == "m"
        faces[name] = loops_of(mesh.vertices @ R_scan_manhattan.T + origin, mesh.faces)
        rooms += [facts["room"]] if facts["room"] not in rooms else []
    return Surface(faces, tuple(rooms))


def in_xml(text: str) -> str:
    """An id as an XML attribute holds it."""
    return re.sub("[\x00-\x08\x0b\x0c\x0e-\x1f]", "\N{REPLACEMENT CHARACTER}", text)


def read_3mf(path: Path) -> Surface:
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        root = ET.fromstring(package.read("3D/3dmodel.model"))
    assert root.get("unit") == "meter"
    facts = {m.get("name"): m.text for m in root.findall(f"{core}metadata")}
    model = json.loads(facts["indoorfit:model"])
    R, origin = np.array(model["R_manhattan_scan"]), np.array(model["origin_scan_m"])
    names = [base.get("name") for base in root.iter(f"{core}base")]
    assert names == [in_xml(face["id"]) for face in json.loads(facts["indoorfit:faces"])]
    faces: dict[str, list[np.ndarray]] = {name: [] for name in names}
    rooms = []
    objects = list(root.iter(f"{core}object"))
    assert {item.get("objectid") for item in root.iter(f"{core}item")} == {o.get("id") for o in objects}
    for body in objects:
        rooms.append(body.get("name"))
        corners = np.array([[float(v.get(k)) for k in "xyz"] for v in body.iter(f"{core}vertex")])
        for t in body.iter(f"{core}triangle"):
            chosen = corners[[int(t.get(k)) for k in ("v1", "v2", "v3")]]
            faces[names[int(t.get("p1"))]].append(chosen @ R + origin)
    return Surface(faces, tuple(rooms))


def read_dae(path: Path) -> Surface:
    document = collada.Collada(str(path))
    assert document.assetInfo.unitmeter == 1.0
    assert document.assetInfo.upaxis == "Z_UP"
    text = ET.parse(path)
    space = "{http://www.collada.org/2005/11/COLLADASchema}"
    model = json.loads(next(text.iter(f"{space}model")).text)
    R, origin = np.array(model["R_manhattan_scan"]), np.array(model["origin_scan_m"])
    faces, rooms = {}, []
    for room in document.scene.nodes:
        rooms.append(room.xmlnode.get("name"))
        for node in room.children:
            if not isinstance(node, collada.scene.Node):
                continue
            facts = json.loads(node.xmlnode.find(f"{space}extra/{space}technique/{space}face").text)
            assert in_xml(facts["id"]) == node.xmlnode.get("name") or not facts["id"].isidentifier()
            (geometry,) = (child.geometry for child in node.children if hasattr(child, "geometry"))
            (primitive,) = geometry.primitives
            # pycollada keeps 32 bits; the text has all digits.
            values = geometry.xmlnode.find(f".//{space}float_array[@id='{geometry.id}.positions.array']").text
            corners = np.array(values.split(), float).reshape(-1, 3)
            np.testing.assert_allclose(corners, primitive.vertex, rtol=1e-6, atol=1e-6)
            faces[facts["id"]] = loops_of(corners @ R + origin, primitive.vertex_index)
    return Surface(faces, tuple(rooms))


def read_x3d(path: Path) -> Surface:
    root = ET.parse(path).getroot()
    assert (root.tag, root.get("version")) == ("X3D", "3.3")
    transform = root.find("Scene/Transform")
    offset = np.array([float(x) for x in transform.get("translation").split()])
    faces, rooms = {}, []
    for group in transform.findall("Group"):
        rooms.append(mf_strings(group.find("MetadataSet/MetadataString[@name='id']").get("value"))[0])
        for shape in group.findall("Shape"):
            (name,) = mf_strings(shape.find("MetadataSet/MetadataString[@name='id']").get("value"))
            mesh = shape.find("IndexedFaceSet")
            assert (mesh.get("ccw"), mesh.get("solid")) == ("true", "true")
            points = np.array(mesh.find("Coordinate").get("point").split(), float).reshape(-1, 3) + offset
            indices = np.array(mesh.get("coordIndex").split(), int).reshape(-1, 4)
            assert (indices[:, 3] == -1).all()
            faces[name] = loops_of(points, indices[:, :3])
    names = [element.get("DEF") for element in root.iter() if element.get("DEF")]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z_][\w.-]*", name) for name in names)
    assert {e.get("USE") for e in root.iter() if e.get("USE")} <= set(names)
    return Surface(faces, tuple(rooms))


def read_vrml(path: Path) -> Surface:
    """By the importer of VTK, which has a parser of VRML97 of its own."""
    # Nothing is drawn, but the importer wants a window to draw in; this one needs no screen.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    vtk = pytest.importorskip("vtk", reason="the independent reader of VRML97 is not installed: vtk")
    importer = vtk.vtkVRMLImporter()
    importer.SetFileName(str(path))
    importer.Update()
    text = path.read_text(encoding="utf-8")
    # VTK keeps 32 bits of the offset; the text has all digits.
    offset = np.array([float(x) for x in re.search(r"Transform \{\s*translation (.*)", text)[1].split()])
    faces = {}
    for name in re.findall(r"DEF (\S+) Shape", text):
        actor = importer.GetVRMLDEFObject(name)
        np.testing.assert_allclose(actor.GetPosition(), offset, rtol=1e-7, atol=1e-7)
        mesh = actor.GetMapper().GetInput()
        points = np.array([mesh.GetPoint(k) for k in range(mesh.GetNumberOfPoints())])
        # GetCell hands out one and the same object again and again.
        corners = [[mesh.GetCell(k).GetPointId(i) for i in range(3)] for k in range(mesh.GetNumberOfCells())]
        faces[name] = loops_of(points + offset, np.array(corners))
    assert importer.GetRenderer().GetActors().GetNumberOfItems() == len(faces)
    return Surface(faces, tuple(re.findall(r"DEF (\S+) Group", text)))


def mf_strings(text: str) -> list[str]:
    return [re.sub(r"\\(.)", r"\1", piece) for piece in re.findall(r'"((?:[^"\\]|\\.)*)"', text, re.DOTALL)]


def read_ifc(path: Path) -> Surface:
    file = ifcopenshell.open(str(path))
    settings = ifcopenshell.geom.settings()
    settings.set("use-world-coords", True)
    site = ifcopenshell.util.element.get_psets(file.by_type("IfcSite")[0])["Indoorfit_Model"]
    R = np.array([[site[f"R_scan_levelled_{i}{j}"] for j in (1, 2, 3)] for i in (1, 2, 3)])
    origin = np.array([site[f"OriginScan{axis}"] for axis in "XYZ"])
    faces = {}
    for element in [*file.by_type("IfcWall"), *file.by_type("IfcSlab")]:
        facts = ifcopenshell.util.element.get_psets(element)["Indoorfit_Face"]
        shape = ifcopenshell.geom.create_shape(settings, element).geometry
        corners = (np.array(shape.verts).reshape(-1, 3) - origin) @ R.T + origin
        faces[facts["FaceId"]] = loops_of(corners, np.array(shape.faces).reshape(-1, 3))
    rooms = [
        ifcopenshell.util.element.get_psets(space)["Indoorfit_Room"]["RoomId"]
        for space in file.by_type("IfcSpace")
    ]
    return Surface(faces, tuple(rooms))


def read_cityjson(path: Path) -> Surface:
    document = json.loads(path.read_text(encoding="utf-8"))
    transform = document["transform"]
    vertices = np.array(document["vertices"]) * transform["scale"] + transform["translate"]
    objects = document["CityObjects"]
    (building,) = (item for item in objects.values() if item["type"] == "Building")
    R, origin = (np.array(building["attributes"][key]) for key in ("R_scan_levelled", "origin_scan_m"))
    vertices = (vertices - origin) @ R.T + origin
    faces, rooms = {}, []
    for key in building["children"]:
        rooms.append(objects[key]["attributes"]["id"])
        (solid,) = objects[key]["geometry"]
        for surface, value in zip(solid["boundaries"][0], solid["semantics"]["values"][0], strict=True):
            name = solid["semantics"]["surfaces"][value]["id"]
            faces[name] = [vertices[ring] for ring in surface]
    return Surface(faces, tuple(rooms))


OUTWARD = {"stl", "3mf", "cityjson"}
"""Formats of bodies; the others hold the surface that looks into the room."""

# How far a corner may be off, metres. Text holds all digits of a float64, of which 5e6 m leave 1e-9 m;
# float32 (VTK has it, too) within 16 m of the origin 5e-7 m an axis; CityJSON counts in 1e-7 m; the IFC
# kernel joins within
# 1e-6 m.
TOLERANCE_M = {"glb": 1e-6, "vrml": 1e-6, "cityjson": 1e-7, "ifc": 2e-6}
TEXT_TOLERANCE_M = 5e-9

READERS: dict[str, Callable[[Path], Surface]] = {
    "glb": read_glb,
    "obj": read_obj,
    "ply": read_ply,
    "3mf": read_3mf,
    "dae": read_dae,
    "x3d": read_x3d,
    "vrml": read_vrml,
    "ifc": read_ifc,
    "cityjson": read_cityjson,
}


def read_surface(name: str, path: Path, R_manhattan_scan: np.ndarray) -> Surface:
    """Read a file of a format; STL has no place for the rotation, which is given to it."""
    return read_stl(path, R_manhattan_scan.T) if name == "stl" else READERS[name](path)
