"""The files in configs/ load, say what they change, and change something."""

import dataclasses
import importlib.util
import tomllib
from pathlib import Path

import numpy as np
import pytest

from indoorfit import RunConfig, load_config
from indoorfit.api import fit
from indoorfit.simulate import SamplingSettings, room_shape, sample_surface

CONFIGS = Path(__file__).resolve().parents[1] / "configs"
PRESETS = sorted(path for path in CONFIGS.glob("*.toml") if path.name != "default.toml")


@pytest.fixture(scope="module")
def make_default():
    spec = importlib.util.spec_from_file_location("make_default", CONFIGS / "make_default.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def small_scan():
    settings = SamplingSettings(n_points=8000, sigma_m=0.01)
    return sample_surface(room_shape("L"), settings, np.random.default_rng(0)).scan


def flattened(settings, path=()):
    for name, value in settings.items():
        if isinstance(value, dict):
            yield from flattened(value, (*path, name))
        else:
            yield (*path, name), value


def test_default_file_is_up_to_date(make_default):
    written = (CONFIGS / "default.toml").read_text(encoding="utf-8")
    assert written == make_default.document(RunConfig()), "run: python configs/make_default.py"


def test_default_file_loads_as_the_defaults():
    assert load_config(CONFIGS / "default.toml") == RunConfig()


def test_every_setting_states_its_reason(make_default):
    def silent(config, path):
        why = make_default.reasons(type(config))
        for field in dataclasses.fields(config):
            value = getattr(config, field.name)
            if dataclasses.is_dataclass(value):
                yield from silent(value, f"{path}{field.name}.")
            elif not why.get(field.name):
                yield path + field.name

    assert list(silent(RunConfig(), "")) == []


@pytest.mark.parametrize("path", PRESETS, ids=lambda path: path.stem)
def test_preset_repeats_no_default(path):
    defaults = dict(flattened(dataclasses.asdict(RunConfig())))
    load_config(path)
    changed = dict(flattened(tomllib.loads(path.read_text(encoding="utf-8"))))
    assert changed
    assert [name for name, value in changed.items() if defaults[name] == value] == []


@pytest.mark.parametrize("path", PRESETS, ids=lambda path: path.stem)
def test_preset_changes_the_result(path, small_scan):
    def stds_m(config):
        return np.array([d.quantity.std for d in fit(small_scan, config).dimensions])

    change = np.abs(stds_m(load_config(path)) / stds_m(RunConfig()) - 1.0)
    # Equal settings give equal bytes, so any change is the preset's; a thousandth is one worth a file.
    assert change.max() > 1e-3
