"""The six classes of the thesis' table 3-1, and the rule of heights."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.classify import ClassifyConfig, classify
from indoorfit.model import Plane, Segments


def segments_of(rows) -> Segments:
    """Rows of (normal, centre, area)."""
    normals = np.array([row[0] for row in rows], float)
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    centres = np.array([row[1] for row in rows], float)
    areas = np.array([row[2] for row in rows], float)
    zeros = np.zeros(len(rows))
    return Segments(np.zeros(0, int), normals, zeros, centres, areas, zeros)


ROOM = [
    ((-1, 0, 0), (-2.5, 0, 0), 10),
    ((1, 0, 0), (2.5, 0, 0), 10),
    ((0, -1, 0), (0, -2, 0), 13),
    ((0, 1, 0), (0, 2, 0), 13),
    ((0, 0, -1), (0, 0, -1.3), 20),
    ((0, 0, 1), (0, 0, 1.4), 20),
]
NAMES = ("left", "right", "back", "front", "floor", "ceiling")


def test_six_faces_get_their_names():
    assert classify(segments_of(ROOM), ClassifyConfig()) == NAMES


def test_names_agree_with_those_of_planes():
    named = [Plane(axis, outward, 0.0).face_class for axis in range(3) for outward in (-1, 1)]
    assert tuple(named) == NAMES


def test_a_table_in_a_room_without_ceiling_is_neither_floor_nor_ceiling():
    without = [*ROOM[:5], ((0, 0, 1), (0, 0, -0.55), 3)]
    assert classify(segments_of(without), ClassifyConfig()) == (*NAMES[:5], None)


@pytest.mark.parametrize("hidden_m", [0.0, 1.3, 1.8])
def test_a_ceiling_stays_one_where_furniture_hides_the_lower_half_of_the_walls(hidden_m):
    middle_m = -1.3 + 0.5 * (hidden_m + 2.7)
    walls = [(normal, (x, y, middle_m), area) for normal, (x, y, _), area in ROOM[:4]]
    assert classify(segments_of([*walls, *ROOM[4:]]), ClassifyConfig()) == NAMES


@given(order=st.permutations(range(6)))
def test_order_of_segments_does_not_matter(order):
    found = classify(segments_of([ROOM[k] for k in order]), ClassifyConfig())
    assert found == tuple(NAMES[k] for k in order)


@pytest.mark.parametrize(
    ("angle_deg", "expected"),
    [(0, "right"), (10, "right"), (13, None), (45, None), (77, None), (80, "front")],
)
def test_table_3_1_bounds_the_components(angle_deg, expected):
    """Beyond arcsin 0.2 = 11.5 degrees a wall is oblique and has no class."""
    angle = np.deg2rad(angle_deg)
    rows = [*ROOM, ((np.cos(angle), np.sin(angle), 0), (2, 1, 0), 3)]
    assert classify(segments_of(rows), ClassifyConfig())[6] == expected


@pytest.mark.parametrize(
    ("height_m", "expected"),
    [(-1.3, "floor"), (-1.0, "floor"), (-0.55, None), (0.3, None), (0.7, "ceiling"), (1.4, "ceiling")],
    ids=["floor", "platform", "table", "shelf", "dropped-ceiling", "ceiling"],
)
@pytest.mark.parametrize("up", [-1, 1])
def test_height_tells_floor_and_ceiling_from_furniture_whatever_the_normal(height_m, expected, up):
    rows = [*ROOM, ((0, 0, up), (1, 1, height_m), 1.5)]
    assert classify(segments_of(rows), ClassifyConfig())[6] == expected


def test_a_speck_below_the_floor_does_not_move_it():
    rows = [*ROOM, ((0, 0, 1), (0, 0, -4.0), 0.1)]
    assert classify(segments_of(rows), ClassifyConfig())[4] == "floor"


def test_no_segments_no_classes():
    rows, numbers = np.zeros((0, 3)), np.zeros(0)
    none = Segments(np.full(3, -1), rows, numbers, rows, numbers, numbers)
    assert classify(none, ClassifyConfig()) == ()
