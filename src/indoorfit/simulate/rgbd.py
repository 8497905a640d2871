"""RGB-D frames on disk, in the layout of the TUM RGB-D benchmark."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from indoorfit.errors import ConfigError, OutputError
from indoorfit.model import SensorFrame

from .scanner import DepthFrame
from .sensors import Sensor

DEPTH_UNITS_PER_M = 5000.0
"""The benchmark's factor: 16 bits reach 13.1 m in steps of 0.2 mm."""
_FRAME_RATE_HZ = 30.0


def write_rgbd(folder: str | os.PathLike[str], frames: Iterable[DepthFrame], sensor: Sensor) -> int:
    """Write colour and depth images, poses and intrinsics; returns the number of frames.

    As `recorded_rgbd`, for frames that are not needed afterwards.
    """
    return sum(1 for _ in recorded_rgbd(folder, frames, sensor))


def recorded_rgbd(
    folder: str | os.PathLike[str], frames: Iterable[DepthFrame], sensor: Sensor
) -> Iterator[DepthFrame]:
    """Write frames to disk while they pass by, so that one scan becomes images and a cloud.

    The folder gets `rgb/` and `depth/` with one PNG per time stamp, `rgb.txt`, `depth.txt` and
    `associations.txt` (time and file), `groundtruth.txt` (true poses) and `estimated.txt` (poses with
    registration errors), both as `time tx ty tz qx qy qz qw` of the camera in the scan frame, and
    `intrinsics.txt` (`fx fy cx cy width height depth_units_per_m`; pixel centres at whole numbers).

    Args:
        folder: created if it does not exist; files of the same name are replaced.
        frames: from `scan_frames`, with the same sensor.
        sensor: a camera.

    Yields:
        the same frames. The lists, poses and intrinsics are written after the last one.

    Raises:
        ConfigError: the sensor is no camera.
        OutputError: a file cannot be written.
    """
    if sensor.kind != "camera":
        raise ConfigError("simulate: a scanner has no RGB-D images. Fix: choose a camera, such as kinect_v1.")
    folder = Path(folder)
    lists: dict[str, list[str]] = {
        "rgb": ["# time file"], "depth": ["# time file"], "associations": [],
        "groundtruth": ["# time tx ty tz qx qy qz qw"], "estimated": ["# time tx ty tz qx qy qz qw"],
    }  # fmt: skip
    n = 0
    try:
        for name in ("rgb", "depth"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        for frame in frames:
            stamp = f"{n / _FRAME_RATE_HZ:.6f}"
            _save(Image.fromarray(frame.colours), folder / "rgb" / f"{stamp}.png")
            _save(Image.fromarray(_depth_image(frame)), folder / "depth" / f"{stamp}.png")
            lists["rgb"].append(f"{stamp} rgb/{stamp}.png")
            lists["depth"].append(f"{stamp} depth/{stamp}.png")
            lists["associations"].append(f"{stamp} rgb/{stamp}.png {stamp} depth/{stamp}.png")
            lists["groundtruth"].append(f"{stamp} {_pose_text(frame.true)}")
            lists["estimated"].append(f"{stamp} {_pose_text(frame.estimated)}")
            n += 1
            yield frame
        fx, fy = sensor.focal_pixels
        centre = f"{0.5 * sensor.columns - 0.5!r} {0.5 * sensor.rows - 0.5!r}"
        lists["intrinsics"] = [
            "# fx fy cx cy width height depth_units_per_m",
            f"{fx!r} {fy!r} {centre} {sensor.columns} {sensor.rows} {DEPTH_UNITS_PER_M:g}",
        ]
        for name, lines in lists.items():
            temporary = folder / f"{name}.txt.part"
            temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
            os.replace(temporary, folder / f"{name}.txt")
    except OSError as e:
        raise OutputError(f"{folder.name}: cannot be written ({e.strerror}). Fix: check the folder.") from e


def _depth_image(frame: DepthFrame) -> np.ndarray:
    units = np.nan_to_num(frame.distance_m, nan=0.0) * DEPTH_UNITS_PER_M
    return np.where(units < 2**16, np.round(units), 0.0).astype(np.uint16)


def _save(image: Image.Image, path: Path) -> None:
    temporary = path.with_suffix(".part")
    image.save(temporary, format="PNG", compress_level=1)
    os.replace(temporary, path)


def _pose_text(frame: SensorFrame) -> str:
    assert frame.rotation is not None, "the simulator always knows its rotations"
    quaternion = Rotation.from_matrix(frame.rotation).as_quat()
    return " ".join(f"{x:.9f}" for x in (*frame.position_m, *quaternion))
