"""The sensor is named by the data where they decide it, and never against them."""

import numpy as np
import pytest

from indoorfit.config import RunConfig
from indoorfit.fitting import TypeBConfig
from indoorfit.model import Scan, SensorFrame
from indoorfit.pipeline import choose_sensor, sensor_from_data
from indoorfit.simulate import load_sensor

FAR_M, NEAR_M = 9.0, 4.4


def seen(sensor: str, farthest_m: float, factor: float = 1.0) -> Scan:
    """Four frames of a sensor before five panels, the last of them `farthest_m` away, with its own noise."""
    law, rng = load_sensor(sensor), np.random.default_rng(0)
    points, ids, frames = [], [], []
    for k in range(4):
        position = np.array([10.0 * k, 0.0, 1.5])
        azimuth, elevation = np.meshgrid(np.linspace(-0.45, 0.45, 150), np.linspace(-0.3, 0.3, 50))
        rays = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
        rays = np.stack(rays, axis=-1).reshape(-1, 3)
        panel = np.minimum((np.arange(150) // 30), 4)
        depth_m = np.tile(np.linspace(1.0, farthest_m, 5)[panel], 50)
        range_m = depth_m / rays[:, 0]
        noise_m = factor * law.law_m(range_m) * rng.normal(size=len(range_m))
        points.append(position + rays * (range_m + noise_m)[:, None])
        ids.append(np.full(len(rays), k))
        frames.append(SensorFrame(k, position))
    return Scan(np.concatenate(points), frame_ids=np.concatenate(ids), frames=tuple(frames))


def test_a_range_beyond_all_cameras_and_a_scanners_noise_make_a_laser():
    assert choose_sensor(seen("tls", FAR_M)).sensor == "laser"


def test_a_floor_seen_at_a_glance_beyond_its_reach_excludes_a_camera():
    """Grazing rays tell no noise, but how far the sensor sees."""
    near = seen("kinect_v1", NEAR_M)
    assert near.frame_ids is not None
    across, along = (a.ravel() for a in np.meshgrid(np.linspace(-0.6, 0.6, 40), np.linspace(6.0, 14.0, 60)))
    floor = np.column_stack([along, across, np.full(len(along), -1.0)])
    points = np.concatenate([near.points_m, *(floor + frame.position_m for frame in near.frames)])
    ids = np.concatenate([near.frame_ids, *(np.full(len(floor), frame.id) for frame in near.frames)])
    assert choose_sensor(near).sensor == "kinect_v1"
    assert choose_sensor(Scan(points, frame_ids=ids, frames=near.frames)).sensor == "unknown"


def test_noise_that_grows_with_the_square_at_a_range_of_its_own_makes_a_kinect():
    assert choose_sensor(seen("kinect_v1", NEAR_M)).sensor == "kinect_v1"


def test_noise_that_grows_slowly_makes_a_phone():
    assert choose_sensor(seen("phone_lidar", NEAR_M)).sensor == "phone_lidar"


def test_a_near_wall_that_two_sensors_agree_with_decides_nothing():
    choice = choose_sensor(seen("kinect_v1", 3.0))
    assert choice.sensor == "unknown"
    assert "kinect_v1 and tof_camera" in choice.message
    assert choice.note is None


def test_noise_of_no_known_sensor_decides_nothing():
    choice = choose_sensor(seen("tls", FAR_M, factor=6.0))
    assert choice.sensor == "unknown"
    assert "no sensor that is known" in choice.message


@pytest.mark.parametrize("lacks", ["frame_ids", "frames"])
def test_points_that_may_come_from_anywhere_decide_nothing(lacks):
    from dataclasses import replace

    scan = replace(seen("kinect_v1", NEAR_M), **{lacks: None if lacks == "frame_ids" else ()})
    assert choose_sensor(scan).sensor == "unknown"


def test_the_choice_is_told_and_adds_to_the_intervals_only():
    scan, config = sensor_from_data(seen("kinect_v1", NEAR_M), RunConfig())
    assert config == RunConfig(type_b=TypeBConfig(sensor="kinect_v1"))
    (note,) = scan.notes
    assert note.code == "SENSOR_CHOSEN"
    for word in ("kinect_v1", "--sensor"):
        assert word in note.message


@pytest.mark.parametrize(
    "given", [TypeBConfig(sensor="laser"), TypeBConfig(scale_std=0.001), TypeBConfig(definition_std_m=0.0)]
)
def test_what_somebody_said_is_left_alone(given):
    scan, config = seen("kinect_v1", NEAR_M), RunConfig(type_b=given)
    assert sensor_from_data(scan, config) == (scan, config)


def test_the_position_and_order_of_the_frames_do_not_matter():
    scan = seen("phone_lidar", NEAR_M)
    assert scan.frame_ids is not None
    turned = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    frames = tuple(SensorFrame(f.id, turned @ f.position_m + 1e3) for f in reversed(scan.frames))
    moved = Scan(scan.points_m @ turned.T + 1e3, frame_ids=scan.frame_ids, frames=frames)
    assert choose_sensor(moved).sensor == choose_sensor(scan).sensor == "phone_lidar"
