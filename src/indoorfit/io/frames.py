"""The sidecar ``SCAN.frames.json``: where the sensor stood when it took each frame of a scan."""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from jaxtyping import Float

from indoorfit.files import atomic_file

from ..model import SensorFrame
from .checked_json import JsonNode, read_json

_ROTATION_TOLERANCE = 1e-3
"""Allowed error of R^T R: three printed decimals, as some exporters write, are still a rotation."""


def frames_path(scan_path: Path) -> Path:
    """Name of the sidecar: ``scan.frames.json`` beside ``scan.ply``."""
    return scan_path.with_name(f"{scan_path.stem}.frames.json")


def read_frames_json(path: Path, metres_per_unit: float = 1.0) -> tuple[SensorFrame, ...]:
    """The sensor poses, in the order of the file.

    Args:
        path: the sidecar.
        metres_per_unit: of the positions, which are in the scan's unit.

    Raises:
        InputError: no JSON, a field is missing or of the wrong kind, an id comes twice, or a rotation
            is none.
    """
    frames: list[SensorFrame] = []
    seen: set[int] = set()
    for node in read_json(path)["frames"].items():
        frame_id = node["id"].integer(-(2**63), 2**63 - 1)
        if frame_id in seen:
            node["id"].fail(f"{frame_id} for the second time", "an id of its own")
        seen.add(frame_id)
        position_m = node["position"].array(3) * metres_per_unit
        frames.append(SensorFrame(frame_id, position_m, _rotation(node)))
    return tuple(frames)


def write_frames_json(path: str | Path, frames: Iterable[SensorFrame], *, overwrite: bool = True) -> None:
    """Write the sidecar; positions in metres, scan frame.

    Raises:
        OutputError: the file cannot be written.
    """
    rows = [
        {
            "id": int(frame.id),
            "position": [float(value) for value in frame.position_m],
            "rotation": None if frame.rotation is None else frame.rotation.astype(float).tolist(),
        }
        for frame in frames
    ]
    with atomic_file(path, overwrite=overwrite) as file:
        file.write((json.dumps({"frames": rows}, indent=1, allow_nan=False) + "\n").encode("utf-8"))


def _rotation(node: JsonNode) -> Float[np.ndarray, "3 3"] | None:
    if "rotation" not in node.mapping() or node["rotation"].value is None:
        return None
    rotation = node["rotation"].array(3, 3)
    off = np.abs(rotation.T @ rotation - np.eye(3)).max()
    if off > _ROTATION_TOLERANCE or np.linalg.det(rotation) < 0:
        node["rotation"].fail(
            "no rotation matrix", "a 3 x 3 matrix R_scan_sensor with R^T R = 1 and det R = 1"
        )
    return rotation
