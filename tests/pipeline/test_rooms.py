"""Several rooms in one scan: none lost, each with its own planes, walls measured through, doors told."""

import numpy as np
import pytest

from indoorfit.pipeline import fit_scan, truth_result
from indoorfit.simulate import (
    RandomSceneSettings,
    ScanSettings,
    load_sensor,
    random_scene,
    regime,
    stations,
    virtual_scan,
)


@pytest.fixture(scope="module")
def fitted():
    rng = np.random.default_rng(11)
    scene = random_scene(rng, RandomSceneSettings(n_rooms=3, n_furniture=2, n_windows=1, n_doors=0))
    settings = ScanSettings(pixel_step=8, n_threads=1, yaw_rad=0.3)
    virtual = virtual_scan(scene, load_sensor("tls"), stations(scene, 4, rng), regime("0"), rng, settings)
    return fit_scan(virtual.scan), truth_result(virtual.shape, virtual.frame, {}, 0, virtual)


def test_no_room_is_lost_and_each_has_a_floor_and_a_ceiling_of_its_own(fitted):
    model, truth = fitted
    assert len(model.rooms) == len(truth.rooms) == 3
    areas = sorted(room.floor_area.value for room in model.rooms)
    # A wall is at most a centimetre off: of a room of 20 m² that is less than 1 %.
    np.testing.assert_allclose(areas, sorted(room.floor_area.value for room in truth.rooms), rtol=0.01)
    for kind in ("floor", "ceiling"):
        planes = [(face.room, face.plane) for face in model.faces if face.kind == kind]
        assert len({room for room, _ in planes}) == len({plane for _, plane in planes}) == 3


def test_walls_between_rooms_have_their_true_thickness(fitted):
    found, true = (
        sorted((d.quantity for d in result.dimensions if d.kind == "thickness"), key=lambda q: q.value)
        for result in fitted
    )
    assert len(found) == len(true) == 2
    for quantity, exact in zip(found, true, strict=True):
        # Four standard uncertainties.
        assert quantity.value == pytest.approx(exact.value, abs=4 * quantity.std)
        assert quantity.interval.low < quantity.value < quantity.interval.high


def test_every_door_between_two_rooms_is_told(fitted):
    model, truth = fitted
    assert len(model.adjacency) == len(truth.adjacency) == 2
    for door in truth.adjacency:
        nearest = min(model.adjacency, key=lambda other: np.linalg.norm(other.sill_m - door.sill_m))
        # Places and widths are read off cells of 10 cm and the points at their ends.
        assert np.linalg.norm(nearest.sill_m - door.sill_m) < 0.1
        assert nearest.width_m == pytest.approx(door.width_m, abs=0.2)
        assert nearest.height_m == pytest.approx(door.height_m, abs=0.2)
        assert set(nearest.evidence) > {"holes"}
