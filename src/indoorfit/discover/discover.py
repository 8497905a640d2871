"""Discovery of the cube grammar as one stated optimisation over the cells of the plan."""

from dataclasses import dataclass, field

import numpy as np

from indoorfit.model import FaceClass, Note, Rays, Segments, Shape, Surfels

from .candidates import CandidateConfig
from .labelling import LabelConfig, price_of_one
from .level_task import LevelConfig
from .oblique import oblique_lines
from .overrides import PlanOverrides
from .planning import Plan, find_plan
from .rooms import RoomConfig, build_shape
from .surfaces import Surfaces, find_surfaces
from .world import WorldConfig, square_classes, world_notes

_NO_OVERRIDES = PlanOverrides()


@dataclass(frozen=True)
class DiscoverConfig:
    """How walls become rooms."""

    candidates: CandidateConfig = field(default_factory=CandidateConfig)
    """Where walls may be."""
    labels: LabelConfig = field(default_factory=LabelConfig)
    """Which cells are inside."""
    rooms: RoomConfig = field(default_factory=RoomConfig)
    """What is a room."""
    levels: LevelConfig = field(default_factory=LevelConfig)
    """What is another level of floor or ceiling."""
    world: WorldConfig = field(default_factory=WorldConfig)
    """What is not Manhattan."""


def discover(
    surfels: Surfels,
    segments: Segments,
    classes: tuple[FaceClass | None, ...],
    config: DiscoverConfig,
    overrides: PlanOverrides = _NO_OVERRIDES,
    rays: Rays | None = None,
) -> tuple[Shape, tuple[Note, ...]]:
    """Find rooms, notches, nested notches and pillars, and the levels of their floors and ceilings.

    Candidate walls cut the plan into cells; which cells are inside is the exact minimum of one energy
    (`label_cells`); the cubes follow from the inside (`shape_from_plan`). Levels are found in the same way in
    each room's plan.

    Args:
        surfels: Manhattan frame.
        segments: of these surfels.
        classes: of these segments.
        config: see `DiscoverConfig`.
        overrides: walls that a person forced or forbade.
        rays: lines of sight, Manhattan frame, where the sensor's places are known.

    Returns:
        the grammar with a first position for every plane, rooms by decreasing area; remarks.

    Raises:
        InputError: no walls, no floor, or no closed room.
        ConfigError: an override that cannot be meant.
    """
    classes = square_classes(segments, classes, config.world)
    surfaces, plan = planned(surfels, segments, classes, config, overrides, rays)
    price = price_of_one(_seen_m2(surfels), config.labels)
    shape, notes = build_shape(
        plan.outline, plan.cuts, surfaces, plan.candidates, config.labels, price, config.levels
    )
    # A corner that belongs to no room in the end is not cut off.
    made = {shape.planes[k].offset_m for k in shape.oblique}
    modelled = np.array([k for cut in plan.cuts if cut.offset_m in made for k in cut.line.segments], int)
    return shape, (*world_notes(segments, classes, config.world, modelled), *plan.notes, *notes)


def planned(
    surfels: Surfels,
    segments: Segments,
    classes: tuple[FaceClass | None, ...],
    config: DiscoverConfig,
    overrides: PlanOverrides,
    rays: Rays | None,
) -> tuple[Surfaces, Plan]:
    """The sorted evidence and the plan; arguments and errors as for `discover`, but square classes."""
    surfaces = find_surfaces(surfels, segments, classes)
    oblique = oblique_lines(surfels, segments, classes, surfaces, config.candidates.merge_m, config.world)
    settings = (config.candidates, config.labels, config.rooms)
    return surfaces, find_plan(surfaces, oblique, _seen_m2(surfels), *settings, overrides, rays)


def _seen_m2(surfels: Surfels) -> float:
    """Area of all surfaces that were seen."""
    return surfels.area_m2 * len(surfels.positions_m)
