"""Small facts about a result, in words."""

from collections.abc import Mapping
from statistics import NormalDist

from indoorfit.export import half_width
from indoorfit.model import FitResult, Quantity

_LOA_LIMITS_M = ((0.001, "LOA50"), (0.005, "LOA40"), (0.015, "LOA30"), (0.050, "LOA20"))


def input_name(result: FitResult) -> str:
    """Name of the scan file, empty where the provenance does not say."""
    source = result.provenance.get("input")
    name = source.get("name") if isinstance(source, Mapping) else source
    return str(name) if name else ""


def level_text(level: float) -> str:
    """A confidence level as people write it: `95 %`."""
    return f"{100.0 * level:g} %"


def loa_band(quantity: Quantity) -> str:
    """The USIBD Level of Accuracy (C120) of a length in metres.

    The bands are for 95 %; an interval of another level is scaled as a normal one would be.
    """
    quantile = NormalDist().inv_cdf
    at_95_m = half_width(quantity) * quantile(0.975) / quantile(0.5 + 0.5 * quantity.interval.level)
    return next((name for limit_m, name in _LOA_LIMITS_M if at_95_m <= limit_m), "LOA10")
