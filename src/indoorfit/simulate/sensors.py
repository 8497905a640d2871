"""Sensors as data: fields of view and published noise laws, read from the presets of the package."""

import os
import tomllib
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Literal

import cattrs
import numpy as np
from jaxtyping import Float

from indoorfit.errors import ConfigError

SENSOR_PRESETS = ("kinect_v1", "phone_lidar", "tof_camera", "tls")


@dataclass(frozen=True)
class Sensor:
    """A depth camera or a laser scanner."""

    kind: Literal["camera", "scanner"]
    """A `camera` sees a pinhole image, a `scanner` a grid of azimuths and elevations from the zenith down."""
    columns: int
    rows: int
    width_rad: float
    height_rad: float
    min_m: float
    max_m: float
    """Range limits: depth for cameras, unless `along_ray`."""
    source: str = ""
    """Where the figures come from."""
    sigma_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Standard deviation s0 + s1 d + s2 d^2 of the depth (or range) d, quantisation included."""
    step_per_m: float = 0.0
    """Depth resolution is this times d^2: whole steps of disparity (0: not quantised)."""
    along_ray: bool = False
    """Whether noise and limits apply to the range along the ray rather than to the depth."""
    grazing_m: float = 0.0
    """Coefficient of Nguyen's term c / sqrt(d) * t^2 / (pi/2 - t)^2 at incidence t."""
    incidence_power: float = 0.0
    """The noise grows with 1 / cos(incidence) to this power."""
    max_incidence_rad: float = 1.5
    """Steeper surfaces return nothing."""
    lateral_pixels: float = 0.0
    """Standard deviation of where a pixel really looks, in pixels."""
    correlation_pixels: float = 0.0
    """Depth noise is smoothed over this many pixels; its size stays."""
    bowl_m: float = 0.0
    """Systematic error of the depth: minus this in the middle of the image, plus this in its corners."""
    mixed_share: float = 0.0
    """Share of pixels beside a depth edge that end between the two surfaces."""
    dropout_share: float = 0.0
    """Share of pixels that return nothing without reason."""
    glass_return: float = 0.0
    """Share of rays that glass itself sends back."""
    glass_reflection: float = 0.0
    """Share of rays that glass mirrors: they end as ghosts behind it."""
    colour_sigma: float = 0.0
    """Standard deviation of each colour channel, 0 to 255."""

    @property
    def n_rays(self) -> int:
        """Rays of one frame."""
        return self.columns * self.rows

    @property
    def focal_pixels(self) -> tuple[float, float]:
        """Focal lengths of a camera, in pixels, along columns and rows."""
        return (
            0.5 * self.columns / float(np.tan(0.5 * self.width_rad)),
            0.5 * self.rows / float(np.tan(0.5 * self.height_rad)),
        )

    def law_m(self, distance_m: Float[np.ndarray, "..."]) -> Float[np.ndarray, "..."]:
        """Standard deviation of the depth (or range) at normal incidence."""
        s0, s1, s2 = self.sigma_m
        return s0 + s1 * distance_m + s2 * distance_m**2

    def exact(self) -> "Sensor":
        """The same sensor without any error: every return lies on the surface it came from."""
        return replace(
            self, sigma_m=(0.0, 0.0, 0.0), step_per_m=0.0, grazing_m=0.0, incidence_power=0.0,
            lateral_pixels=0.0, bowl_m=0.0, mixed_share=0.0, dropout_share=0.0, glass_return=0.0,
            glass_reflection=0.0, colour_sigma=0.0,
        )  # fmt: skip

    def thinned(self, step: int) -> "Sensor":
        """The same field of view and noise with every `step`-th row and column only.

        Raises:
            ConfigError: the step is below 1 or leaves less than two rows or columns.
        """
        if step < 1 or min(self.columns, self.rows) // step < 2:
            raise ConfigError(
                f"simulate: pixel step {step} for {self.columns} x {self.rows} pixels; need 1 or more, and "
                "at least two pixels left. Fix: a smaller step."
            )
        return replace(
            self,
            columns=self.columns // step,
            rows=self.rows // step,
            lateral_pixels=self.lateral_pixels / step,
            correlation_pixels=self.correlation_pixels / step,
            # A pixel is as wide as before, so of those beside an edge only every n-th lies on it.
            mixed_share=self.mixed_share / step,
        )


def load_sensor(name: str | os.PathLike[str]) -> Sensor:
    """A sensor by the name of its preset, or from a TOML file of the same keys.

    Raises:
        ConfigError: there is no such preset or file, or it describes no sensor.
    """
    if name in SENSOR_PRESETS:
        text = (resources.files("indoorfit.simulate") / "sensor_presets" / f"{name}.toml").read_text("utf-8")
    else:
        try:
            text = Path(name).read_text(encoding="utf-8")
        except OSError as e:
            raise ConfigError(
                f"simulate: no sensor '{Path(name).name}'; need one of {', '.join(SENSOR_PRESETS)} or a TOML "
                "file. Fix: choose a preset or check the path."
            ) from e
    try:
        sensor = cattrs.Converter(forbid_extra_keys=True).structure(tomllib.loads(text), Sensor)
    except Exception as e:
        problems = (
            "; ".join(cattrs.transform_error(e)) if not isinstance(e, tomllib.TOMLDecodeError) else str(e)
        )
        raise ConfigError(f"{Path(name).name}: not a sensor: {problems}. Fix: compare with a preset.") from e
    _check(sensor, Path(name).name)
    return sensor


def _check(sensor: Sensor, where: str) -> None:
    widest_rad = (np.pi, np.pi) if sensor.kind == "camera" else (2.0 * np.pi + 1e-9, np.pi + 1e-9)
    in_view = 0.0 < sensor.width_rad < widest_rad[0] and 0.0 < sensor.height_rad < widest_rad[1]
    if not in_view or min(sensor.columns, sensor.rows) < 2 or not 0.0 < sensor.min_m < sensor.max_m:
        raise ConfigError(
            f"{where}: {sensor.columns} x {sensor.rows} pixels over {sensor.width_rad:g} x "
            f"{sensor.height_rad:g} rad, {sensor.min_m:g} to {sensor.max_m:g} m: no such sensor. Fix: at "
            "least 2 x 2 pixels, angles in radians below half a turn (a scanner's width: a turn), and "
            "0 < min_m < max_m."
        )
    if min(sensor.law_m(np.array([sensor.min_m, sensor.max_m]))) < 0.0:
        raise ConfigError(f"{where}: sigma_m gives a negative noise. Fix: correct its three numbers.")
