"""Rooms from point clouds: watertight models whose dimensions can be believed.

scan = indoorfit.read("room.ply")
model = indoorfit.fit(scan)
model.dimensions
model.write("out")
"""

from typing import TYPE_CHECKING, Any

from .errors import ConfigError as ConfigError
from .errors import IndoorfitError as IndoorfitError
from .errors import InputError as InputError
from .errors import OutputError as OutputError
from .errors import SamplingError as SamplingError

if TYPE_CHECKING:
    from .api import RoomModel as RoomModel
    from .api import fit as fit
    from .api import read as read
    from .config import RunConfig as RunConfig
    from .config import load_config as load_config
    from .model import Scan as Scan

_LAZY = {
    "RoomModel": "api",
    "fit": "api",
    "read": "api",
    "RunConfig": "config",
    "load_config": "config",
    "Scan": "model",
}

__all__ = [
    "ConfigError",
    "IndoorfitError",
    "InputError",
    "OutputError",
    "RoomModel",
    "RunConfig",
    "SamplingError",
    "Scan",
    "fit",
    "load_config",
    "read",
]


def __getattr__(name: str) -> Any:
    """Load on first use: importing the package must not cost the second that JAX takes."""
    from importlib import import_module

    if name not in _LAZY:
        raise AttributeError(f"module 'indoorfit' has no attribute {name!r}")
    return getattr(import_module(f".{_LAZY[name]}", __name__), name)


def __dir__() -> list[str]:
    """What is public; the packages below are for those who build on single stages."""
    return sorted(__all__)
