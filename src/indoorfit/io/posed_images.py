"""Colour images with poses: a folder in the layout of the TUM RGB-D benchmark."""

from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Float, UInt8
from scipy.spatial.transform import Rotation

from indoorfit.errors import InputError
from indoorfit.model import Camera, CameraImage

from .pictures import read_picture

_POSE_FILES = ("estimated.txt", "groundtruth.txt")
"""In this order: the scan lies where the estimated poses put it. The benchmark has only the second."""

_SLACK_S = 0.02
"""Image and pose may differ by this much in time, as in the benchmark's own tools."""


def read_posed_images(folder: str | Path) -> tuple[CameraImage, ...]:
    """The colour images of an RGB-D folder, with poses and intrinsics; pixels are read when they are needed.

    The folder holds ``rgb.txt`` (`time file`), ``estimated.txt`` or ``groundtruth.txt`` (`time tx ty tz qx
    qy qz qw`: pose of the camera in the scan, metres; x right, y down, z forward) and ``intrinsics.txt``
    (`fx fy cx cy width height`, pixel centres at whole numbers; further numbers are ignored). Images
    without a pose within 20 ms are left out.

    Raises:
        InputError: a file is missing or wrong, or no image has a pose.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; one with rgb.txt is needed. Fix: check the path.")
    camera = _camera(folder / "intrinsics.txt")
    given = [folder / name for name in _POSE_FILES if (folder / name).is_file()]
    poses = given[0] if given else folder / _POSE_FILES[-1]
    stamps, values = _table(poses, 8)
    images = []
    for row in _rows(folder / "rgb.txt"):
        if len(row) < 2:
            raise _wrong(folder / "rgb.txt", " ".join(row), "`time file` on each line")
        stamp, name = _number(folder / "rgb.txt", row[0]), row[1]
        nearest = int(np.argmin(np.abs(stamps - stamp)))
        if abs(stamps[nearest] - stamp) > _SLACK_S:
            continue
        path = folder / name
        if not path.resolve().is_relative_to(folder.resolve()):
            raise _wrong(folder / "rgb.txt", name, "a file inside the folder")
        if not path.is_file():
            raise _wrong(folder / "rgb.txt", f"{name}, which is not there", "images that exist")
        rotation = Rotation.from_quat(values[nearest, 3:]).as_matrix()
        load = partial(_pixels, path, camera)
        images.append(CameraImage(name, camera, values[nearest, :3], rotation, load))
    if not images:
        raise _wrong(poses, "no pose within 20 ms of an image in rgb.txt", "at least one")
    return tuple(images)


def _pixels(path: Path, camera: Camera) -> UInt8[np.ndarray, "height width 3"]:
    rgb = read_picture(path)
    if rgb.shape[:2] != (camera.height, camera.width):
        raise InputError(
            f"{path.name}: {rgb.shape[1]} x {rgb.shape[0]} pixels; intrinsics.txt says "
            f"{camera.width} x {camera.height}. Fix: intrinsics and images must belong together."
        )
    return rgb


def _camera(path: Path) -> Camera:
    rows = list(_rows(path))
    if len(rows) != 1 or len(rows[0]) < 6:
        raise _wrong(path, f"{len(rows)} line(s)", "one line `fx fy cx cy width height`")
    fx, fy, cx, cy, width, height = (_number(path, text) for text in rows[0][:6])
    if not (min(fx, fy, width, height) > 0.0 and width == int(width) and height == int(height)):
        raise _wrong(path, " ".join(rows[0]), "positive focal lengths and a whole size")
    return Camera(fx, fy, cx, cy, int(width), int(height))


def _table(path: Path, columns: int) -> tuple[Float[np.ndarray, " rows"], Float[np.ndarray, "rows others"]]:
    rows = []
    for row in _rows(path):
        if len(row) != columns:
            raise _wrong(path, " ".join(row)[:60], f"{columns} numbers on each line")
        rows.append([_number(path, text) for text in row])
    table = np.array(rows, float).reshape(-1, columns)
    if not len(table):
        raise _wrong(path, "no pose", "at least one")
    if (np.linalg.norm(table[:, -4:], axis=1) < 1e-6).any():
        raise _wrong(path, "a quaternion of length 0", "qx qy qz qw of length 1")
    return table[:, 0], table[:, 1:]


def _rows(path: Path) -> list[list[str]]:
    """The words of each line that is neither empty nor a comment."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: cannot be read; a folder of images needs rgb.txt, intrinsics.txt and estimated.txt or "
            "groundtruth.txt. Fix: see docs/textures.md."
        ) from error
    return [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]


def _number(path: Path, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise _wrong(path, repr(text[:40]), "a finite number")
    return value


def _wrong(path: Path, found: str, needed: str) -> InputError:
    return InputError(f"{path.name}: got {found}; needed {needed}. Fix: see docs/textures.md.")
