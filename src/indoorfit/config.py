"""All settings of a run in one place, and TOML files that change them."""

import dataclasses
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeVar

import cattrs
from cattrs.gen import make_dict_structure_fn

from indoorfit.classify import ClassifyConfig
from indoorfit.discover import DiscoverConfig
from indoorfit.errors import ConfigError
from indoorfit.fitting import (
    BeliefConfig,
    GreedyConfig,
    HonestyConfig,
    JointConfig,
    SamplerConfig,
    TypeBConfig,
)
from indoorfit.model import OverrideConfig
from indoorfit.orient import OrientConfig
from indoorfit.segment import SegmentConfig
from indoorfit.texture import TextureConfig
from indoorfit.thin import SurfelConfig, ThinConfig

SETTINGS_HINT = "see configs/default.toml for the settings."


@dataclass(frozen=True)
class RunConfig:
    """Settings of one fit. Every field has a default with a stated reason; a TOML file may change any."""

    method: Literal["joint", "greedy"] = "joint"
    """`joint` minimises all residuals together; `greedy` is the thesis' own procedure."""
    level: float = 0.95
    """Nominal coverage of the intervals, between 0.5 and 0.999."""
    seed: int = 0
    """Seed of everything random: the same seed gives the same bytes."""
    sample: bool = False
    """Sample the scales of the noise model by Markov chains (emcee) in place of the analytic approximation:
    slower by some seconds, within a few per cent of it, and a check of it."""
    thin: ThinConfig = field(default_factory=ThinConfig)
    surfels: SurfelConfig = field(default_factory=SurfelConfig)
    orient: OrientConfig = field(default_factory=OrientConfig)
    segment: SegmentConfig = field(default_factory=SegmentConfig)
    classify: ClassifyConfig = field(default_factory=ClassifyConfig)
    discover: DiscoverConfig = field(default_factory=DiscoverConfig)
    greedy: GreedyConfig = field(default_factory=GreedyConfig)
    joint: JointConfig = field(default_factory=JointConfig)
    belief: BeliefConfig = field(default_factory=BeliefConfig)
    texture: TextureConfig = field(default_factory=TextureConfig)
    type_b: TypeBConfig = field(default_factory=TypeBConfig)
    sampler: SamplerConfig = field(default_factory=SamplerConfig)
    honesty: HonestyConfig = field(default_factory=HonestyConfig)
    overrides: OverrideConfig = field(default_factory=OverrideConfig)

    def __post_init__(self) -> None:
        if not 0.5 <= self.level <= 0.999:
            raise ConfigError(f"level: got {self.level}; needed 0.5 to 0.999. Fix: write 0.95 for 95 %.")
        if self.seed < 0:
            raise ConfigError(f"seed: got {self.seed}; needed 0 or more. Fix: write any whole number.")
        _check_numbers(self, "")


def _check_numbers(settings: Any, where: str) -> None:
    """Sizes and counts are positive, everything else is not negative; the name tells which is which."""
    for entry in dataclasses.fields(settings):
        value, name = getattr(settings, entry.name), f"{where}{entry.name}"
        if isinstance(value, OverrideConfig):
            # Coordinates and angles have any sign; it checks itself.
            continue
        if dataclasses.is_dataclass(value):
            _check_numbers(value, f"{name}.")
        elif isinstance(value, int | float) and not isinstance(value, bool) and name != "seed":
            size = entry.name.endswith(("_m", "_m2", "_deg")) and not entry.name.endswith("_std_m")
            positive = isinstance(value, int) or size
            if not (value > 0 if positive else value >= 0):
                needed = "a positive number" if positive else "a number that is not negative"
                raise ConfigError(f"{name}: got {value}; needed {needed}. Fix: leave it out for the default.")


def load_config(path: str | Path) -> RunConfig:
    """Read a TOML file of settings.

    Args:
        path: tables are named as the fields of `RunConfig`, e.g. ``[discover.candidates]``.

    Raises:
        ConfigError: no such file, no TOML, an unknown key, or a value of the wrong type.
    """
    return config_from_dict(_toml(path), Path(path).name)


def load_overrides(path: str | Path) -> OverrideConfig:
    """Read a TOML file that holds what a person says of one scan, and nothing else.

    Args:
        path: tables ``[overrides]``, ``[[overrides.force_wall]]`` and so on, as in a file of settings.

    Raises:
        ConfigError: no such file, no TOML, other tables, an unknown key, or a value of the wrong type.
    """
    name, settings = Path(path).name, _toml(path)
    if set(settings) != {"overrides"}:
        found = ", ".join(settings) or "nothing"
        raise ConfigError(
            f"{name}: found {found}; a file of overrides holds the table [overrides] and nothing else. "
            "Fix: put other settings into a file for --config."
        )
    return config_from_dict(settings, name).overrides


def _toml(path: str | Path) -> dict[str, Any]:
    """The file's tables."""
    name = Path(path).name
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}). Fix: check the path.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{name}: not TOML ({error}). Fix: see the files in configs/.") from error


def config_from_dict(settings: dict[str, Any], name: str = "settings") -> RunConfig:
    """Settings as nested dictionaries; unknown keys are errors.

    Raises:
        ConfigError: naming every key that is wrong.
    """
    return structured(settings, RunConfig, name)


T = TypeVar("T")


def structured(settings: Mapping[str, Any], kind: type[T], name: str, hint: str = SETTINGS_HINT) -> T:
    """Nested dictionaries as a dataclass: unknown keys and values of the wrong type are errors.

    Raises:
        ConfigError: naming every key that is wrong.
    """
    try:
        return _converter().structure(settings, kind)
    except cattrs.BaseValidationError as error:
        refused = _config_error(error)
        if refused is not None:
            raise refused from error
        problems = "; ".join(cattrs.transform_error(error, path=name))
        raise ConfigError(f"{problems}. Fix: {hint}") from error


def _config_error(error: BaseException) -> ConfigError | None:
    """The first of our own refusals among what the converter collected."""
    if isinstance(error, ConfigError):
        return error
    inner = error.exceptions if isinstance(error, BaseExceptionGroup) else ()
    return next((found for e in inner if (found := _config_error(e)) is not None), None)


def config_to_dict(config: RunConfig) -> dict[str, Any]:
    """Plain nested dictionaries, as recorded in the provenance."""
    return dataclasses.asdict(config)


def _converter() -> cattrs.Converter:
    converter = cattrs.Converter(forbid_extra_keys=True)
    # Numbers must be numbers: the default would turn "5" and true into floats without a word.
    converter.register_structure_hook(float, _number)
    converter.register_structure_hook(int, _whole)
    converter.register_structure_hook(bool, _flag)
    converter.register_structure_hook_factory(
        dataclasses.is_dataclass,
        lambda kind: make_dict_structure_fn(kind, converter, _cattrs_forbid_extra_keys=True),
    )
    return converter


def _number(value: Any, _: type) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"got {value!r}, needed a number")
    return float(value)


def _flag(value: Any, _: type) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"got {value!r}, needed true or false")
    return value


def _whole(value: Any, _: type) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"got {value!r}, needed a whole number")
    return value
