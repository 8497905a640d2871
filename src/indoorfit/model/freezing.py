"""What a fit hands out cannot be changed by accident."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar, cast

import numpy as np

T = TypeVar("T")


def frozen(value: T) -> T:
    """The same value, its arrays made read-only wherever they are in it (dataclasses, tuples, mappings)."""
    _freeze(value)
    return value


def _freeze(value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple | list):
        for item in cast(Iterable[Any], value):
            _freeze(item)
    elif isinstance(value, Mapping):
        for item in cast(Mapping[Any, Any], value).values():
            _freeze(item)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            _freeze(getattr(value, field.name))
