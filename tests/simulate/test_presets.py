"""The named rooms have the walls, sizes and areas that their names promise."""

import numpy as np
import pytest

from indoorfit.errors import ConfigError
from indoorfit.geometry import exposures
from indoorfit.simulate import room_shape

WALL_PLANES = {"box": 4, "L": 6, "U": 7, "X": 12, "T": 8, "Z": 8, "stair": 10}
"""Planes, not walls: the two walls beside the U's notch lie in one plane."""


@pytest.mark.parametrize("kind", WALL_PLANES)
def test_room_shape_has_the_walls_of_its_name(kind):
    shape = room_shape(kind)
    assert sum(plane.axis < 2 for plane in shape.planes) == WALL_PLANES[kind]
    assert all(exposure.area_m2 > 0.0 for exposure in exposures(shape))


@pytest.mark.parametrize("kind", WALL_PLANES)
def test_room_surface_closes(kind):
    """Areas facing left and right, front and back, up and down balance on any closed surface."""
    shape = room_shape(kind)
    for axis in range(3):
        areas_m2 = [e.area_m2 * shape.planes[e.plane].outward for e in exposures(shape) if e.axis == axis]
        # 1e-12 m²: rounding of sums of a few numbers of order 10.
        assert sum(areas_m2) == pytest.approx(0.0, abs=1e-12)


def test_thesis_room_has_the_sizes_of_table_6_1():
    shape = room_shape("L")
    low_m, high_m = shape.bounds_m()[shape.rooms[0].id]
    np.testing.assert_allclose(high_m - low_m, (5.08, 3.20, 2.70), atol=1e-12)
    floor = next(e for e in exposures(shape) if shape.planes[e.plane].face_class == "floor")
    assert floor.area_m2 == pytest.approx(5.08 * 3.20 - 0.33 * 1.50, abs=1e-12)


def test_stair_nests_a_cube_in_a_notch():
    roles = [cube.role for cube in room_shape("stair").cubes]
    assert "part" in roles


def test_sizes_are_taken_as_given():
    shape = room_shape("U", length_m=7.5, width_m=5.0, height_m=3.1, notch_length_m=2.0, notch_width_m=1.0)
    low_m, high_m = shape.bounds_m()["cube-0"]
    np.testing.assert_allclose(high_m - low_m, (7.5, 5.0, 3.1), atol=1e-12)
    notch_low_m, notch_high_m = shape.bounds_m()["cube-1"]
    assert notch_high_m[0] - notch_low_m[0] == pytest.approx(2.0, abs=1e-12)
    assert notch_low_m[1] == pytest.approx(4.0, abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "sizes"),
    [
        ("L", {"notch_length_m": 9.0}),
        ("U", {"notch_width_m": 4.0}),
        ("Z", {"notch_length_m": 4.0, "notch_width_m": 3.0}),
        ("X", {"length_m": 2.0}),
        ("L", {"notch_length_m": 0.0}),
        ("box", {"height_m": -1.0}),
        ("igloo", {}),
    ],
    ids=[
        "notch-too-long",
        "notch-cuts-through",
        "notches-meet",
        "cross-too-small",
        "no-notch",
        "negative",
        "name",
    ],
)
def test_impossible_rooms_are_refused_with_a_remedy(kind, sizes):
    with pytest.raises(ConfigError, match="Fix:"):
        room_shape(kind, **sizes)
