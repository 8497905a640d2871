"""Is it a Manhattan world at all? What does not fit is named, never squared in silence."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from indoorfit.model import FaceClass, Note, Segments


@dataclass(frozen=True)
class WorldConfig:
    """From which size on other directions are worth a warning."""

    min_segment_m2: float = 2.0
    """Smaller pieces are furniture and open doors (a leaf has 1.6 m²); a wall of this size is 0.8 m wide.
    Larger ones that follow neither axis are walls of neither, and warned of where they are not modelled."""
    min_oblique_m2: float = 0.5
    """Smaller pieces are no oblique walls: one of 20 cm from floor to ceiling has this size."""
    min_share: float = 0.05
    """Least share of upright (or overhead) surface in another direction that is named."""
    off_axis_deg: float = 8.0
    """Off by more than this is another direction: hand-built walls are off by one or two degrees, and
    slipped frames by a few."""
    furniture_m2: float = 4.0
    """A level surface between floor and ceiling that is larger is named: no table or bed (2 m by 2 m) is."""


def oblique_segments(
    segments: Segments, config: WorldConfig, least_m2: float
) -> Bool[np.ndarray, " segments"]:
    """Upright pieces that follow neither axis.

    Args:
        segments: Manhattan frame.
        config: see `WorldConfig`.
        least_m2: smaller ones are left out.
    """
    off_axis = np.abs(segments.normals).max(axis=1, initial=0.0) < np.cos(np.deg2rad(config.off_axis_deg))
    upright = np.abs(segments.normals[:, 2]) < np.sin(np.deg2rad(config.off_axis_deg))
    return off_axis & upright & (segments.areas_m2 >= least_m2)


def square_classes(
    segments: Segments, classes: tuple[FaceClass | None, ...], config: WorldConfig
) -> tuple[FaceClass | None, ...]:
    """The classes without those of large pieces of wall that follow neither axis.

    The table of classes is wide, for small pieces whose normals are noisy. Those of large ones are not: ten
    degrees are another direction.
    """
    oblique = oblique_segments(segments, config, config.min_segment_m2)
    return tuple(None if askew else name for name, askew in zip(classes, oblique, strict=True))


def world_notes(
    segments: Segments,
    classes: tuple[FaceClass | None, ...],
    config: WorldConfig,
    modelled: Int[np.ndarray, " _"],
) -> tuple[Note, ...]:
    """Warn of oblique walls, of sloped or vaulted surfaces overhead, and of floors half-way up.

    Args:
        segments: Manhattan frame.
        classes: of these segments.
        config: see `WorldConfig`.
        modelled: oblique segments that are walls of the model.
    """
    large = segments.areas_m2 >= config.min_segment_m2
    normals, areas_m2 = segments.normals[large], segments.areas_m2[large]
    heights_m = segments.centres_m[large, 2]
    limit = np.cos(np.deg2rad(config.off_axis_deg))
    along = np.abs(normals).max(axis=1, initial=0.0)
    upright = np.abs(normals[:, 2]) < np.sin(np.deg2rad(config.off_axis_deg))
    missing = oblique_segments(segments, config, config.min_segment_m2)
    missing[modelled] = False
    oblique = missing[large]
    sloped = ~upright & (along < limit) & (heights_m > 0.0)
    overhead = sloped | ((np.abs(normals[:, 2]) >= limit) & (heights_m > 0.0))
    return (
        *_note("OBLIQUE_WALLS", "upright", "model's wall directions", oblique, upright, areas_m2, config),
        *_note("SLOPED_CEILING", "overhead", "level plane", sloped, overhead, areas_m2, config),
        *_half_way(segments, classes, limit, config),
    )


def _half_way(
    segments: Segments, classes: tuple[FaceClass | None, ...], limit: float, config: WorldConfig
) -> tuple[Note, ...]:
    """Warn of level surfaces larger than furniture that are neither floor nor ceiling."""
    unused = np.array([name is None for name in classes], bool)
    unused &= (np.abs(segments.normals[:, 2]) >= limit) & (segments.areas_m2 >= config.furniture_m2)
    if not np.any(unused):
        return ()
    return (
        Note(
            "SPLIT_LEVEL",
            f"{segments.areas_m2[unused].sum():.1f} m² of level surface lie half-way between floor and "
            "ceiling and are larger than furniture: perhaps the floor of a room at another level. They are "
            "not in the model. Fix: cut the scan into parts of one level each.",
        ),
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
