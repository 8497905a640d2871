"""The virtual scanner: frames of a scene as a sensor sees them and a registration places them."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8

from indoorfit.errors import ConfigError
from indoorfit.model import Frame, Scan, SensorFrame

from .depth_noise import measure
from .path import Pose
from .pose import scan_frame
from .rays import bundle_order, directions, pixel_grid
from .registration import PoseErrors, Registration, pose_errors
from .scene import Scene
from .scene_build import BuiltScene, build_scene
from .sensors import Sensor
from .sight import look
from .virtual import VirtualScan


@dataclass(frozen=True)
class ScanSettings:
    """What of a virtual scan is written, and in which coordinates."""

    pixel_step: int = 4
    """Every n-th row and column: a Kinect frame of 160 x 120 points, some millions in 100 frames."""
    frame_ids: bool = True
    """Whether each point tells its frame."""
    sensor_poses: bool = True
    """Whether the (estimated) sensor positions and rotations come with the scan."""
    yaw_rad: float = 0.0
    tilt_rad: float = 0.0
    """Angle between the room's vertical and the file's z axis."""
    tilt_azimuth_rad: float = 0.0
    translation_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Scan coordinates of the Manhattan origin."""
    n_threads: int = 2
    """Frames taken at the same time; the result does not depend on it."""


DEFAULT_SCAN = ScanSettings()


@dataclass(frozen=True)
class DepthFrame:
    """One image of the sensor, with its true and its estimated pose in the scan frame."""

    distance_m: Float[np.ndarray, "rows columns"]
    """Depth (camera) or range (scanner) with all errors; NaN where there is none."""
    colours: UInt8[np.ndarray, "rows columns 3"]
    point_plane: Int[np.ndarray, "rows columns"]
    """Plane of the shape that each pixel saw; -1 for other things, and for pixels between two surfaces."""
    true: SensorFrame
    estimated: SensorFrame


def virtual_scan(
    scene: Scene,
    sensor: Sensor,
    path: tuple[Pose, ...],
    registration: Registration,
    rng: np.random.Generator,
    settings: ScanSettings = DEFAULT_SCAN,
) -> VirtualScan:
    """Scan a scene.

    Args:
        scene: what is there, Manhattan frame.
        sensor: how it measures; `sensor.exact()` for points on the true surfaces.
        path: true poses, one frame each.
        registration: errors of the estimated poses.
        rng: decides all noise; the same state gives the same bytes.
        settings: density, extras and the pose of the scan's coordinates.

    Raises:
        ConfigError: the scene does not fit together, or no ray returned anything.
    """
    built = build_scene(scene)
    used = sensor.thinned(settings.pixel_step)
    frames = scan_frames(built, used, path, registration, rng, settings)
    return assemble_scan(built, used, frames, registration, settings)


def assemble_scan(
    built: BuiltScene,
    sensor: Sensor,
    frames: Iterable[DepthFrame],
    registration: Registration,
    settings: ScanSettings = DEFAULT_SCAN,
) -> VirtualScan:
    """Put frames together as one scan.

    Args:
        built: the scene that was scanned.
        sensor: as given to `scan_frames`, that is, thinned.
        frames: from `scan_frames`.
        registration: as given to `scan_frames`; only its scale error is recorded.
        settings: the same.

    Raises:
        ConfigError: no ray returned anything.
    """
    scene = built.scene
    rays = directions(sensor, pixel_grid(sensor))
    points_m, colours, planes, ids = [], [], [], []
    estimated, true = [], []
    for frame in frames:
        keep = np.isfinite(frame.distance_m)
        in_sensor_m = rays[keep] * frame.distance_m[keep][:, None]
        R_scan_sensor = frame.estimated.rotation
        assert R_scan_sensor is not None, "the simulator always knows its rotations"
        points_m.append(in_sensor_m @ R_scan_sensor.T + frame.estimated.position_m)
        colours.append(frame.colours[keep])
        planes.append(frame.point_plane[keep])
        ids.append(np.full(len(in_sensor_m), frame.true.id))
        estimated.append(frame.estimated)
        true.append(frame.true)
    if not sum(map(len, points_m)):
        raise ConfigError(
            f"{scene.name}: no ray returned anything within {sensor.min_m:g} to {sensor.max_m:g} m. "
            "Fix: another path or sensor."
        )
    scan = Scan(
        np.concatenate(points_m),
        np.concatenate(colours),
        np.concatenate(ids) if settings.frame_ids else None,
        tuple(estimated) if settings.sensor_poses else (),
        name=scene.name,
    )
    point_plane = np.concatenate(planes)
    frame = _frame(settings)
    return VirtualScan(scan, built.shape, frame, point_plane, tuple(true), scene, registration.scale_error)


def scan_frames(
    built: BuiltScene,
    sensor: Sensor,
    path: tuple[Pose, ...],
    registration: Registration,
    rng: np.random.Generator,
    settings: ScanSettings = DEFAULT_SCAN,
) -> Iterator[DepthFrame]:
    """The frames of a scan one by one, for `virtual_scan` and for RGB-D images.

    `settings.pixel_step` is not applied here: thin the sensor.
    """
    errors = pose_errors(registration, len(path), rng)
    frame = _frame(settings)
    # One generator per frame: neither the threads' order nor an earlier frame's content matters.
    streams = rng.spawn(len(path))
    optics = _optics(sensor)

    def take(k: int) -> DepthFrame:
        distance_m, colours, plane = _take(built, optics, path[k], streams[k])
        scaled_m = distance_m * (1.0 + registration.scale_error)
        return DepthFrame(scaled_m, colours, plane, *_poses(k, path[k], errors, registration, frame))

    with ThreadPoolExecutor(max(1, settings.n_threads)) as pool:
        yield from pool.map(take, range(len(path)))


def _frame(settings: ScanSettings) -> Frame:
    return scan_frame(settings.yaw_rad, settings.tilt_rad, settings.tilt_azimuth_rad, settings.translation_m)


def _poses(
    k: int, pose: Pose, errors: PoseErrors, registration: Registration, frame: Frame
) -> tuple[SensorFrame, SensorFrame]:
    R_scan_manhattan = frame.R_manhattan_scan.T
    true = SensorFrame(k, frame.to_scan(pose.position_m), R_scan_manhattan @ pose.R_manhattan_sensor)
    believed_m = (pose.position_m + errors.translation_m[k]) * (1.0 + registration.scale_error)
    R_believed = errors.matrices()[k] @ pose.R_manhattan_sensor
    return true, SensorFrame(k, frame.to_scan(believed_m), R_scan_manhattan @ R_believed)


@dataclass(frozen=True)
class _Optics:
    """What all frames of a sensor share."""

    sensor: Sensor
    pixels: Float[np.ndarray, "rows columns 2"]
    order: Int[np.ndarray, " rays"]
    back: Int[np.ndarray, " rays"]
    """Undoes `order`."""
    stretch: Float[np.ndarray, "rows columns"]
    """Range over depth: a camera's distances count along its axis, where every ray has z = 1."""


def _optics(sensor: Sensor) -> _Optics:
    pixels, order = pixel_grid(sensor), bundle_order(sensor)
    back = np.empty_like(order)
    back[order] = np.arange(len(order))
    length = np.linalg.norm(directions(sensor, pixels), axis=-1)
    return _Optics(sensor, pixels, order, back, length if sensor.along_ray else np.ones_like(length))


def _take(
    built: BuiltScene, optics: _Optics, pose: Pose, rng: np.random.Generator
) -> tuple[
    Float[np.ndarray, "rows columns"], UInt8[np.ndarray, "rows columns 3"], Int[np.ndarray, "rows columns"]
]:
    """Measured distances, colours and planes of one frame."""
    sensor, back = optics.sensor, optics.back
    jitter = sensor.lateral_pixels * rng.standard_normal(optics.pixels.shape)
    pixels = (optics.pixels + jitter).reshape(-1, 2)[optics.order]
    rays = directions(sensor, pixels) @ pose.R_manhattan_sensor.T
    sight = look(built, sensor, pose.position_m, rays, rng)
    grid = (sensor.rows, sensor.columns)
    true_m = sight.distance_m[back].reshape(grid) * optics.stretch
    distance_m, mixed = measure(sensor, true_m, sight.incidence_rad[back].reshape(grid), rng)
    plane = np.where(mixed, -1, sight.plane[back].reshape(grid))
    colours = sight.colours[back]
    if sensor.colour_sigma > 0.0:
        # Single precision is plenty for colours and halves the time of drawing them.
        colours += sensor.colour_sigma * rng.standard_normal(colours.shape, dtype=np.float32)
    image = np.clip(colours, 0.0, 255.0).round().astype(np.uint8).reshape(*grid, 3)
    return distance_m / optics.stretch, image, plane
