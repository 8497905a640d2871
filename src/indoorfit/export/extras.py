"""Libraries that only some formats need."""

from importlib import import_module
from types import ModuleType

from indoorfit.errors import OutputError


def optional_module(name: str, extra: str, what: str) -> ModuleType:
    """Import a library of an extra.

    Args:
        name: of the module.
        extra: of indoorfit, that installs it.
        what: cannot be written without it.

    Raises:
        OutputError: it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as e:
        # Something missing below an installed library is a broken installation, not a missing extra.
        if e.name != name.partition(".")[0]:
            raise
        raise OutputError(
            f"{what}: needs the library {e.name}, which is not installed. "
            f"Fix: pip install 'indoorfit[{extra}]'."
        ) from e
