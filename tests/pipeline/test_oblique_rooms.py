"""Rooms with a wall across a corner, from the scan to the files."""

from functools import cache

import numpy as np
import pytest

from indoorfit.config import RunConfig
from indoorfit.evaluate import compare
from indoorfit.io import read_model_json, write_model_json
from indoorfit.model import FitResult
from indoorfit.pipeline import explain_scan, fit_scan, truth_result
from indoorfit.report import explain_picture, plan_svg
from indoorfit.simulate import (
    Furniture,
    ObliqueWall,
    Registration,
    RoomPlan,
    ScanSettings,
    Scene,
    VirtualScan,
    handheld_path,
    load_sensor,
    virtual_scan,
)

BOX = RoomPlan((0.0, 5.0), (0.0, 4.0), ("#",), 0.0, 2.6)
L_ROOM = RoomPlan((0.0, 3.0, 5.5), (0.0, 2.5, 4.5), ("#.", "##"), 0.0, 2.6)
SCENES = {
    "corner": Scene((BOX,), oblique_walls=(ObliqueWall(0, (3.8, 0.0), (5.0, 0.9)),)),
    "two corners": Scene(
        (BOX,), oblique_walls=(ObliqueWall(0, (3.9, 0.0), (5.0, 1.1)), ObliqueWall(0, (0.0, 1.2), (0.8, 0.0)))
    ),
    # One end of the room is not square: no wall of the other two directions is left there.
    "end": Scene((BOX,), oblique_walls=(ObliqueWall(0, (5.0, 0.0), (4.1, 4.0)),)),
    # As little askew as a wall of the two directions may be by its class: ten degrees.
    "askew": Scene((BOX,), oblique_walls=(ObliqueWall(0, (5.0, 0.0), (4.3, 4.0)),)),
    # The inner corner of the L, which stands in the room.
    "edge": Scene((L_ROOM,), oblique_walls=(ObliqueWall(0, (3.9, 2.5), (3.0, 3.4)),)),
    # A screen of 2 m before a corner: seen as well as a wall, but no wall.
    "screen": Scene(
        (BOX,), furniture=(Furniture("box", (4.2, 0.8), (1.8, 0.05, 2.0), 0.0, float(np.radians(45.0))),)
    ),
}


@cache
def scanned(name: str) -> VirtualScan:
    rng = np.random.default_rng(3)
    path = handheld_path(SCENES[name], 50, rng, "walk")
    settings = ScanSettings(pixel_step=10, frame_ids=False, sensor_poses=False, yaw_rad=0.3, tilt_rad=0.02)
    registration = Registration(rms_m=0.003)
    return virtual_scan(SCENES[name], load_sensor("kinect_v1"), path, registration, rng, settings)


@cache
def fitted(name: str) -> FitResult:
    return fit_scan(scanned(name).scan, RunConfig())


def truth_of(name: str) -> FitResult:
    return truth_result(scanned(name).shape, scanned(name).frame, {}, 0)


@pytest.mark.parametrize("name", SCENES)
def test_the_room_is_found_with_its_oblique_walls_and_no_other(name):
    verdict = compare(fitted(name), truth_of(name))
    assert verdict.right, verdict.faults
    assert fitted(name).converged


@pytest.mark.parametrize("name", ["corner", "two corners", "end", "edge"])
def test_lengths_at_oblique_corners_lie_in_their_intervals(name):
    checks = compare(fitted(name), truth_of(name)).lengths
    # Of a dozen intervals at 95 % two may miss: more have a chance of 2 %.
    assert sum(not check.hit for check in checks) <= 2
    # Drift of 3 mm; an oblique corner moves by its error over the sine of the angle between the walls.
    assert max(abs(check.error_m) for check in checks) < 0.04


def test_the_document_holds_the_oblique_wall(tmp_path):
    write_model_json(tmp_path / "model.json", fitted("edge"))
    read = read_model_json(tmp_path / "model.json")
    assert read.shape == fitted("edge").shape
    assert read.shape.oblique
    lengths = [(d.id, d.wall, d.quantity.value) for d in fitted("edge").dimensions]
    assert [(d.id, d.wall, d.quantity.value) for d in read.dimensions] == lengths


def test_the_plan_shows_the_oblique_wall_and_its_length():
    result = fitted("corner")
    (face,) = (face for face in result.faces if result.shape.planes[face.plane].oblique)
    (length,) = (d for d in result.dimensions if d.wall == face.id)
    drawing = plan_svg(result)
    assert f"{face.id}  {length.id}  {length.quantity.value:.2f}"[:-1] in drawing


def test_the_explanation_ends_the_room_at_the_oblique_wall_and_names_it():
    scan = scanned("corner").scan
    explained = explain_scan(scan)
    items = explain_picture(explained.explanation, explained.frame, scan.points_m).items
    assert sum(getattr(item, "text", "") == "o1" for item in items) == 1
    # The boldest strokes are the outline: all but those of the legend close it.
    bold = [item for item in items if getattr(item, "width", 0.0) == 4.5][1:]
    ends = np.round(np.concatenate([item.points for item in bold]), 3)
    assert all(count % 2 == 0 for count in np.unique(ends, axis=0, return_counts=True)[1])
