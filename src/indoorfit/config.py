"""All settings of a run in one place, and TOML files that change them."""

import dataclasses
import math
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
    """Sample the scales of the walls' noise model by Markov chains (emcee) in place of the analytic
    approximation: slower by some seconds, within a few per cent of it, and a check of it. The scales of the
    frames' slips, where frame ids are used, stay analytic."""
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


_SHARES = (
    *(
        "orient.min_support",
        "segment.seed_planarity",
        "greedy.along",
        "greedy.across",
        "discover.rooms.walled",
    ),
    *("classify.along", "classify.across", "classify.floor_below", "classify.ceiling_above"),
    *("belief.pose_field.max_displaced", "honesty.min_coverage", "honesty.max_screened"),
    *("honesty.misfit_chance", "honesty.layer_valley", "honesty.layer_mixed"),
)
"""Shares and cosines that are not called so; everything that ends with ``_share`` is one."""


def _check_numbers(settings: Any, where: str) -> None:
    """Every number lies where its name says: sizes, counts, shares, probabilities."""
    for entry in dataclasses.fields(settings):
        value, name = getattr(settings, entry.name), f"{where}{entry.name}"
        if isinstance(value, OverrideConfig):
            # Coordinates and angles have any sign; it checks itself.
            continue
        if dataclasses.is_dataclass(value):
            _check_numbers(value, f"{name}.")
        elif isinstance(value, int | float) and not isinstance(value, bool) and name != "seed":
            _check_number(name, value)


def _check_number(name: str, value: int | float) -> None:
    size = name.endswith(("_m", "_m2", "_deg")) and not name.endswith("_std_m")
    scale = name.endswith(("_rad", "_frames", "_dof", "_log_std", "_logit_std", ".inflation"))
    if name == "greedy.confidence":
        # The number of draws goes with the logarithm of what is left to one.
        fits, needed = 0.0 < value < 1.0, "a probability above 0 and below 1"
    elif name in _SHARES or name.endswith("_share"):
        fits, needed = 0.0 <= value <= 1.0, "a share from 0 to 1"
    elif name.endswith("_deg"):
        fits, needed = 0.0 < value <= 90.0, "an angle above 0 and up to 90 degrees"
    elif name == "texture.quality":
        fits, needed = 1 <= value <= 100, "a quality from 1 to 100"
    elif isinstance(value, int) or size or scale:
        fits, needed = 0 < value < math.inf, "a positive number"
    else:
        fits, needed = 0.0 <= value < math.inf, "a number that is not negative"
    if not fits:
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
        problems = "; ".join(cattrs.transform_error(error, path=name)).replace(
            "extra fields found", "unknown keys"
        )
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
