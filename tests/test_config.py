"""Settings: every one can be read from a file and recorded, and what is wrong is named."""

import ast
import dataclasses
import inspect
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from indoorfit.config import RunConfig, config_from_dict, config_to_dict, load_config
from indoorfit.errors import ConfigError


def leaves(settings: dict, path: tuple[str, ...] = ()):
    for name, value in settings.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, name))
        else:
            yield (*path, name), value


DEFAULTS = config_to_dict(RunConfig())
LEAVES = dict(leaves(DEFAULTS))


def nested(path: tuple[str, ...], value) -> dict:
    for name in reversed(path):
        value = {name: value}
    return value


def without_none(settings: dict) -> dict:
    return {
        name: without_none(value) if isinstance(value, dict) else value
        for name, value in settings.items()
        if value is not None
    }


def test_defaults_survive_the_round_trip():
    assert config_from_dict(without_none(DEFAULTS)) == RunConfig()


def test_an_empty_file_means_the_defaults(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    assert load_config(tmp_path / "empty.toml") == RunConfig()


@pytest.mark.parametrize("path", LEAVES, ids=".".join)
def test_every_setting_can_be_changed_and_refuses_the_wrong_type(path):
    default = LEAVES[path]
    if isinstance(default, bool):
        changed = not default
    elif isinstance(default, int):
        changed = default + 1
    elif isinstance(default, float):
        # Stays a probability, and keeps the order of settings that bound each other.
        changed = 0.99 * default
    elif default is None:
        changed = {"overrides.up": "-y"}.get(".".join(path), 0.5)
    else:
        changed = default
    recorded = dict(leaves(config_to_dict(config_from_dict(nested(path, changed)))))
    assert recorded == LEAVES | {path: changed}
    if default is not None:
        with pytest.raises(ConfigError, match=path[-1]):
            config_from_dict(nested(path, 5 if isinstance(default, str) else "text"))


@pytest.mark.parametrize(
    "table", sorted({path[:-1] for path in LEAVES}), ids=lambda path: ".".join(path) or "top"
)
def test_unknown_keys_are_named_in_every_table(table):
    with pytest.raises(ConfigError, match="no_such_key"):
        config_from_dict(nested((*table, "no_such_key"), 1), "mine.toml")


def test_all_wrong_keys_are_named_at_once():
    with pytest.raises(ConfigError) as caught:
        config_from_dict({"joint": {"max_round": 3}, "thin": {"voxel": 0.1}}, "mine.toml")
    for word in ("max_round", "voxel", "mine.toml", "Fix:"):
        assert word in str(caught.value)


@given(level=st.floats(allow_nan=True))
def test_levels_are_probabilities_that_make_sense(level):
    if 0.5 <= level <= 0.999:
        assert RunConfig(level=level).level == level
    else:
        with pytest.raises(ConfigError, match="level"):
            RunConfig(level=level)


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        RunConfig().level = 0.9  # pyright: ignore


def test_every_setting_is_documented():
    """A string under every field gives its unit and the reason for its default."""

    def check(kind):
        tree = ast.parse(inspect.getsource(kind)).body[0]
        assert isinstance(tree, ast.ClassDef)
        for field, following in zip(tree.body, [*tree.body[1:], None], strict=True):
            if not isinstance(field, ast.AnnAssign):
                continue
            assert isinstance(field.target, ast.Name)
            value = getattr(kind(), field.target.id)
            if dataclasses.is_dataclass(value):
                check(type(value))
                continue
            documented = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
            assert documented, f"{kind.__name__}.{field.target.id} has no docstring"

    check(RunConfig)


CONFIGS = sorted((Path(__file__).parents[1] / "configs").glob("*.toml"))


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.name)
def test_shipped_settings_load(path):
    settings = tomllib.loads(path.read_text(encoding="utf-8"))
    loaded = dict(leaves(config_to_dict(load_config(path))))
    for key, value in leaves(settings):
        # TOML has no tuples.
        assert loaded[key] == (tuple(value) if isinstance(value, list) else value)
