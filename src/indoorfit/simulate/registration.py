"""How wrong the poses of a scan are: drift, jumps and slipped blocks of frames, and a wrong scale."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from indoorfit.errors import ConfigError

REGIMES = {"0": 0.0, "5mm": 0.005, "2cm": 0.02, "5cm": 0.05}
"""Names of the regimes that intervals are validated in: RMS per axis in metres."""


@dataclass(frozen=True)
class Registration:
    """Errors of the pose of each frame."""

    rms_m: float = 0.0
    """Root mean square of the position error along each axis, over all frames, without slips."""
    rotation_rad_per_m: float = 1.0 / 3.0
    """RMS of the rotation error about each axis, per metre of `rms_m`: 2 cm come with 0.4 degrees."""
    walk_share: float = 0.6
    """Share of the variance that is a random walk with its loop closed (Brownian bridge)."""
    jump_share: float = 0.0
    """Share of the variance that is constant within each sector and jumps between sectors. What is left
    after both shares is white."""
    n_sectors: int = 8
    """Contiguous groups of frames for `jump_share`."""
    slip_share: float = 0.0
    """Share of frames, one contiguous block, that is displaced as a whole, like a bad manual registration."""
    slip_m: float = 0.06
    """Length of that displacement."""
    slip_rad: float = 0.0175
    """Angle of its rotation (1 degree)."""
    scale_error: float = 0.0
    """Everything is larger by this share; no residual shows it."""


@dataclass(frozen=True)
class PoseErrors:
    """Per frame, to be applied at the sensor's position, in Manhattan axes."""

    translation_m: Float[np.ndarray, "frames 3"]
    rotation_rad: Float[np.ndarray, "frames 3"]
    """Rotation vectors."""

    def matrices(self) -> Float[np.ndarray, "frames 3 3"]:
        """The rotation errors as matrices."""
        return Rotation.from_rotvec(self.rotation_rad).as_matrix()


def regime(name: str) -> Registration:
    """The registration errors of a named regime: `0`, `5mm`, `2cm` or `5cm`.

    Raises:
        ConfigError: there is no such regime.
    """
    if name not in REGIMES:
        raise ConfigError(
            f"simulate: unknown registration '{name}'; need one of {', '.join(REGIMES)}. Fix: choose one."
        )
    return Registration(rms_m=REGIMES[name])


def pose_errors(registration: Registration, n_frames: int, rng: np.random.Generator) -> PoseErrors:
    """Draw the errors of all frames.

    Each realisation is scaled to the RMS asked for (over frames and the three axes together), so that
    scans of one regime differ in how the error is spread and not in how much of it there is.

    Raises:
        ConfigError: shares are negative or add up to more than 1.
    """
    shares = (registration.walk_share, registration.jump_share, registration.slip_share)
    if min(*shares, registration.rms_m) < 0.0 or shares[0] + shares[1] > 1.0 or shares[2] > 1.0:
        raise ConfigError(
            f"simulate: registration with shares {shares} and rms_m {registration.rms_m:g}; shares must lie "
            "from 0 to 1, walk_share + jump_share must not exceed 1. Fix: correct them."
        )
    series = np.concatenate([_series(registration, n_frames, rng) for _ in range(2)], axis=1)
    translation_m = registration.rms_m * _unit_rms(series[:, :3])
    rotation_rad = registration.rms_m * registration.rotation_rad_per_m * _unit_rms(series[:, 3:])
    slipped = _block(n_frames, registration.slip_share, rng)
    directions = rng.standard_normal((2, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    translation_m[slipped] += registration.slip_m * directions[0]
    rotation_rad[slipped] += registration.slip_rad * directions[1]
    return PoseErrors(translation_m, rotation_rad)


def _series(
    registration: Registration, n_frames: int, rng: np.random.Generator
) -> Float[np.ndarray, "frames 3"]:
    """Three series of about unit variance."""
    steps = rng.standard_normal((n_frames, 3))
    time = np.arange(1, n_frames + 1)[:, None] / n_frames
    walk = np.cumsum(steps, axis=0) / np.sqrt(n_frames)
    # The variance of a Brownian bridge is t (1 - t), 1/6 on average.
    bridge = (walk - time * walk[-1]) * np.sqrt(6.0)
    sector = np.arange(n_frames) * registration.n_sectors // max(n_frames, 1)
    jumps = rng.standard_normal((registration.n_sectors, 3))[sector]
    white = rng.standard_normal((n_frames, 3))
    white_share = max(1.0 - registration.walk_share - registration.jump_share, 0.0)
    return (
        np.sqrt(registration.walk_share) * bridge
        + np.sqrt(registration.jump_share) * jumps
        + np.sqrt(white_share) * white
    )


def _unit_rms(series: Float[np.ndarray, "frames 3"]) -> Float[np.ndarray, "frames 3"]:
    rms = np.sqrt(np.mean(series**2))
    # One frame has a bridge of zero: nothing to scale.
    return series / rms if rms > 0.0 else series


def _block(n_frames: int, share: float, rng: np.random.Generator) -> slice:
    length = round(share * n_frames)
    start = int(rng.integers(0, n_frames - length + 1))
    return slice(start, start + length)
