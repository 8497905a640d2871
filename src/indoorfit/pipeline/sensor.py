"""Which sensor took a scan, judged by exclusion: what a sensor cannot have seen, it has not seen.

Every sensor whose published figures the simulator knows is a candidate. One is excluded where the scan shows

- a range that it does not reach, or a frame wider than its field of view (two rays of a camera are never
  farther apart than its diagonal), a twentieth of the points left aside;
- noise within single frames, at some range, of less than half or more than twice its law. Copies of a sensor,
  surfaces and filters differ by less than that; and a frame cannot be spoilt by registration.

A single candidate that is left is the sensor. Several, or none, decide nothing: then no figure is added for
the scan's scale, as without a name, and the reader is told. All of this needs the frame of every point and
the sensor's position in each frame; the points of a bare cloud do not say from where they were seen.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import KDTree

from indoorfit.config import RunConfig
from indoorfit.fitting import SensorName, TypeBConfig
from indoorfit.geometry import MAD_TO_STD
from indoorfit.model import Note, Scan
from indoorfit.simulate import Sensor, load_sensor

log = logging.getLogger("indoorfit")

CANDIDATES: Mapping[str, SensorName | None] = {
    # Whether a Kinect was calibrated shows in no point: the wider of its two settings.
    "kinect_v1": "kinect_v1",
    "phone_lidar": "phone_lidar",
    "tof_camera": None,
    "tls": "laser",
}
"""Sensors of the simulator, and the setting that each stands for; None where there is none."""

_WRONG_SHARE = 0.05
"""Points that mirrors and edges may have put anywhere."""
_MAX_FRAMES = 30
_MAX_POINTS = 4000
"""Of one frame: enough for a standard deviation to some per cent in every range bin."""
_NEIGHBOURS = 24
_MIN_IN_BIN = 150
"""A robust standard deviation of so many is good to 8 %."""
_RANGE_BINS_M = np.array([0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 14.0, 20.0, 30.0])
_FACTOR = 2.0
_MIN_BINS = 2
"""Growth with range shows from two ranges on."""
_MIN_INCIDENCE_COS = 0.5
"""Beyond 60 degrees every sensor gets worse in a way of its own."""


@dataclass(frozen=True)
class SensorChoice:
    """What the data say of their sensor."""

    sensor: SensorName
    """`unknown` where they do not decide."""
    message: str
    """Why, in a sentence."""

    @property
    def note(self) -> Note | None:
        """For the output; None where nothing was chosen."""
        return None if self.sensor == "unknown" else Note("SENSOR_CHOSEN", self.message)


@dataclass(frozen=True)
class _Evidence:
    farthest_m: float
    """95th percentile over the points, of the distance from the sensor."""
    spread_rad: float
    """95th percentile of the angles of a frame's rays about their mean direction, the median over frames."""
    ranges_m: Float[np.ndarray, " bins"]
    noise_m: Float[np.ndarray, " bins"]
    """Standard deviation along the ray at these ranges."""


def choose_sensor(scan: Scan) -> SensorChoice:
    """Say which sensor the scan's frames agree with, if it is one only.

    Args:
        scan: metres, scan frame.
    """
    if scan.frame_ids is None or not scan.frames:
        return SensorChoice(
            "unknown",
            "sensor: not told by the data, which have no frame ids with sensor poses; nothing is added for "
            "the scan's scale (--sensor NAME adds it)",
        )
    evidence = _evidence(scan)
    if evidence is None:
        return SensorChoice(
            "unknown",
            "sensor: too few points per frame to tell it from; nothing is added (name it with --sensor)",
        )
    left = [name for name in CANDIDATES if _agrees(load_sensor(name), evidence)]
    seen = (
        f"ranges up to {evidence.farthest_m:.1f} m, noise of {1e3 * evidence.noise_m[0]:.1f} mm at "
        f"{evidence.ranges_m[0]:.1f} m and {1e3 * evidence.noise_m[-1]:.1f} mm at "
        f"{evidence.ranges_m[-1]:.1f} m"
    )
    chosen = CANDIDATES[left[0]] if len(left) == 1 else None
    if chosen is None:
        found = f"fit {' and '.join(left)}" if left else "fit no sensor that is known"
        return SensorChoice("unknown", f"sensor: {seen} {found}; nothing is added (--sensor NAME adds it)")
    return SensorChoice(
        chosen,
        f"The sensor was taken for {chosen} by the data: {seen} agree with no other that is known. Its "
        "uncertainties of scale and definition are in the intervals. Fix, if it was another: --sensor NAME, "
        "or --sensor unknown to add none.",
    )


def sensor_from_data(scan: Scan, config: RunConfig) -> tuple[Scan, RunConfig]:
    """Let the data name the sensor, where the settings say nothing of it; told in a note or in the log.

    Only `type_b` is set, which can make intervals wider and never narrower: a sensor's prior for the noise
    (as in the files of ``configs/``) is left to those who know it.

    Args:
        scan: metres, scan frame.
        config: settings; where any of `type_b` is not the default both come back as they are.

    Returns:
        the scan with a note of the choice, and the settings with the sensor.
    """
    if config.type_b != TypeBConfig():
        return scan, config
    choice = choose_sensor(scan)
    if choice.note is None:
        log.info("%s", choice.message)
        return scan, config
    type_b = replace(config.type_b, sensor=choice.sensor)
    return replace(scan, notes=(*scan.notes, choice.note)), replace(config, type_b=type_b)


def _agrees(sensor: Sensor, evidence: _Evidence) -> bool:
    if evidence.farthest_m > sensor.max_m:
        return False
    if sensor.kind == "camera":
        half = [np.tan(0.5 * angle) for angle in (sensor.width_rad, sensor.height_rad)]
        if evidence.spread_rad > 2.0 * np.arctan(np.hypot(*half)):
            return False
    law_m = sensor.law_m(evidence.ranges_m)
    return bool(np.all((evidence.noise_m > law_m / _FACTOR) & (evidence.noise_m < law_m * _FACTOR)))


def _evidence(scan: Scan) -> _Evidence | None:
    """Ranges, angles and noise of some frames, evenly chosen; None where there is too little."""
    assert scan.frame_ids is not None, "asked for before"
    seen = set(np.unique(scan.frame_ids).tolist())
    known = [frame for frame in scan.frames if frame.id in seen]
    known = known[:: -(-len(known) // _MAX_FRAMES) or 1]
    reaches, ranges, residuals, spreads = [], [], [], []
    for frame in known:
        rays_m = scan.points_m[scan.frame_ids == frame.id] - frame.position_m
        rays_m = rays_m[np.linalg.norm(rays_m, axis=1) > 1e-3]
        if len(rays_m) < 2 * _NEIGHBOURS:
            continue
        directions = rays_m / np.linalg.norm(rays_m, axis=1)[:, None]
        middle = directions.mean(axis=0)
        length = float(np.linalg.norm(middle))
        cosines = directions @ middle / max(length, 1e-9)
        spreads.append(float(np.quantile(np.arccos(np.clip(cosines, -1.0, 1.0)), 1.0 - _WRONG_SHARE)))
        range_m, residual_m, frontal = _frame_noise(rays_m)
        reaches.append(range_m)
        ranges.append(range_m[frontal])
        residuals.append(residual_m[frontal])
    if not spreads:
        return None
    range_m, residual_m = np.concatenate(ranges), np.concatenate(residuals)
    bins = np.digitize(range_m, _RANGE_BINS_M)
    full = [k for k in np.unique(bins) if np.sum(bins == k) >= _MIN_IN_BIN]
    if len(full) < _MIN_BINS:
        return None
    return _Evidence(
        float(np.quantile(np.concatenate(reaches), 1.0 - _WRONG_SHARE)),
        float(np.median(spreads)),
        np.array([float(np.median(range_m[bins == k])) for k in full]),
        np.array([MAD_TO_STD * float(np.median(np.abs(residual_m[bins == k]))) for k in full]),
    )


def _frame_noise(
    rays_m: Float[np.ndarray, "points 3"],
) -> tuple[Float[np.ndarray, " some"], Float[np.ndarray, " some"], Bool[np.ndarray, " some"]]:
    """Range of some points, distance along the ray from the neighbours' plane, and whether it tells noise."""
    chosen = np.arange(len(rays_m))[:: -(-len(rays_m) // _MAX_POINTS) or 1]
    _, near = KDTree(rays_m).query(rays_m[chosen], _NEIGHBOURS)
    patches = rays_m[near]
    centred = patches - patches.mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))
    normals = vectors[:, :, 0]
    range_m = np.linalg.norm(rays_m[chosen], axis=1)
    incidence = np.abs(np.einsum("ni,ni->n", normals, rays_m[chosen])) / range_m
    across_m = np.einsum("ni,ni->n", normals, centred[:, 0])
    # The plane has taken three of the neighbours' degrees of freedom.
    residual_m = across_m / np.maximum(incidence, 1e-6) * np.sqrt(_NEIGHBOURS / (_NEIGHBOURS - 3.0))
    return range_m, residual_m, incidence > _MIN_INCIDENCE_COS
