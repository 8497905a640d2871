"""The meshes of a model that was read back are those that it had when it was written."""

import json

import numpy as np
import pytest

from indoorfit.errors import InputError
from indoorfit.io import read_model_json, write_model_json
from indoorfit.pipeline import with_meshes
from synthetic import KINDS, truth_of, virtual


@pytest.mark.parametrize("kind", KINDS)
def test_meshes_follow_from_the_file(kind, tmp_path):
    truth = truth_of(virtual(kind, 1, n_points=1000, yaw_deg=20, tilt_deg=3))
    write_model_json(tmp_path / "model.json", truth)
    found = with_meshes(read_model_json(tmp_path / "model.json"))
    for mesh, before in zip(found.meshes, truth.meshes, strict=True):
        assert mesh.room == before.room
        np.testing.assert_array_equal(mesh.triangles, before.triangles)
        np.testing.assert_array_equal(mesh.vertices_m, before.vertices_m)
        assert mesh.face_ids == before.face_ids


def spoil_corner(document):
    document["faces"][0]["rings"][0][0][0] += 0.01


def spoil_face(document):
    document["faces"].append({**document["faces"][0], "id": "wall-99"})


def spoil_cube(document):
    document["rooms"][0]["cube"] = document["cubes"][1]["id"]


def spoil_plane(document):
    # The room's own far side before its near side: the box is inside out.
    side = document["cubes"][0]["sides"]["+x"]
    document["planes"][side]["offset"] = -100.0


@pytest.mark.parametrize("spoil", [spoil_corner, spoil_face, spoil_cube, spoil_plane])
def test_a_file_that_contradicts_itself_is_refused(spoil, tmp_path):
    path = tmp_path / "model.json"
    write_model_json(path, truth_of(virtual("L", 1, n_points=1000)))
    document = json.loads(path.read_text(encoding="utf-8"))
    spoil(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(InputError, match=r"mine\.json: .*Fix:"):
        with_meshes(read_model_json(path), "mine.json")
