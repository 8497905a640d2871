"""What a statistician would reach for first, on the cells of a finished fit; not used for results."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from indoorfit.fitting import AssociationConfig, Cells, MeasurandPrediction, associate, build_cells
from indoorfit.fitting.uncertainty import Contrasts, cluster_robust, independent_points
from indoorfit.fitting.uncertainty.location import weighted_map
from indoorfit.model import FitResult, Scan

_PIXEL_M = 0.1
"""Resolution of the coverage, which is not used here."""
_RESAMPLES = 400
"""Ends of a 99 % interval rest on the two outermost."""

Ends = dict[str, list[tuple[float, float]]]


def yardsticks(
    scan: Scan, result: FitResult, levels: Sequence[float], rng: np.random.Generator
) -> dict[str, Ends]:
    """By method and dimension, low and high end at every level.

    Args:
        scan: that was fitted.
        result: of the joint fit.
        levels: nominal coverages.
        rng: for the bootstrap.
    """
    prediction = result.prediction
    assert isinstance(prediction, MeasurandPrediction), "a fit made this result"
    points_m = result.frame.to_manhattan(scan.points_m)
    data = associate(points_m, result.shape, AssociationConfig(), _PIXEL_M)
    cells = build_cells(data.patches, result.shape)
    gradients = prediction.gradients[: len(result.dimensions)]
    matrix = np.concatenate([np.zeros((len(gradients), 3)), gradients], axis=1)
    contrasts = Contrasts(matrix, np.concatenate([np.zeros(3), result.shape.offsets_m]))
    clusters = np.arange(len(cells.plane))
    naive = independent_points(cells, contrasts)
    robust = cluster_robust(cells, contrasts, clusters, np.asarray(cells.counts, float))
    draws = _bootstrap(cells, contrasts, rng)
    found: dict[str, Ends] = {}
    for name, ends in (
        ("iid", naive.interval),
        ("CR2", robust.interval),
        ("bootstrap", lambda level: np.quantile(draws, [0.5 - level / 2, 0.5 + level / 2], axis=0)),
    ):
        pairs = [np.nan_to_num(np.array(ends(level)), posinf=1e3, neginf=-1e3) for level in levels]
        found[name] = {
            d.id: [(float(low[k]), float(high[k])) for low, high in pairs]
            for k, d in enumerate(result.dimensions)
        }
    return found


def _bootstrap(
    cells: Cells, contrasts: Contrasts, rng: np.random.Generator
) -> Float[np.ndarray, "draws dims"]:
    """Weighted block bootstrap: exponential weights on the patches.

    Source: Rubin 1981, The Bayesian bootstrap.
    """
    counts = np.asarray(cells.counts, float)
    draws = []
    for _ in range(_RESAMPLES):
        linear = weighted_map(cells, counts * rng.standard_exponential(len(counts)))
        draws.append(contrasts.matrix @ (contrasts.estimate + linear @ cells.residuals_m))
    return np.array(draws)
