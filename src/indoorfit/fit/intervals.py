"""Standard uncertainties and intervals of anything that is smooth in the plane offsets."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.geometry import exposures
from indoorfit.model import Shape

from .residuals import with_inferred
from .uncertainty import Cells, Contrasts, Predictive, WallFieldConfig, wall_field_predictive


@dataclass(frozen=True)
class IntervalConfig:
    """How intervals are made."""

    wall_field: WallFieldConfig = field(default_factory=WallFieldConfig)
    """The Gaussian-process field of wall residuals."""


@dataclass(frozen=True)
class Intervals:
    """One entry per measurand."""

    std: Float[np.ndarray, " measurands"]
    low: Float[np.ndarray, " measurands"]
    high: Float[np.ndarray, " measurands"]
    noise: dict[str, Any]
    """The estimated noise model, with an `explanation` in plain words."""


_CONDITIONS = (
    "Intervals assume that the scan's scale is true and that different faces were registered "
    "independently: an error of scale, or a whole face that slipped, leaves no trace in a cloud without "
    "frame ids."
)


def intervals(
    cells: Cells,
    shape: Shape,
    values: Float[np.ndarray, " measurands"],
    gradients: Float[np.ndarray, "measurands planes"],
    inferred_std_m: float,
    edge_std_m: Float[np.ndarray, " planes"],
    level: float,
    config: IntervalConfig,
    rng: np.random.Generator,
) -> Intervals:
    """Propagate the wall field to measurands.

    First order in the offsets: exact for lengths; for areas the neglected term is the product of two
    offset errors, a millionth of a square metre for errors of a millimetre.

    Args:
        cells: residuals of the fit at `shape`.
        shape: fitted.
        values: of the measurands, their own unit.
        gradients: unit per metre.
        inferred_std_m: of planes without points.
        edge_std_m: from `edge_exchange_std`.
        level: nominal coverage.
        config: see `IntervalConfig`.
        rng: for the draws of the noise scales.
    """
    matrix = np.concatenate([np.zeros((len(gradients), 3)), gradients], axis=1)
    contrasts = Contrasts(matrix, np.concatenate([np.zeros(3), shape.offsets_m]))
    predictive = wall_field_predictive(
        with_inferred(cells, shape, inferred_std_m), contrasts, config.wall_field, rng
    )
    predictive = _with_edge_exchange(predictive, edge_std_m)
    low, high = predictive.interval(level)
    noise = dict(predictive.noise)
    noise["explanation"] = f"{noise.pop('sentence')} {_CONDITIONS}"
    shift = values - contrasts.values_m
    return Intervals(predictive.std, low + shift, high + shift, noise)


def edge_exchange_std(
    shape: Shape, plane_rms_m: Float[np.ndarray, " planes"]
) -> Float[np.ndarray, " planes"]:
    """How far noise along the line of sight may shift a plane through the edges of its face.

    Such noise moves a point across the wall and along it at once. At the edge of a face the points that
    come in and those that go out are therefore on different sides of the plane, which shifts its mean by
    sigma^2 sin(a) cos(a) / width per edge, a the angle of incidence: at most half of sigma^2 / width.

    Args:
        shape: fitted.
        plane_rms_m: spread of the points about each plane, metres.
    """
    std_m = np.zeros(len(shape.planes))
    for exposure in exposures(shape):
        columns, rows = np.any(exposure.mask, axis=1), np.any(exposure.mask, axis=0)
        if not columns.any():
            continue
        widths_m = np.array([np.diff(exposure.u_m)[columns].sum(), np.diff(exposure.v_m)[rows].sum()])
        std_m[exposure.plane] = 0.5 * plane_rms_m[exposure.plane] ** 2 * float(np.sum(1.0 / widths_m))
    return std_m


def _with_edge_exchange(predictive: Predictive, std_m: Float[np.ndarray, " planes"]) -> Predictive:
    extra = np.diag(np.concatenate([np.zeros(3), np.square(std_m)]))
    return replace(predictive, covariances=predictive.covariances + extra)
