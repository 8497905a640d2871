"""How a quantity is written for people: no digit more than its interval warrants."""

import math
from dataclasses import dataclass

from indoorfit.model import Quantity

_SKEWED = 0.05
"""An interval counts as symmetric while its middle is within this share of its half width."""


@dataclass(frozen=True)
class QuantityText:
    """A quantity ready for print, without its unit."""

    value: str
    half_width: str | None
    """After the plus-minus sign; None where the interval is not symmetric or not finite."""
    low: str
    high: str

    @property
    def spread(self) -> str:
        """`± 0.0012`, or `5.071 .. 5.084` for an interval that is not symmetric."""
        return f"± {self.half_width}" if self.half_width else f"{self.low} .. {self.high}"

    @property
    def together(self) -> str:
        """`5.0781 ± 0.0012`, or `5.078 (5.071 .. 5.084)`."""
        return f"{self.value} {self.spread if self.half_width else f'({self.spread})'}"


def half_width(quantity: Quantity) -> float:
    """The larger of the distances from the value to the two ends of its interval."""
    return max(quantity.value - quantity.interval.low, quantity.interval.high - quantity.value)


def quantity_text(quantity: Quantity, min_decimals: int = 3, max_decimals: int = 4) -> QuantityText:
    """Round to two significant digits of the uncertainty, within the given decimals.

    Uncertainties are rounded up and intervals outward (GUM 7.2.6), so nothing reads better than it is.

    Args:
        quantity: any value with an interval.
        min_decimals: decimals even of a poorly known value.
        max_decimals: a tenth of a millimetre for lengths; finer is below what a wall is flat to.
    """
    low, high = quantity.interval.low, quantity.interval.high
    widest = half_width(quantity)
    if not math.isfinite(widest):
        value = f"{quantity.value:.{min_decimals}f}" if math.isfinite(quantity.value) else "unknown"
        return QuantityText(value, None, _end(low, min_decimals, -1), _end(high, min_decimals, 1))
    wanted = 1 - math.floor(math.log10(widest)) if widest > 0 else max_decimals
    decimals = min(max(wanted, min_decimals), max_decimals)
    middle = 0.5 * (low + high)
    symmetric = abs(middle - quantity.value) <= _SKEWED * widest
    return QuantityText(
        f"{quantity.value:.{decimals}f}",
        _end(widest, decimals, 1) if symmetric else None,
        _end(low, decimals, -1),
        _end(high, decimals, 1),
    )


def _end(number: float, decimals: int, direction: int) -> str:
    """Rounded down (-1) or up (+1)."""
    if not math.isfinite(number):
        return "unknown"
    # A millionth of the last digit forgives binary fractions: 0.0012 must not become 0.0013.
    scaled = number * 10**decimals - direction * 1e-6
    whole = math.ceil(scaled) if direction > 0 else math.floor(scaled)
    return f"{whole / 10**decimals + 0.0:.{decimals}f}"
