"""Settings as the little that they change, and as TOML."""

import json
from typing import Any

from indoorfit.config import RunConfig, config_to_dict


def changed_settings(config: RunConfig) -> dict[str, Any]:
    """Nested dictionaries of the settings that are not the defaults."""
    return _changed(config_to_dict(config), config_to_dict(RunConfig()))


def _changed(settings: dict[str, Any], defaults: dict[str, Any]) -> dict[str, Any]:
    found = {}
    for key, value in settings.items():
        if isinstance(value, dict):
            if below := _changed(value, defaults[key]):
                found[key] = below
        elif value != defaults[key]:
            found[key] = value
    return found


def settings_toml(settings: dict[str, Any], path: tuple[str, ...] = ()) -> str:
    """The settings as TOML; plain ones first, for in TOML a table ends where the next one begins."""
    plain = {k: v for k, v in settings.items() if not isinstance(v, dict) and v is not None}
    # JSON writes strings, numbers, booleans and lists as TOML does.
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in plain.items())
    if path and plain:
        text = f"\n[{'.'.join(path)}]\n{text}"
    tables = {k: v for k, v in settings.items() if isinstance(v, dict)}
    return text + "".join(settings_toml(table, (*path, key)) for key, table in tables.items())
