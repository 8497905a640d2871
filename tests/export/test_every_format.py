"""What holds for every 3D format: the same closed body, the same named faces, the same place."""

import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from readers import OUTWARD, READERS, TEXT_TOLERANCE_M, TOLERANCE_M, read_surface
from rooms import BOX, FLAT, FRAME, L_ROOM, PILLAR, RAGGED, make_result, plan_area_m2
from scipy.spatial.transform import Rotation

from indoorfit.errors import OutputError
from indoorfit.files import FormatName
from indoorfit.model import FitResult, Frame
from indoorfit.pipeline import FORMATS

HOUSES = {"l": (L_ROOM,), "ragged": (RAGGED,), "pillar": (PILLAR,), "flat": FLAT}
NAMES: list[FormatName] = [*READERS, "stl"]  # type: ignore[list-item]
FRAMES = {
    "plain": Frame(np.eye(3), np.zeros(3)),
    "y up": Frame(
        Rotation.from_euler("x", -90, degrees=True).as_matrix() @ FRAME.R_manhattan_scan,
        np.array([3.0e5, 5.0e6, -7.0]),
    ),
    "upside down": Frame(Rotation.from_euler("x", 180, degrees=True).as_matrix(), np.array([1.0, 2.0, 3.0])),
}


def written(name: FormatName, result: FitResult, folder):
    path = folder / f"model{FORMATS[name].suffix}"
    FORMATS[name].write(path, result, None)
    return path


def read_back(name: FormatName, result: FitResult, folder):
    return read_surface(name, written(name, result, folder), result.frame.R_manhattan_scan)


@pytest.mark.parametrize(
    ("plans", "frame"),
    [*((plans, FRAME) for plans in HOUSES.values()), *(((L_ROOM,), frame) for frame in FRAMES.values())],
    ids=[*HOUSES, *FRAMES],
)
@pytest.mark.parametrize("name", NAMES)
def test_every_format_holds_the_same_body_at_the_same_place(name, plans, frame, tmp_path):
    result = make_result(*plans, frame=frame)
    surface = read_back(name, result, tmp_path)
    near = frame.origin_scan_m
    volume_m3 = sum(plan_area_m2(plan) * (plan.z_m[1] - plan.z_m[0]) for plan in plans)
    sign = 1.0 if name in OUTWARD else -1.0
    assert surface.volume_m3(near) == pytest.approx(sign * volume_m3, rel=1e-6)
    assert surface.is_closed(near)
    assert surface.rooms == tuple(room.id for room in result.rooms)
    assert list(surface.faces) == [face.id for face in result.faces] or name in ("glb", "stl", "ifc")
    assert set(surface.faces) == {face.id for face in result.faces}
    tolerance_m = TOLERANCE_M.get(name, TEXT_TOLERANCE_M)
    for face in result.faces:
        given = np.concatenate(face.rings_m)
        found = np.concatenate(surface.faces[face.id])
        gaps = np.linalg.norm(found[:, None] - given[None], axis=-1)
        assert gaps.min(axis=0).max() < tolerance_m
        # Further corners may lie on edges, for the neighbours' sake, but none off the plane.
        assert np.abs((found - given[0]) @ face.normal).max() < tolerance_m


HOSTILE = ["a b", "a_b", "\"<&>'", "]]>", "endsolid vertex", "ü\u202e", "a\x00\nb", "indoorfit.scene", "x"]


def hostile(result: FitResult, longest: int) -> FitResult:
    """The same model with ids that no format likes."""
    ids = [*HOSTILE[:-1], longest * "x"]
    names = {face.id: f"{ids[k % len(ids)]}{k}" for k, face in enumerate(result.faces)}
    rooms = {room.id: f"{ids[-k - 1]}r" for k, room in enumerate(result.rooms)}
    return replace(
        result,
        rooms=tuple(replace(room, id=rooms[room.id]) for room in result.rooms),
        faces=tuple(replace(face, id=names[face.id], room=rooms[face.room]) for face in result.faces),
        meshes=tuple(
            replace(mesh, room=rooms[mesh.room], face_ids=tuple(names[face] for face in mesh.face_ids))
            for mesh in result.meshes
        ),
        dimensions=tuple(
            replace(
                d,
                id=f'{d.id} <> %%c {{\\P"',
                room=rooms[d.room],
                faces=(names[d.faces[0]], names[d.faces[1]]),
                wall=None if d.wall is None else names[d.wall],
            )
            for d in result.dimensions
        ),
    )


@pytest.mark.parametrize("name", [*NAMES, "dxf", "pdf", "svg", "csv"])
def test_ids_cannot_break_a_format(name, tmp_path):
    # Paper ends somewhere.
    longest = 40 if name in ("pdf", "svg") else 400
    result = hostile(make_result(*FLAT), longest)
    path = written(name, result, tmp_path)
    # VTK cannot read quotes within texts, which VRML97 allows (5.8).
    if name in NAMES and name != "vrml":
        surface = read_surface(name, path, result.frame.R_manhattan_scan)
        assert len(surface.faces) == len(result.faces)
        assert len(surface.rooms) == len(result.rooms)
    else:
        assert path.stat().st_size > 0


@pytest.mark.parametrize("name", FORMATS)
def test_files_are_the_same_bytes_every_time(name, tmp_path):
    contents = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        contents.append(written(name, make_result(*FLAT), folder).read_bytes())
    assert contents[0] == contents[1]


@pytest.mark.parametrize("name", FORMATS)
def test_an_unwritable_target_is_the_users_error_and_leaves_nothing(name, tmp_path):
    for place in (tmp_path / "missing" / "model", tmp_path):
        with pytest.raises(OutputError, match="Fix:"):
            FORMATS[name].write(place, make_result(BOX), None)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["glb", "obj", "ply", "stl", "3mf", "dae"])
def test_trimesh_opens_it_with_the_same_volume(name, tmp_path):
    result = make_result(L_ROOM, frame=FRAMES["plain"])
    mesh = trimesh.load_scene(written(name, result, tmp_path)).to_mesh()
    joined = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    joined.merge_vertices(digits_vertex=5)
    assert joined.is_watertight
    # trimesh reads 3MF and COLLADA in their own units; metres are what both files say.
    assert abs(joined.volume) == pytest.approx(plan_area_m2(L_ROOM) * 2.7, rel=1e-6)


def test_names_stay_different_where_only_forbidden_letters_differ(tmp_path):
    result = make_result(BOX)
    names = dict(
        zip([face.id for face in result.faces], ["a b", "a_b", "a.b", "a\tb", "_a_b", "a'b"], strict=True)
    )
    result = replace(
        result,
        faces=tuple(replace(face, id=names[face.id]) for face in result.faces),
        meshes=tuple(replace(m, face_ids=tuple(names[face] for face in m.face_ids)) for m in result.meshes),
        dimensions=(),
    )
    assert len(read_back("obj", result, tmp_path).faces) == 6
    found = re.findall(r"DEF (\S+) Shape", written("vrml", result, tmp_path).read_text())
    assert len(set(found)) == 6
    assert not any("." in name for name in found)


def test_obj_names_a_material_file_without_spaces(tmp_path):
    FORMATS["obj"].write(tmp_path / "my room.obj", make_result(BOX), None)
    (line,) = re.findall(r"^mtllib (.*)$", (tmp_path / "my room.obj").read_text(), re.M)
    assert (tmp_path / line).is_file()
    assert " " not in line
