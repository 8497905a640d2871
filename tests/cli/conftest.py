"""Files that the command line is tried on."""

import numpy as np
import pytest

from indoorfit.io import write_ply
from synthetic import virtual


@pytest.fixture(scope="session")
def room_ply(tmp_path_factory):
    """A coloured scan of a box, as users have it."""
    path = tmp_path_factory.mktemp("scans") / "room.ply"
    write_ply(path, virtual("box", 1, coloured=True, n_points=8000, yaw_deg=20, tilt_deg=2).scan)
    return path


@pytest.fixture
def xyz(tmp_path):
    """Write points as text and return the path, in a directory of its own."""

    def write(points, name: str = "scan.xyz"):
        folder = tmp_path / "scans"
        folder.mkdir(exist_ok=True)
        path = folder / name
        np.savetxt(path, points, fmt="%.9g")
        return path

    return write
