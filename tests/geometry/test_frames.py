"""Frames carry points there and back, and move directions without their origin."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from indoorfit.model import Frame
from indoorfit.simulate import scan_frame

ANGLES = st.floats(-3.1, 3.1)
OFFSETS = st.tuples(*[st.floats(-1e6, 1e6)] * 3)
POINTS_M = np.random.default_rng(1).uniform(-10, 10, (20, 3))


@given(turn=st.tuples(ANGLES, ANGLES, ANGLES), origin_m=OFFSETS)
def test_points_survive_the_round_trip(turn, origin_m):
    frame = Frame(Rotation.from_rotvec(turn).as_matrix(), np.array(origin_m))
    # Rounding: a coordinate of 1e6 m has a step of 1.2e-10 m, and a few are added.
    np.testing.assert_allclose(frame.to_manhattan(frame.to_scan(POINTS_M)), POINTS_M, atol=2e-9)


@given(turn=st.tuples(ANGLES, ANGLES, ANGLES), origin_m=OFFSETS)
def test_directions_are_differences_of_points(turn, origin_m):
    frame = Frame(Rotation.from_rotvec(turn).as_matrix(), np.array(origin_m))
    difference = frame.to_scan(POINTS_M) - frame.to_scan(np.zeros((1, 3)))
    # Rounding at map coordinates, as above.
    np.testing.assert_allclose(frame.directions_to_scan(POINTS_M), difference, atol=2e-9)


def test_contract_formula_is_what_to_manhattan_computes():
    frame = Frame(Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix(), np.array([3.0, -2.0, 5.0]))
    for point in POINTS_M:
        by_hand = frame.R_manhattan_scan @ (point - frame.origin_scan_m)
        # Rounding.
        np.testing.assert_allclose(frame.to_manhattan(point), by_hand, atol=1e-12)


@given(yaw=ANGLES, tilt=st.floats(0.0, 0.3), azimuth=ANGLES)
def test_simulated_pose_tilts_the_vertical_by_the_angle_asked_for(yaw, tilt, azimuth):
    up = scan_frame(yaw, tilt, azimuth, (0.0, 0.0, 0.0)).directions_to_scan(np.array([0.0, 0.0, 1.0]))
    # atan2 keeps full precision near zero, where arccos has half.
    assert abs(np.arctan2(np.hypot(up[0], up[1]), up[2]) - tilt) < 1e-12
