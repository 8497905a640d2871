"""Real scans, where they are at hand; the figures are robust fits to the full clouds, not tape measures."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from indoorfit.errors import InputError
from indoorfit.io import read_scan
from indoorfit.pipeline import fit_scan

FOLDER = Path(os.environ.get("INDOORFIT_REAL_SCANS", Path(__file__).parents[3] / "shared" / "data"))


def fitted(name: str):
    path = FOLDER / name
    if not path.is_file():
        pytest.skip(f"{name} is not at hand; set INDOORFIT_REAL_SCANS to the folder that holds it")
    return fit_scan(read_scan(path))


def test_boiler_room_has_its_width_length_and_both_heights():
    result = fitted("boiler_room_tls_2cm.ply")
    assert result.converged
    sides = sorted(d.quantity.value for d in result.dimensions[:2])
    # Requirement: 2 cm. The walls themselves are out of parallel by 1 to 2 cm.
    assert sides == pytest.approx([3.867, 5.668], abs=0.02)
    heights = [d.quantity.value for d in result.dimensions if d.kind == "height"]
    assert heights == pytest.approx([3.483, 3.006], abs=0.02)


def test_two_rooms_are_told_apart_and_the_larger_is_right():
    result = fitted("two_rooms_tls_sparse.ply")
    assert result.converged
    sides = sorted(d.quantity.value for d in result.dimensions[:2])
    # Requirement: 5 cm.
    assert sides == pytest.approx([6.975, 10.643], abs=0.05)
    if len(result.rooms) > 1:
        second = [d for d in result.dimensions if d.room == "room-2"][:2]
        assert sorted(d.quantity.value for d in second) == pytest.approx([4.080, 8.801], abs=0.05)


@pytest.mark.parametrize(
    "name",
    [
        "oblique_hall_tls_3cm.ply",
        "office_corner_depth.ply",
        "office_floor_tls_sparse.ply",
        "room_scan1.pcd",
        "room_scan2.pcd",
    ],
)
def test_every_other_scan_ends_with_a_model_or_a_clear_refusal(name, tmp_path):
    path = FOLDER / name
    if not path.is_file():
        pytest.skip(f"{name} is not at hand; set INDOORFIT_REAL_SCANS to the folder that holds it")
    command = [sys.executable, "-m", "indoorfit", "fit", str(path), "--out", str(tmp_path / "out")]
    # A process of its own can be stopped: the largest takes 5 s, a minute means that it does not end.
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode in (0, 1, 3)
    assert "Traceback" not in done.stderr
    if done.returncode == 1:
        assert "Fix:" in done.stderr
        assert list(tmp_path.iterdir()) == []
    else:
        document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
        assert all(dimension["value"] > 0 for dimension in document["dimensions"])
        assert all(room["volume"]["value"] > 0 for room in document["rooms"])


def test_a_hall_with_oblique_walls_is_told_apart():
    try:
        result = fitted("oblique_hall_tls_3cm.ply")
    except InputError:
        return
    assert {"OBLIQUE_WALLS", "SLOPED_CEILING"} & {note.code for note in result.notes}


def test_an_open_end_is_inferred_and_missing_colours_are_said():
    result = fitted("room_scan1.pcd")
    codes = [note.code for note in result.notes]
    assert "COLOURS_MISSING" in codes
    assert "FACE_INFERRED" in codes
