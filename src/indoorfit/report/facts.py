"""Small facts about a result, in words."""

from collections.abc import Mapping

from indoorfit.model import FitResult


def input_name(result: FitResult) -> str:
    """Name of the scan file, empty where the provenance does not say."""
    source = result.provenance.get("input")
    name = source.get("name") if isinstance(source, Mapping) else source
    return str(name) if name else ""


def level_text(level: float) -> str:
    """A confidence level as people write it: `95 %`."""
    return f"{100.0 * level:g} %"
