"""The rooms that a manifest asks to simulate."""

from dataclasses import asdict
from typing import Any

import numpy as np

from indoorfit.errors import ConfigError
from indoorfit.model import FitResult, Scan, Shape
from indoorfit.pipeline import truth_result
from indoorfit.simulate import (
    RandomSceneSettings,
    SamplingSettings,
    ScanSettings,
    handheld_path,
    load_sensor,
    random_room,
    random_scene,
    regime,
    room_plans,
    room_shape,
    sample_surface,
    stations,
    virtual_scan,
)

from .jobs import Simulation

_MAX_TILT_RAD = 0.1
"""A scan leans by up to 6 degrees: a hand-held one is never level."""
_STRETCH = (0.95, 1.2)
"""Of a preset's extents; much smaller ones leave no space for its notches."""


def simulate(wanted: Simulation, name: str) -> tuple[Scan, FitResult]:
    """The scan of one room and its exact model; both follow from the settings alone.

    Raises:
        ConfigError: a setting is out of range, or the settings allow no room.
    """
    rng = np.random.default_rng(wanted.seed)
    pose: dict[str, Any] = {
        "yaw_rad": float(rng.uniform(0.0, 2.0 * np.pi)),
        "tilt_rad": float(rng.uniform(0.0, _MAX_TILT_RAD)),
        "tilt_azimuth_rad": float(rng.uniform(0.0, 2.0 * np.pi)),
    }
    if wanted.sensor is None:
        settings = SamplingSettings(
            n_points=wanted.points,
            sigma_m=wanted.sigma_m,
            n_furniture=wanted.furniture,
            n_windows=wanted.windows,
            **pose,
        )
        virtual = sample_surface(_shape(wanted, rng), settings, rng, name=name)
    else:
        contents = RandomSceneSettings(
            n_walls=wanted.walls, n_furniture=wanted.furniture, n_windows=wanted.windows, n_doors=0
        )
        rooms = None if wanted.plan == "random" else room_plans(_shape(wanted, rng))
        scene = random_scene(rng, contents, name, rooms)
        sensor = load_sensor(wanted.sensor)
        still = sensor.kind == "scanner"
        path = stations(scene, wanted.frames, rng) if still else handheld_path(scene, wanted.frames, rng)
        scanning = ScanSettings(pixel_step=wanted.pixel_step, n_threads=1, **pose)
        virtual = virtual_scan(scene, sensor, path, regime(wanted.registration), rng, scanning)
    return virtual.scan, truth_result(virtual.shape, virtual.frame, asdict(wanted), wanted.seed, virtual)


def _shape(wanted: Simulation, rng: np.random.Generator) -> Shape:
    if wanted.plan == "random":
        return random_room(rng, wanted.walls)
    preset = room_shape(wanted.plan)
    sizes_m = np.ptp(preset.bounds_m()[preset.rooms[0].id], axis=0)
    for _ in range(20):
        length_m, width_m, height_m = (float(s) for s in sizes_m * rng.uniform(*_STRETCH, size=3))
        try:
            return room_shape(wanted.plan, length_m=length_m, width_m=width_m, height_m=height_m)
        except ConfigError:
            continue  # the notches of the preset leave no space in this size
    return preset
