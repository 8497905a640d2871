"""Every kind of length can be measured by tape: also steps, widths of platforms and thicknesses of walls."""

import numpy as np
import pytest

from indoorfit.evaluate import check_tape
from indoorfit.io import read_tape
from indoorfit.pipeline import fit_scan
from indoorfit.report import tape_template
from indoorfit.simulate import (
    Opening,
    RoomPlan,
    ScanSettings,
    Scene,
    Step,
    load_sensor,
    regime,
    stations,
    virtual_scan,
)

KINDS = ["overall", "height", "wall", "step", "width", "thickness"]
PLATFORM_M, RISE_M, WALL_M = 1.5, 0.2, 0.15


@pytest.fixture(scope="module")
def model():
    rooms = tuple(
        RoomPlan((x, x + 3.5), (0.0, 4.0), ("#",), 0.0, 2.6 + 0.1 * k)
        for k, x in enumerate((0.0, 3.5 + WALL_M))
    )
    platform = Step(0, "floor", (0.0, 0.0), (PLATFORM_M, 4.0), RISE_M)
    door = Opening("door", "x", (3.5 + 0.5 * WALL_M, 2.0), 0.9, 0.0, 2.05)
    scene = Scene(rooms, steps=(platform,), openings=(door,))
    rng = np.random.default_rng(3)
    settings = ScanSettings(pixel_step=8, n_threads=1, yaw_rad=0.3)
    virtual = virtual_scan(scene, load_sensor("tls"), stations(scene, 4, rng), regime("0"), rng, settings)
    return fit_scan(virtual.scan)


def written(tmp_path, *rows):
    """Read from a file, as a user's readings are."""
    header = "dimension,face_1,face_2,x1_m,y1_m,z1_m,x2_m,y2_m,z2_m,value,unit,instrument"
    (tmp_path / "tape.csv").write_text("\n".join((header, *rows)) + "\n", encoding="utf-8")
    return read_tape(tmp_path / "tape.csv")


@pytest.mark.parametrize("way", ["id", "faces", "points"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_reading_of_any_kind_finds_its_length(model, kind, way, tmp_path):
    own = [d for d in model.dimensions if d.kind == kind]
    assert own
    for d in own:
        points = ",".join(f"{x:.3f}" for x in (*d.from_m, *d.to_m))
        what = {"id": f"{d.id},,,,,,,,", "faces": f",{','.join(d.faces)},,,,,,", "points": f",,,{points}"}[
            way
        ]
        tape = written(tmp_path, f"{what},{100 * (d.quantity.value + 0.003):.4f},cm,laser")
        verdict = check_tape(model, tape)
        assert verdict.refused == ()
        (check,) = verdict.checks
        found = next(x for x in model.dimensions if x.id == check.dimension)
        # Two lengths between the same planes are one.
        assert {model.face(f).plane for f in found.faces} == {model.face(f).plane for f in d.faces}
        assert check.deviation_m == pytest.approx(-0.003, abs=1e-5)


def test_readings_of_the_truth_agree(model, tmp_path):
    true_m = {"step": RISE_M, "thickness": WALL_M}
    rows = [
        f"{d.id},,,,,,,,,{1e3 * true_m[d.kind]:.1f},mm,laser" for d in model.dimensions if d.kind in true_m
    ]
    verdict = check_tape(model, written(tmp_path, *rows))
    assert len(verdict.checks) == len(rows) >= 2
    assert all(check.e_n <= 1.0 for check in verdict.checks)


def test_the_template_has_every_kind(model):
    ids = [row.split(",")[0] for row in tape_template(model).splitlines()[1:]]
    assert {d.kind for d in model.dimensions if d.id in ids} >= set(KINDS) - {"wall"}
