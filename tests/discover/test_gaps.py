"""A hole in a room is told from what lies outside of it."""

import numpy as np
import pytest

from indoorfit.discover.evidence import Evidence
from indoorfit.discover.gaps import enclosed


def room_with_hole() -> Evidence:
    """Seven by seven cells: a room of five by five with walls around it, seen but for its middle."""
    ceiling = np.zeros((7, 7))
    ceiling[1:6, 1:6] = 1.0
    ceiling[3, 3] = 0.0
    walls = np.zeros((8, 7)), np.zeros((7, 8))
    walls[0][[1, 6], 1:6] = 1.0
    walls[1][1:6, [1, 6]] = 1.0
    return Evidence(ceiling, ceiling.copy(), np.full((7, 7), 2.5), walls, walls)


def test_a_hole_in_a_room_is_enclosed_and_what_is_outside_is_not():
    found = enclosed(room_with_hole())
    assert found[1:6, 1:6].all()
    assert found.sum() == 25


def test_a_pillar_is_no_hole():
    evidence = room_with_hole()
    evidence.walls[0][[3, 4], 3] = 1.0
    evidence.walls[1][3, [3, 4]] = 1.0
    assert not enclosed(evidence)[3, 3]


@pytest.mark.parametrize("turns", range(4))
def test_a_room_that_nobody_saw_the_end_of_is_not_enclosed_there(turns):
    evidence = room_with_hole()
    # Beyond the last row that was seen there is neither wall nor floor.
    for surface in (evidence.ceiling, evidence.floor):
        surface[4:, :] = 0.0
    evidence.walls[0][6] = 0.0
    ceiling, floor = (np.rot90(surface, turns) for surface in (evidence.ceiling, evidence.floor))
    walls = [np.rot90(wall, turns) for wall in evidence.walls]
    if turns % 2:
        walls.reverse()
    borders = walls[0], walls[1]
    found = enclosed(Evidence(ceiling, floor, evidence.top_m, borders, borders))
    assert not np.rot90(found, -turns)[4:].any()
