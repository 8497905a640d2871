"""Where somebody with a sensor can walk."""

import numpy as np

from indoorfit.simulate import ObliqueWall, Opening, RoomPlan, Scene, handheld_path

ROOMS = (
    RoomPlan((0.0, 4.0), (0.0, 3.0), ("#",), 0.0, 2.5),
    RoomPlan((4.1, 8.0), (0.0, 3.0), ("#",), 0.0, 2.5),
)
DOOR = Opening("door", "x", (4.05, 2.2), 0.9, 0.0, 2.05)
CORNER = ObliqueWall(0, (3.0, 0.0), (4.0, 1.0))


def test_an_oblique_wall_closes_its_own_corner_and_no_other_room():
    scene = Scene(ROOMS, openings=(DOOR,), oblique_walls=(CORNER,))
    path = handheld_path(scene, 80, np.random.default_rng(0), "walk")
    places = np.array([pose.position_m for pose in path])
    assert (places[:, 0] < 4.0).any()
    # Behind the wall's line, but in the next room.
    assert ((places[:, 0] > 4.1) & (places[:, 0] - places[:, 1] > 3.0)).any()
    inside = places[:, 0] < 4.0
    assert (places[inside, 0] - places[inside, 1] < 3.0).all()
