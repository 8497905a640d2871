"""The thesis' procedure finds simulated rooms; what it cannot know it says."""

from dataclasses import replace

import numpy as np
import pytest
from greedy_rooms import N_POINTS, SIGMA_M, assert_same_rooms, front_end, preset, scan_of, scanned

from indoorfit.errors import InputError
from indoorfit.model import Scan
from indoorfit.simulate import Box, room_shape
from indoorfit.simulate.presets import plan_minus_rectangles

# Statistical. A wall of w x 2.7 m with its points' normal free has at its end an error of 2 sigma / sqrt(n)
# (mean and slope). The presets' smallest wall, 0.33 x 2.7 m, gets about n = 700 of 60 000 points and lies
# 2 half-widths from the far intersection at most: 0.4 mm x 2; a dimension has two walls; four standard
# errors of both, and as much again for points of the neighbouring wall that a segment takes in at its edge.
ATOL_M = 2 * 4 * np.sqrt(2) * 4 * SIGMA_M / np.sqrt(N_POINTS / 85)

KINDS = ["box", "L", "U", "X", "T", "Z", "stair"]


@pytest.mark.parametrize("kind", KINDS)
def test_greedy_recovers_structure_and_dimensions(kind):
    shape, front = preset(kind)
    fit = front.fit()
    assert fit.converged
    assert fit.notes == ()
    assert_same_rooms(fit.shape, shape, ATOL_M)


def test_greedy_makes_the_nested_cubes_of_a_stair():
    _, front = preset("stair")
    cubes = front.fit().shape.cubes
    assert [cube.role for cube in cubes] == ["room", "notch", "part", "notch"]
    assert [cube.parent for cube in cubes] == [None, "cube-0", "cube-1", "cube-2"]


def test_greedy_recovers_a_free_standing_pillar():
    shape = plan_minus_rectangles(5.0, 4.0, 2.7, [(2.0, 2.6, 1.5, 2.2)])
    fit = front_end(scanned(shape), np.eye(3)).fit()
    assert [cube.role for cube in fit.shape.cubes] == ["room", "pillar"]
    assert_same_rooms(fit.shape, shape, ATOL_M)


def test_greedy_sets_low_furniture_aside():
    shape = room_shape("U")
    box = Box((1.0, 1.0, 0.0), (1.8, 1.6, 1.2))
    fit = front_end(scanned(shape, furniture=(box,)), np.eye(3)).fit()
    assert any(step.action == "set aside" for step in fit.steps)
    assert_same_rooms(fit.shape, shape, ATOL_M)


def test_greedy_places_a_wall_without_points_at_the_outermost_point_and_says_so():
    shape = room_shape("box")
    right = next(k for k, plane in enumerate(shape.planes) if plane.face_class == "right")
    fit = front_end(scanned(shape, missing_planes=(right,)), np.eye(3)).fit()
    assert [note.code for note in fit.notes] == ["GREEDY_FACE_INFERRED"]
    assert [plane.face_class for plane in fit.shape.planes if plane.status == "inferred"] == ["right"]
    # The last of the 60 000 points before the wall: floor and ceiling hold one per 1.4 cm² or so; noise runs
    # along the wall's normal only, so what remains is the spacing of segments' last points, a voxel.
    assert_same_rooms(fit.shape, shape, 0.06)


def test_greedy_turns_with_the_scan():
    _, front = preset("X")
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = front_end(Scan(front.scan.points_m @ turn.T), np.eye(3)).fit()
    # Voxels fall differently, hence segments and RANSAC draws; both fits are within ATOL_M of the truth.
    expected = front_end(front.scan, turn).fit()
    assert_same_rooms(turned.shape, expected.shape, 2 * ATOL_M)


def test_greedy_does_not_depend_on_the_order_of_the_points():
    _, front = preset("stair")
    order = np.random.default_rng(1).permutation(front.scan.n_points)
    shuffled = front_end(Scan(front.scan.points_m[order]), np.eye(3)).fit()
    fit = front.fit()
    assert [cube.sides for cube in shuffled.shape.cubes] == [cube.sides for cube in fit.shape.cubes]
    assert_same_rooms(shuffled.shape, fit.shape, 2 * ATOL_M)


def test_greedy_repeats_itself_bit_by_bit_with_the_same_seed():
    _, front = preset("T")
    np.testing.assert_array_equal(front.fit(seed=3).shape.offsets_m, front.fit(seed=3).shape.offsets_m)


def test_greedy_records_the_steps_of_the_thesis():
    shape, front = preset("U")
    steps = front.fit().steps
    assert [step.section for step in steps[:2]] == ["3.2.2", "3.2.4"]
    notch = next(step for step in steps if step.action == "cube")
    # Two intersection points along x: x scale from their distance, y infinite (3.2.5).
    assert len(notch.corners_m) == 2
    assert np.isinf(notch.bounds_m[1, 1])
    assert notch.bounds_m[1, 0] - notch.bounds_m[0, 0] == pytest.approx(1.6, abs=ATOL_M)
    # Free normals: hardly tilted at 0.5 cm of noise, but not exactly on the axes.
    tilts_rad = [plane.tilt_rad for plane in notch.planes]
    assert len(tilts_rad) == 3
    assert all(0.0 < tilt < np.deg2rad(1.0) for tilt in tilts_rad)
    assert len(shape.cubes) == 2


def test_greedy_removes_the_remaining_rotation_of_the_start_frame():
    shape = room_shape("L")
    virtual = scan_of(shape, yaw_rad=0.03, tilt_rad=0.02)
    fit = front_end(virtual.scan, np.eye(3)).fit()
    # Statistical: a wall of 5 m fixes an angle to 0.5 cm / sqrt(10 000) / 1.5 m = 0.03 mrad; ten times that.
    truth = virtual.frame.R_manhattan_scan
    np.testing.assert_allclose(fit.frame.R_manhattan_scan @ truth.T, np.eye(3), rtol=0.0, atol=3e-4)


def test_greedy_refuses_a_scan_without_walls():
    _, front = preset("box")
    classes = tuple(name if name in ("floor", "ceiling") else None for name in front.classes)
    with pytest.raises(InputError, match="wall along"):
        replace(front, classes=classes).fit()


def test_greedy_refuses_a_scan_without_floor_and_ceiling():
    _, front = preset("box")
    classes = tuple(None if name in ("floor", "ceiling") else name for name in front.classes)
    with pytest.raises(InputError, match="floor or ceiling"):
        replace(front, classes=classes).fit()


def test_greedy_leaves_single_planes_unused_and_notes_them():
    shape, front = preset("L")
    # Without the short wall of the notch one plane remains: no intersection point, no cube (3.2.5).
    areas_m2 = front.segments.areas_m2
    front_walls = [k for k, name in enumerate(front.classes) if name == "front" and areas_m2[k] > 0.2]
    short = min(front_walls, key=lambda k: areas_m2[k])
    classes = tuple(None if k == short else name for k, name in enumerate(front.classes))
    fit = replace(front, classes=classes).fit()
    assert [note.code for note in fit.notes] == ["GREEDY_WALLS_UNUSED"]
    assert len(fit.shape.cubes) == 1 < len(shape.cubes)
