"""From labelled cells to the cube grammar, with every plane put where its surfels are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.errors import InputError
from indoorfit.geometry import (
    Level,
    shape_from_plan,
    walls_at,
    with_levels,
    with_oblique_wall,
)
from indoorfit.model import Note, Shape

from .candidates import CandidateConfig
from .cuts import Cut
from .evidence import Evidence
from .labelling import LabelConfig
from .level_task import KINDS, Grid, Kind, LevelConfig, LevelTask, refined
from .levels import RoomLevels, find_levels, level_cells
from .outline import Outline
from .passages import Passage, close_passages, open_borders, pieces_of
from .placing import placed
from .surfaces import Surfaces

_NOTABLE_M2 = 1.0
"""Levels of less area than this are not worth a warning."""

_LOOKED_INTO = 0.1
"""Least share of a room that lines of sight passed before any opening. Rooms where the sensor stood, if only
behind the door, show more, others nothing."""


@dataclass(frozen=True)
class RoomConfig:
    """What counts as a room and as an observed face."""

    min_area_m2: float = 1.0
    """Smaller pieces of floor plan are window niches and glimpses, not rooms."""
    walled: float = 0.5
    """Least share of the outline on which a second room shows wall: half. A room seen through a door
    shows the wall opposite and little else."""
    partition_share: float = 0.6
    """Two inside cells are apart where their border shows at least this share of wall: more than a
    wardrobe against a wall adds, less than a partition with a door leaves."""
    door_m: float = 1.5
    """Openings in a wall up to this clear width are doors between two rooms (a double door has 1.4 m);
    wider ones make one room of the two."""
    wall_m: float = 0.5
    """Greatest thickness of a wall that a door leads through: old masonry; plans since 1900 have less."""


def split_rooms(
    inside: Bool[np.ndarray, "nx ny"],
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    config: RoomConfig,
) -> list[Bool[np.ndarray, "nx ny"]]:
    """Edge-connected pieces of the inside, cut where wall was seen; largest first.

    Raises:
        InputError: nothing of the size of a room.
    """
    links = open_borders(inside, evidence, grid, config.partition_share, config.door_m)
    limits = Passage(config.door_m, config.wall_m, config.partition_share)
    inside = close_passages(inside, links, evidence, grid, limits, config.min_area_m2)
    links = open_borders(inside, evidence, grid, config.partition_share, config.door_m)
    labels = pieces_of(inside, links)
    areas = np.outer(np.diff(grid[0]), np.diff(grid[1]))
    pieces = [labels == k for k in range(1, int(labels.max()) + 1)]
    pieces.sort(key=lambda mask: -areas[mask].sum())
    large = [mask for mask in pieces if areas[mask].sum() >= config.min_area_m2]
    for small in pieces[len(large) :]:
        _give_back(small, large, grid)
    large = _looked_into(large, evidence, areas)
    # The largest piece is what was scanned, however open; others must show walls of their own.
    rooms = [mask for k, mask in enumerate(large) if k == 0 or _walled(mask, evidence, grid) >= config.walled]
    if not rooms:
        raise InputError(
            "discover: no closed piece of floor plan of at least "
            f"{config.min_area_m2:.1f} m² has ceiling or floor over it and walls around it. "
            "Fix: check --unit and --up, and that ceiling and walls were scanned."
        )
    return rooms


def _looked_into(
    pieces: list[Bool[np.ndarray, "nx ny"]], evidence: Evidence, areas: Float[np.ndarray, "nx ny"]
) -> list[Bool[np.ndarray, "nx ny"]]:
    """Those pieces that lines of sight passed before any opening; all where they are not known.

    What the sensor saw through doors and windows only is not what was scanned, however large it is.
    """
    if evidence.free is None:
        return pieces
    air = evidence.free.air
    found = [mask for mask in pieces if np.average(air[mask], weights=areas[mask]) >= _LOOKED_INTO]
    return found or pieces


def _give_back(
    small: Bool[np.ndarray, "nx ny"],
    large: list[Bool[np.ndarray, "nx ny"]],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
) -> None:
    """Join a piece too small for a room to its longest neighbour: what cut it off was a cupboard's front."""
    contacts = [_contact_m(small, other, grid) for other in large]
    if contacts and max(contacts) > 0.0:
        k = int(np.argmax(contacts))
        large[k] = large[k] | small


def _contact_m(
    first: Bool[np.ndarray, "nx ny"],
    second: Bool[np.ndarray, "nx ny"],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
) -> float:
    """Length of the border that two sets of cells share."""
    across_x = (first[1:] & second[:-1]) | (first[:-1] & second[1:])
    across_y = (first[:, 1:] & second[:, :-1]) | (first[:, :-1] & second[:, 1:])
    return float((across_x @ np.diff(grid[1])).sum() + (np.diff(grid[0]) @ across_y).sum())


def _walled(
    mask: Bool[np.ndarray, "nx ny"],
    evidence: Evidence,
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
) -> float:
    """Share of the outline on which wall was seen."""
    padded = np.pad(mask, 1)
    outline_x = padded[1:, 1:-1] != padded[:-1, 1:-1]
    outline_y = padded[1:-1, 1:] != padded[1:-1, :-1]
    lengths_x = outline_x * np.diff(grid[1])[None, :]
    lengths_y = outline_y * np.diff(grid[0])[:, None]
    seen = np.sum(lengths_x * evidence.walls[0]) + np.sum(lengths_y * evidence.walls[1])
    return float(seen / (lengths_x.sum() + lengths_y.sum()))


def build_shape(
    outline: Outline,
    cuts: Sequence[Cut],
    surfaces: Surfaces,
    candidates: CandidateConfig,
    labels: LabelConfig,
    price: float,
    config: LevelConfig,
) -> tuple[Shape, tuple[Note, ...]]:
    """The grammar of all rooms, and remarks on what it leaves out.

    Args:
        outline: cells of each room.
        cuts: corners that oblique walls cut off; the cells know nothing of them.
        surfaces: sorted evidence.
        candidates: where the edges of levels may be, as `widened` for this scan.
        labels: chances of seeing what is there.
        price: of one parameter, nats.
        config: what counts as a level.
    """
    rooms, grid = outline.rooms, outline.grid
    found: list[tuple[RoomLevels, RoomLevels]] = []
    for mask in rooms:
        tasks = (LevelTask(on, mask, grid, surfaces, candidates, labels, price) for on in KINDS)
        fallback_m = (surfaces.floor_height_m, surfaces.ceiling_height_m)
        floor, ceiling = (find_levels(task, z_m, config) for task, z_m in zip(tasks, fallback_m, strict=True))
        found.append((floor, ceiling))
    shape = _cut_off(_stacked(rooms, grid, found), cuts, candidates.merge_m)
    notes = [
        note for pair in found for on, levels in zip(KINDS, pair, strict=True) for note in _odd(on, levels)
    ]
    return placed(shape, surfaces, outline), tuple(notes)


def _stacked(
    rooms: list[Bool[np.ndarray, "nx ny"]], grid: Grid, found: list[tuple[RoomLevels, RoomLevels]]
) -> Shape:
    """Rooms between their outermost levels, minus what lies between these and the others."""
    pieces = [piece for pair in found for levels in pair for piece in levels.others]
    finer: Grid = (
        np.unique(np.concatenate([grid[0], *(piece.grid[0] for piece in pieces)])),
        np.unique(np.concatenate([grid[1], *(piece.grid[1] for piece in pieces)])),
    )
    masks = [refined(mask, grid, finer) for mask in rooms]
    z_ranges_m, levels = [], []
    for k, (mask, pair) in enumerate(zip(masks, found, strict=True)):
        ends = []
        for on, room_levels in zip(KINDS, pair, strict=True):
            cells = level_cells(room_levels, mask, finer)
            outermost_m = (min if on == "floor" else max)(cells)
            ends.append(outermost_m)
            levels += [Level(k, on, z_m, at) for z_m, at in cells.items() if z_m != outermost_m]
        z_ranges_m.append((ends[0], ends[1]))
    shape = shape_from_plan(list(grid[0]), list(grid[1]), rooms, z_ranges_m)
    return with_levels(shape, list(finer[0]), list(finer[1]), masks, levels)


def _cut_off(shape: Shape, cuts: Sequence[Cut], least_m: float) -> Shape:
    """The shape with oblique walls; a corner that belongs to no room after all stays as it is.

    A wall of which hardly anything is left, less than two walls are apart, is replaced by the oblique one.
    """
    for cut in cuts:
        between = walls_at(shape, cut.corner)
        if between is not None:
            shape = with_oblique_wall(shape, between, cut.yaw_rad, cut.offset_m, cut.opens, least_m)
    return shape


def _odd(on: Kind, levels: RoomLevels) -> list[Note]:
    """A note for every level of note that could not be modelled."""
    total_m2 = levels.area_m2
    return [
        Note(
            f"{on.upper()}_STEP",
            f"{area_m2:.1f} m² of the {on} lie {abs(level_m - levels.main_m):.2f} m "
            f"{'above' if level_m > levels.main_m else 'below'} its main level, hanging or standing free "
            "or without a clear outline, and are not in the model. Fix: look at the scan there; if they are "
            "part of the building, the volume is off by them.",
        )
        for level_m, area_m2 in levels.unexplained
        # A tenth of the main level is more than shelves and lamps make up.
        if area_m2 >= max(0.1 * total_m2, _NOTABLE_M2)
    ]
