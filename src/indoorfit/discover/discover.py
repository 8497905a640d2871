"""Discovery of the cube grammar as one stated optimisation over the cells of the plan."""

from dataclasses import dataclass, field

from indoorfit.errors import InputError
from indoorfit.model import FaceClass, Note, Segments, Shape, Surfels

from .candidates import CandidateConfig, candidate_lines
from .evidence import gather_evidence
from .labelling import LabelConfig, label_cells, price_of_one
from .level_task import LevelConfig
from .rooms import RoomConfig, build_shape, split_rooms
from .surfaces import find_surfaces
from .world import WorldConfig, world_notes


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

    Returns:
        the grammar with a first position for every plane, rooms by decreasing area; remarks.

    Raises:
        InputError: no walls, no floor, or no closed room.
    """
    surfaces = find_surfaces(surfels, segments, classes)
    lines = candidate_lines(surfaces, config.candidates)
    for axis, found in zip("xy", lines, strict=True):
        if len(found.offsets_m) < 2:
            raise InputError(
                f"discover: {len(found.offsets_m)} wall position(s) across {axis}, a room needs two. "
                "Fix: scan the whole room, floor and ceiling included, so that unseen walls can be inferred."
            )
    evidence = gather_evidence(surfaces, lines)
    grid = (lines[0].offsets_m, lines[1].offsets_m)
    seen_m2 = surfels.area_m2 * len(surfels.positions_m)
    inside, plan_notes = label_cells(evidence, grid, seen_m2, config.labels)
    rooms = split_rooms(inside, evidence, grid, config.rooms)
    price = price_of_one(seen_m2, config.labels)
    shape, notes = build_shape(rooms, grid, surfaces, config.labels, price, config.levels)
    return shape, (*world_notes(segments, config.world), *plan_notes, *notes)
