"""A scene and the virtual scanner that takes it."""

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from indoorfit.errors import ConfigError

from .simulate_options import Contents, Plan, Scanning, Way
from .simulate_room import plan_sizes_m

if TYPE_CHECKING:
    import numpy as np

    from indoorfit.simulate import Pose, Registration, Scene, Sensor, VirtualScan

DEFAULT_SENSOR = "kinect_v1"
DEFAULT_FRAMES = 90


def make_scene(way: Way, kind: str, plan: Plan, contents: Contents, rng: "np.random.Generator") -> "Scene":
    """The scene that the options ask for.

    Raises:
        ConfigError: a number is out of range, or the scene file is missing or wrong.
    """
    from indoorfit.simulate import RandomSceneSettings, random_scene, read_scene, room_plans, room_shape

    if way == "scene":
        if contents.scene is None:
            raise ConfigError("simulate scene: which one? Fix: add --scene FILE.toml.")
        return read_scene(contents.scene)
    if contents.walls is not None and (contents.rooms or 1) > 1:
        raise ConfigError("simulate random: several rooms are boxes. Fix: leave --walls or --rooms out.")
    empty = way == "scanned"
    defaults = RandomSceneSettings(n_furniture=0, n_windows=0, n_doors=0) if empty else RandomSceneSettings()
    numbers = {
        "n_walls": contents.walls,
        "n_rooms": contents.rooms,
        "n_furniture": contents.furniture,
        "n_windows": contents.windows,
        "n_doors": contents.doors,
        "uneven_m": contents.uneven,
    }
    settings = dataclasses.replace(
        defaults,
        bookcase=contents.bookcase,
        glass_wall=contents.glass_wall,
        floor_step=contents.floor_step,
        beam=contents.beam,
        oblique=contents.oblique,
        **{name: value for name, value in numbers.items() if value is not None},  # type: ignore[arg-type]
    )
    if way == "scanned":
        shape = room_shape(kind, **plan_sizes_m(plan))  # type: ignore[arg-type]
        return random_scene(rng, settings, kind, room_plans(shape))
    if plan.height is not None:
        limits = dataclasses.replace(settings.room, height_m=(plan.height, plan.height))
        settings = dataclasses.replace(settings, room=limits)
    return random_scene(rng, settings)


def scan_scene(
    scene: "Scene",
    scanning: Scanning,
    angles_deg: tuple[float, float],
    rng: "np.random.Generator",
    rgbd: Path | None,
) -> "tuple[VirtualScan, dict[str, Any]]":
    """The scan, and all that it was made with.

    Args:
        scene: what is there.
        scanning: sensor, path and registration.
        angles_deg: tilt and yaw of the scan.
        rng: decides path, drift and noise.
        rgbd: where the images go, or None.

    Raises:
        ConfigError: a value is out of range, options contradict each other, or nothing was seen.
    """
    from indoorfit.simulate import (
        ScanSettings,
        assemble_scan,
        build_scene,
        load_sensor,
        recorded_rgbd,
        scan_frames,
    )

    sensor = load_sensor(scanning.sensor or DEFAULT_SENSOR)
    sensor = sensor.exact() if scanning.exact else sensor
    built = build_scene(scene)
    path, path_record = _path(scene, sensor, scanning, rng)
    registration = _registration(scanning)
    settings = ScanSettings(
        frame_ids=not scanning.no_frame_ids,
        sensor_poses=scanning.sensor_poses,
        tilt_rad=math.radians(angles_deg[0]),
        yaw_rad=math.radians(angles_deg[1]),
        pixel_step=ScanSettings.pixel_step if scanning.pixel_step is None else scanning.pixel_step,
    )
    used = sensor.thinned(settings.pixel_step)
    frames = scan_frames(built, used, path, registration, rng, settings)
    if rgbd is not None:
        frames = recorded_rgbd(rgbd, frames, used)
    virtual = assemble_scan(built, used, frames, registration, settings)
    record = {
        "sensor": dataclasses.asdict(sensor),
        "path": path_record,
        "registration": dataclasses.asdict(registration),
        # The number of threads does not change a single byte.
        "scan": {k: v for k, v in dataclasses.asdict(settings).items() if k != "n_threads"},
        "scene": dataclasses.asdict(scene),
    }
    return virtual, record


def _path(
    scene: "Scene", sensor: "Sensor", scanning: Scanning, rng: "np.random.Generator"
) -> "tuple[tuple[Pose, ...], dict[str, Any]]":
    from indoorfit.simulate import handheld_path, stations

    if sensor.kind == "scanner":
        if scanning.frames is not None or scanning.motion is not None or scanning.rgbd is not None:
            raise ConfigError(
                "simulate: a scanner on a tripod has no frames, motion or RGB-D images. "
                "Fix: give --stations, or choose a camera such as kinect_v1."
            )
        n = max(2, len(scene.rooms)) if scanning.stations is None else scanning.stations
        return stations(scene, n, rng), {"stations": n}
    if scanning.stations is not None:
        raise ConfigError("simulate: a camera has no stations. Fix: give --frames, or choose tls.")
    n = DEFAULT_FRAMES if scanning.frames is None else scanning.frames
    motion = scanning.motion or "walk"
    return handheld_path(scene, n, rng, motion), {"frames": n, "motion": motion}


def _registration(scanning: Scanning) -> "Registration":
    from indoorfit.simulate import regime

    jumps = scanning.jump_share or 0.0
    base = regime(scanning.registration or "0")
    return dataclasses.replace(
        base,
        jump_share=jumps,
        # Jumps replace drift before they replace the white part.
        walk_share=min(base.walk_share, 1.0 - jumps),
        slip_share=scanning.slip_share or 0.0,
        scale_error=scanning.scale_error or 0.0,
    )
