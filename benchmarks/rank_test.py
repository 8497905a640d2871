"""Simulation-based calibration of the sampler: the rank of the truth among its draws must be uniform.

Source: Talts et al. 2018, Validating Bayesian inference algorithms with simulation-based calibration.
"""

from typing import Any

import numpy as np
from jaxtyping import Float

from indoorfit.fitting import AssociationConfig, Cells, associate, build_cells
from indoorfit.fitting.uncertainty import SamplerConfig, WallFieldConfig
from indoorfit.fitting.uncertainty.chains import sample_chain
from indoorfit.fitting.uncertainty.field import block_covariance, build_field
from indoorfit.fitting.uncertainty.laplace import draw_student_t
from indoorfit.fitting.uncertainty.wall_field import (
    fit_wall_field,
    hyper_bounds,
    log_posteriors,
    prior_moments,
)
from indoorfit.simulate import SamplingSettings, room_shape, sample_surface

_DRAWS = 99
"""Kept from each chain, so that there are 100 ranks."""
_BINS = 10
_NAMES = ("log_tau", "log_length", "log_eta", "log_tilt")


def rank_histograms(n_rooms: int, seed: int) -> dict[str, Any]:
    """Histograms of the ranks of tau, l and eta, with a chi-square figure for each (9 degrees of freedom).

    Nothing is screened here, and all walls are alike: the prior has no contaminated patches, and the scale of
    a wall's own turns is a point estimate that the chains take as given.
    """
    config = WallFieldConfig(screen_sigmas=np.inf, wall_dof=np.inf)
    virtual = sample_surface(room_shape("L"), SamplingSettings(n_points=20_000), np.random.default_rng(seed))
    points_m = virtual.frame.to_manhattan(virtual.scan.points_m)
    data = associate(points_m, virtual.shape, AssociationConfig(patch_m=1.0), 0.1)
    cells = build_cells(data.patches, virtual.shape)
    ranks = []
    for k in range(n_rooms):
        found = _ranks(cells, config, np.random.default_rng([seed, k]))
        if found is not None:
            ranks.append(found)
    table = np.array(ranks).reshape(-1, len(_NAMES))
    counts = [np.histogram(column, bins=_BINS, range=(0, _DRAWS + 1))[0] for column in table.T]
    expected = max(len(table), 1) / _BINS
    return {
        "rooms": len(table),
        "unconverged": n_rooms - len(table),
        **{
            name: {"histogram": c.tolist(), "chi_square": float(np.sum((c - expected) ** 2) / expected)}
            for name, c in zip(_NAMES, counts, strict=True)
        },
    }


def _ranks(cells: Cells, config: WallFieldConfig, rng: np.random.Generator) -> Float[np.ndarray, " 4"] | None:
    """Ranks of one room's true scales; None where the chain did not converge."""
    means, stds = prior_moments(config)
    bounds = hyper_bounds(config)
    truth = means + stds * rng.standard_normal(4)
    while np.any((truth < bounds[:, 0]) | (truth > bounds[:, 1])):
        truth = means + stds * rng.standard_normal(4)
    residuals_m = np.empty(len(cells.plane))
    none = np.zeros(len(cells.plane))
    for block in build_field(cells).blocks:
        covariance = block_covariance(block, truth, none)
        residuals_m[block.rows] = np.linalg.cholesky(covariance) @ rng.standard_normal(len(block.rows))
    drawn = Cells(cells.plane, cells.design, cells.centroids_m, residuals_m, cells.variances_m2, cells.counts)
    fit = fit_wall_field(drawn, config)
    # Rooms from the prior have scales that the data hardly tell, and longer tails than real ones.
    sampler = SamplerConfig(walkers=24, max_steps=8000, min_effective=600.0, max_rhat=1.05)
    start: list[Float[np.ndarray, " 4"]] = []
    while len(start) < sampler.walkers:
        points, _ = draw_student_t(fit.mode, sampler.walkers, np.inf, rng)
        kept = points[np.isfinite(log_posteriors(fit, config, points))]
        start.extend(np.linalg.solve(fit.mode.root, (kept - fit.mode.point).T).T)
    chain, diagnostics = sample_chain(
        lambda white: log_posteriors(fit, config, fit.mode.point + white @ fit.mode.root.T),
        np.array(start[: sampler.walkers]),
        sampler,
        rng,
    )
    if not diagnostics.converged:
        return None
    flat = chain.reshape(-1, 4)
    picked = flat[rng.choice(len(flat), _DRAWS, replace=False)]
    return np.sum(fit.mode.point + picked @ fit.mode.root.T < truth, axis=0).astype(float)
