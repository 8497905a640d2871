"""Is it a Manhattan world at all? What does not fit is named, never squared in silence."""

from dataclasses import dataclass

import numpy as np

from indoorfit.model import Note, Segments


@dataclass(frozen=True)
class WorldConfig:
    """From which size on other directions are worth a warning."""

    min_segment_m2: float = 2.0
    """Smaller pieces are furniture and open doors (a leaf has 1.6 m²); a wall of this size is 0.8 m wide."""
    min_share: float = 0.05
    """Least share of upright (or overhead) surface in another direction that is named."""
    off_axis_deg: float = 8.0
    """Off by more than this is another direction: hand-built walls are off by one or two degrees, and
    slipped frames by a few."""


def world_notes(segments: Segments, config: WorldConfig) -> tuple[Note, ...]:
    """Warn of oblique walls and of sloped or vaulted surfaces overhead.

    Args:
        segments: Manhattan frame.
        config: see `WorldConfig`.
    """
    large = segments.areas_m2 >= config.min_segment_m2
    normals, areas_m2 = segments.normals[large], segments.areas_m2[large]
    heights_m = segments.centres_m[large, 2]
    limit = np.cos(np.deg2rad(config.off_axis_deg))
    along = np.abs(normals).max(axis=1, initial=0.0)
    upright = np.abs(normals[:, 2]) < np.sin(np.deg2rad(config.off_axis_deg))
    oblique = upright & (along < limit)
    sloped = ~upright & (along < limit) & (heights_m > 0.0)
    overhead = sloped | ((np.abs(normals[:, 2]) >= limit) & (heights_m > 0.0))
    return (
        *_note("OBLIQUE_WALLS", "upright", "two wall directions", oblique, upright, areas_m2, config),
        *_note("SLOPED_CEILING", "overhead", "level plane", sloped, overhead, areas_m2, config),
    )


def _note(
    code: str,
    where: str,
    expected: str,
    odd: np.ndarray,
    among: np.ndarray,
    areas_m2: np.ndarray,
    config: WorldConfig,
) -> tuple[Note, ...]:
    odd_m2, all_m2 = float(areas_m2[odd].sum()), float(areas_m2[among].sum())
    if odd_m2 < config.min_share * max(all_m2, 1e-9):
        return ()
    return (
        Note(
            code,
            f"Not a Manhattan world: {odd_m2:.1f} m² ({100 * odd_m2 / all_m2:.0f} %) of the {where} surfaces "
            f"do not follow the {expected}. They are not in the model, which is wrong where they are.",
        ),
    )
