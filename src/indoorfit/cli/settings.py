"""Settings from a file and from options; the options win."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from indoorfit.config import RunConfig

Unit = Literal["m", "cm", "mm", "ft", "in"]
Up = Literal["auto", "x", "y", "z", "-x", "-y", "-z"]
Sensor = Literal["unknown", "kinect_v1", "kinect_v1_calibrated", "phone_lidar", "laser"]


def run_config(
    file: Path | None,
    up: Up | None,
    sensor: Sensor | None,
    overrides: Path | None = None,
    **given: Any,
) -> "RunConfig":
    """The settings of a run.

    Args:
        file: TOML, or None for the defaults.
        up, sensor: None leaves what the file says.
        overrides: TOML with what a person says of the scan; replaces that part of the settings.
        given: fields of `RunConfig`; None leaves what the file says.

    Raises:
        ConfigError: the file or a value is wrong.
    """
    from indoorfit.config import RunConfig, load_config, load_overrides

    config = load_config(file) if file else RunConfig()
    config = replace(config, **{name: value for name, value in given.items() if value is not None})
    if up is not None:
        config = replace(config, orient=replace(config.orient, up=up))
    if sensor is not None:
        config = replace(config, type_b=replace(config.type_b, sensor=sensor))
    if overrides is not None:
        config = replace(config, overrides=load_overrides(overrides))
    return config
