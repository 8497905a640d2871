"""The truth of a simulated scan: in the contract, and honest about what the scan shows."""

import json

import jsonschema
import numpy as np
import pytest

from indoorfit.io import SCHEMA_PATH, to_document
from indoorfit.pipeline import truth_result
from indoorfit.simulate import (
    Furniture,
    ObliqueWall,
    Opening,
    RandomSceneSettings,
    RoomPlan,
    SamplingSettings,
    ScanSettings,
    Scene,
    handheld_path,
    load_sensor,
    random_scene,
    regime,
    room_shape,
    sample_surface,
    stations,
    virtual_scan,
)

BOX = RoomPlan((0.0, 5.0), (0.0, 4.0), ("#",), 0.0, 2.7)
KINDS = {
    "nested": {"n_walls": 12},
    "step": {"floor_step": True},
    "beam": {"beam": True},
    "step-and-beam": {"floor_step": True, "beam": True, "n_walls": 10},
    "rooms": {"n_rooms": 3},
    "glass": {"glass_wall": True},
    "oblique": {"oblique": True},
    "uneven": {"uneven_m": 0.01},
}


def scanned(scene, sensor="tls", step=16, seed=0):
    rng = np.random.default_rng(seed)
    used = load_sensor(sensor)
    path = stations(scene, 2, rng) if used.kind == "scanner" else handheld_path(scene, 40, rng)
    return virtual_scan(scene, used, path, regime("0"), rng, ScanSettings(pixel_step=step, yaw_rad=0.4))


def truth_of(virtual):
    return truth_result(virtual.shape, virtual.frame, {}, 0, virtual)


@pytest.mark.parametrize("settings", KINDS.values(), ids=KINDS.keys())
def test_truth_of_every_kind_of_scene_is_in_the_contract(settings):
    scene = random_scene(np.random.default_rng(3), RandomSceneSettings(**settings))
    truth = truth_of(scanned(scene))
    jsonschema.validate(to_document(truth), json.loads(SCHEMA_PATH.read_text(encoding="utf-8")))
    ids = [face.id for face in truth.faces]
    assert len(set(ids)) == len(ids)
    for dimension in truth.dimensions:
        assert set(dimension.faces) <= set(ids)
        assert dimension.quantity.std == 0.0
    for mesh in truth.meshes:
        assert set(mesh.face_ids) <= set(ids)
    # A face belongs to a plane that was seen, or says that it was not.
    for face in truth.faces:
        assert (face.n_points > 0) == (face.status == "observed")


def test_wall_of_glass_is_inferred_and_so_are_its_lengths():
    glass = Opening("window", "x", (5.0, 2.0), 4.0, 0.0, 2.7, view_m=None, glazed=True, reach_m=0.02)
    truth = truth_of(scanned(Scene((BOX,), openings=(glass,))))
    inferred = [face for face in truth.faces if face.status == "inferred"]
    assert [face.face_class for face in inferred] == ["right"]
    assert inferred[0].coverage == 0.0
    lengths = {d.kind: d.status for d in truth.dimensions if inferred[0].id in d.faces}
    assert set(lengths.values()) == {"inferred"}
    assert [note.code for note in truth.notes] == ["FACE_INFERRED"]
    assert inferred[0].id in truth.notes[0].message


def test_coverage_is_the_share_of_a_wall_that_is_not_hidden():
    # A shelf of 2.5 x 2.2 m against a wall of 5.0 x 2.7 m: 41 % of it cannot be seen from anywhere.
    shelf = Furniture("box", (2.5, 0.17), (2.5, 0.32, 2.2))
    bare, hidden = (truth_of(scanned(Scene((BOX,), furniture=f), "tls", 8)) for f in ((), (shelf,)))
    coverage = {
        name: next(face.coverage for face in truth.faces if face.face_class == "back")
        for name, truth in (("bare", bare), ("hidden", hidden))
    }
    assert coverage["bare"] == 1.0
    visible = 1.0 - 2.5 * 2.2 / (5.0 * 2.7)
    # The shelf's shadow is somewhat larger than the shelf, and points speak for 5 cm around them.
    assert visible - 0.15 < coverage["hidden"] < visible + 0.05


def test_sampled_preset_counts_its_points():
    shape = room_shape("L")
    settings = SamplingSettings(n_points=20_000, sigma_m=0.004, missing_planes=(1,), outlier_share=0.01)
    virtual = sample_surface(shape, settings, np.random.default_rng(0))
    truth = truth_of(virtual)
    assert truth.shape.planes[1].status == "inferred"
    # Five sigmas leave out a few points of ten million.
    assert sum(face.n_points for face in truth.faces) == (virtual.point_plane >= 0).sum()
    seen = [face for face in truth.faces if face.plane != 1]
    assert min(face.coverage for face in seen) > 0.99
    # The smallest face has some 300 points: its RMS is known to 4 %, and there are seven faces.
    np.testing.assert_allclose([face.rms_m for face in seen], 0.004, rtol=0.16)


def test_without_a_scan_everything_counts_as_seen():
    virtual = sample_surface(room_shape("U"), SamplingSettings(n_points=100), np.random.default_rng(0))
    truth = truth_result(virtual.shape, virtual.frame, {}, 0)
    assert {face.status for face in truth.faces} == {"observed"}
    assert {face.coverage for face in truth.faces} == {1.0}


def test_oblique_wall_is_a_face_with_its_length():
    scene = Scene((BOX,), oblique_walls=(ObliqueWall(0, (4.0, 0.0), (5.0, 1.0)),))
    virtual = scanned(scene)
    truth = truth_of(virtual)
    (face,) = (face for face in truth.faces if truth.shape.planes[face.plane].oblique)
    (length,) = (d for d in truth.dimensions if d.wall == face.id)
    # The diagonal of a square of 1 m, and half of that square missing from the floor of 5 by 4 m.
    assert length.quantity.value == pytest.approx(np.sqrt(2.0), abs=1e-9)
    box = truth_of(scanned(Scene((BOX,))))
    lost_m2 = box.rooms[0].floor_area.value - truth.rooms[0].floor_area.value
    assert lost_m2 == pytest.approx(0.5, abs=1e-9)
    assert face.status == "observed"
    assert (virtual.point_plane == face.plane).sum() == face.n_points


def test_truth_lies_in_the_frame_of_the_scan():
    virtual = scanned(Scene((BOX,)))
    truth = truth_of(virtual)
    for face in truth.faces:
        on_face = virtual.point_plane == face.plane
        distance_m = (virtual.scan.points_m[on_face] - face.rings_m[0][0]) @ face.normal
        # 1.4 mm of noise along the ray at most 60 degrees off; the mean of hundreds of points.
        assert abs(float(np.mean(distance_m))) < 0.001


def test_doors_between_rooms_are_told_once_and_lie_where_the_scene_has_them():
    scene = random_scene(np.random.default_rng(5), RandomSceneSettings(n_rooms=3, n_doors=1, n_furniture=0))
    virtual = scanned(scene)
    truth = truth_of(virtual)
    joining = [opening for opening in scene.openings if opening.kind == "door"][:2]
    assert [door.rooms for door in truth.adjacency] == [("room-1", "room-2"), ("room-2", "room-3")]
    for door, opening in zip(truth.adjacency, joining, strict=True):
        # Rounding of coordinates of some metres.
        assert door.width_m == pytest.approx(opening.width_m, abs=1e-12)
        assert door.height_m == pytest.approx(opening.top_m - opening.bottom_m, abs=1e-9)
        np.testing.assert_allclose(virtual.frame.to_manhattan(door.sill_m)[:2], opening.centre_m, atol=1e-9)
    # Not every wall was seen from both sides in this scan; the scene as such has two partitions.
    whole = truth_result(virtual.shape, virtual.frame, {}, 0)
    thick = [d.quantity.value for d in whole.dimensions if d.kind == "thickness"]
    gaps = [b.x_lines_m[0] - a.x_lines_m[-1] for a, b in zip(scene.rooms, scene.rooms[1:], strict=False)]
    np.testing.assert_allclose(sorted(thick), sorted(gaps), atol=1e-9)
