"""Residuals as pictures in the page: their histogram, and a small map of each face."""

import base64
import io
import math
from html import escape

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from .residuals import ResidualMap, Residuals

_WIDTH, _HEIGHT, _LEFT, _BOTTOM = 640.0, 250.0, 46.0, 44.0
_BLUE, _PALE, _RED = (33, 102, 172), (247, 247, 247), (178, 24, 43)
"""Diverging and told apart by the colour-blind (ColorBrewer RdBu, ends)."""
_SHOWN_SHARE = 0.95
"""Of all cells whose value lies inside the colours' range."""


def histogram_svg(residuals: Residuals) -> str:
    """Bars of the residuals with the normal curve of their robust spread, as in the thesis' figure 6-1."""
    edges_mm, counts = 1e3 * residuals.edges_m, residuals.counts
    std_mm, step_mm = 1e3 * residuals.std_m, float(edges_mm[1] - edges_mm[0])
    normal = residuals.n_points * step_mm / (std_mm * math.sqrt(2.0 * math.pi))
    top = 1.05 * max(float(counts.max()), normal)

    def x(mm: float) -> float:
        return _LEFT + (mm - edges_mm[0]) / (edges_mm[-1] - edges_mm[0]) * (_WIDTH - _LEFT - 8.0)

    def y(count: float) -> float:
        return (_HEIGHT - _BOTTOM) * (1.0 - count / top) + 4.0

    bars = "".join(
        f'<rect x="{x(low):.1f}" y="{y(n):.1f}" width="{x(high) - x(low) - 0.8:.1f}" '
        f'height="{y(0.0) - y(n):.1f}"/>'
        for low, high, n in zip(edges_mm[:-1], edges_mm[1:], counts.astype(float).tolist(), strict=True)
    )
    curve = "L".join(
        f"{x(mm):.1f} {y(normal * math.exp(-0.5 * (mm / std_mm) ** 2)):.1f}"
        for mm in np.linspace(edges_mm[0], edges_mm[-1], 121).tolist()
    )
    tick_mm = _round_up(float(edges_mm[-1]) / 4.0)
    ticks = "".join(
        f'<path d="M{x(k * tick_mm):.1f} {y(0.0):.1f}v4" class="axis"/>'
        f'<text x="{x(k * tick_mm):.1f}" y="{y(0.0) + 17:.1f}" text-anchor="middle">{k * tick_mm:g}</text>'
        for k in range(-math.floor(edges_mm[-1] / tick_mm), math.floor(edges_mm[-1] / tick_mm) + 1)
    )
    about = (
        f"Histogram of {residuals.n_points} distances of points from their faces; robust standard deviation "
        f"{std_mm:.2g} mm."
    )
    return (
        f'<svg class="histogram" viewBox="0 0 {_WIDTH:.0f} {_HEIGHT:.0f}" role="img">'
        f"<title>{escape(about)}</title><g>{bars}</g>"
        f'<path class="axis" d="M{_LEFT} {y(0.0):.1f}H{_WIDTH - 8.0}"/>'
        f'<path class="curve" d="M{curve}"/>{ticks}'
        f'<text x="{_WIDTH - 8.0}" y="{_HEIGHT - 2:.0f}" text-anchor="end">distance from the face, mm</text>'
        f'<text x="12" y="{0.5 * _HEIGHT:.0f}" transform="rotate(-90 12 {0.5 * _HEIGHT:.0f})" '
        'text-anchor="middle">points</text></svg>'
    )


def residual_maps(residuals: Residuals) -> str:
    """A small picture of every face, all in the same colours, with their scale."""
    seen = np.concatenate([m.medians_m[np.isfinite(m.medians_m)] for m in residuals.maps])
    if not len(seen):
        return ""
    reach_mm = _round_up(1e3 * float(np.quantile(np.abs(seen), _SHOWN_SHARE)))
    figures = "".join(_figure(m, reach_mm) for m in residuals.maps)
    return (
        f'<p class="scale" role="img" aria-label="Colours from blue, {reach_mm:g} mm behind the face, over '
        f'white to red, {reach_mm:g} mm in front of it">behind &minus;{reach_mm:g} mm '
        f'<span class="ramp"></span> +{reach_mm:g} mm in front</p>\n'
        f'<div class="maps">{figures}</div>'
    )


def _figure(residual_map: ResidualMap, reach_mm: float) -> str:
    image = Image.fromarray(_colours(1e3 * residual_map.medians_m / reach_mm), "RGBA")
    content = io.BytesIO()
    image.save(content, "PNG", optimize=True)
    source = f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"
    seen_mm = 1e3 * residual_map.medians_m[np.isfinite(residual_map.medians_m)]
    if len(seen_mm):
        low, high = np.quantile(seen_mm, [0.05, 0.95])
        words = f"{low:+.1f} to {high:+.1f} mm"
    else:
        words = "too few points"
    face = escape(residual_map.face)
    return (
        f'<figure data-shows="{face}"><img src="{source}" alt="Residuals of {face}: {words}">'
        f"<figcaption>{face}<br>{words}</figcaption></figure>"
    )


def _colours(shares: Float[np.ndarray, "rows columns"]) -> UInt8[np.ndarray, "rows columns 4"]:
    """-1 blue, 0 pale, 1 red; what is not known is transparent."""
    known = np.isfinite(shares)
    share = np.clip(np.where(known, shares, 0.0), -1.0, 1.0)[..., None]
    ends = np.where(share < 0.0, np.array(_BLUE), np.array(_RED))
    rgb = np.array(_PALE) + np.abs(share) * (ends - np.array(_PALE))
    return np.concatenate([np.round(rgb), 255.0 * known[..., None]], axis=2).astype(np.uint8)


def _round_up(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(max(value, 1e-6)))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= value * (1.0 - 1e-9))
