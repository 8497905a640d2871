"""From labelled cells to the cube grammar, with every plane put where its surfels are."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float

from indoorfit.errors import InputError
from indoorfit.geometry import Exposure, exposures, shape_from_plan
from indoorfit.model import Note, Plane, Shape

from .evidence import Evidence
from .passages import close_passages, open_borders, pieces_of
from .surfaces import Surfaces


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
    step_m: float = 0.08
    """Levels of ceiling or floor that differ by more are reported as a step; as for walls."""


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
    inside = close_passages(inside, links, grid, config.door_m, config.wall_m, config.min_area_m2)
    links = open_borders(inside, evidence, grid, config.partition_share, config.door_m)
    labels = pieces_of(inside, links)
    areas = np.outer(np.diff(grid[0]), np.diff(grid[1]))
    pieces = [labels == k for k in range(1, int(labels.max()) + 1)]
    pieces.sort(key=lambda mask: -areas[mask].sum())
    large = [mask for mask in pieces if areas[mask].sum() >= config.min_area_m2]
    for small in pieces[len(large) :]:
        _give_back(small, large, grid)
    # The largest piece is what was scanned, however open; others must show walls of their own.
    rooms = [mask for k, mask in enumerate(large) if k == 0 or _walled(mask, evidence, grid) >= config.walled]
    if not rooms:
        raise InputError(
            "discover: no closed piece of floor plan of at least "
            f"{config.min_area_m2:.1f} m² has ceiling or floor over it and walls around it. "
            "Fix: check --unit and --up, and that ceiling and walls were scanned."
        )
    return rooms


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
    rooms: list[Bool[np.ndarray, "nx ny"]],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    surfaces: Surfaces,
    config: RoomConfig,
) -> tuple[Shape, tuple[Note, ...]]:
    """The grammar of all rooms, and remarks on what it leaves out."""
    z_ranges_m, notes = [], []
    for mask in rooms:
        levels_m, remarks = _levels(mask, grid, surfaces, config)
        z_ranges_m.append(levels_m)
        notes += remarks
    shape = shape_from_plan(list(grid[0]), list(grid[1]), rooms, z_ranges_m)
    planes = [
        _place(plane, exposure, surfaces)
        for plane, exposure in zip(shape.planes, exposures(shape), strict=True)
    ]
    return replace(shape, planes=tuple(planes)), tuple(notes)


def _place(plane: Plane, exposure: Exposure, surfaces: Surfaces) -> Plane:
    """Move a plane to the median of the surfels on it; without any it is inferred and stays."""
    if plane.axis == 2:
        level_m = surfaces.floor_m if plane.outward < 0 else surfaces.ceiling_m
        reach_m = 0.10
    else:
        level_m, reach_m = surfaces.walls_m[plane.axis], 0.10
    near = np.abs(level_m[:, plane.axis] - plane.offset_m) < reach_m
    near[near] = exposure.contains(level_m[near])
    share = near.sum() * (surfaces.pixel_m / 2.0) ** 2 / max(exposure.area_m2, 1e-9)
    if near.sum() < 3 or share < 0.02:
        return replace(plane, status="inferred")
    return replace(plane, offset_m=float(np.median(level_m[near, plane.axis])))


def _levels(
    mask: Bool[np.ndarray, "nx ny"],
    grid: tuple[Float[np.ndarray, " nx1"], Float[np.ndarray, " ny1"]],
    surfaces: Surfaces,
    config: RoomConfig,
) -> tuple[tuple[float, float], list[Note]]:
    """Floor and ceiling height of one room, and a note for every further level of note."""
    notes: list[Note] = []
    chosen = []
    for name, points_m, fallback_m in (
        ("floor", surfaces.floor_m, surfaces.floor_height_m),
        ("ceiling", surfaces.ceiling_m, surfaces.ceiling_height_m),
    ):
        i = np.searchsorted(grid[0], points_m[:, 0]) - 1
        j = np.searchsorted(grid[1], points_m[:, 1]) - 1
        over = np.pad(mask, ((0, 1), (0, 1)))[np.clip(i, -1, mask.shape[0]), np.clip(j, -1, mask.shape[1])]
        levels = _level_areas(points_m[over, 2], config.step_m, (surfaces.pixel_m / 2.0) ** 2)
        main_m = levels[0][0] if levels else fallback_m
        chosen.append(main_m)
        for level_m, area_m2 in levels[1:]:
            # A tenth of the main level is more than shelves and lamps make up.
            if area_m2 >= max(0.1 * levels[0][1], config.min_area_m2):
                notes.append(
                    Note(
                        f"{name.upper()}_STEP",
                        f"{area_m2:.1f} m² of the {name} lie {abs(level_m - main_m):.2f} m "
                        f"{'above' if level_m > main_m else 'below'} its main level. The model has one "
                        f"{name} a room, at the main level: the volume is off by the step.",
                    )
                )
    return (chosen[0], chosen[1]), notes


def _level_areas(
    heights_m: Float[np.ndarray, " n"], step_m: float, area_m2: float
) -> list[tuple[float, float]]:
    """Levels as (height, area), largest first; each level takes what lies within one step of its peak."""
    levels: list[tuple[float, float]] = []
    left = np.sort(heights_m)
    while len(left):
        counts = np.searchsorted(left, left + step_m, side="right") - np.arange(len(left))
        k = int(np.argmax(counts))
        member = np.zeros(len(left), bool)
        member[k : k + counts[k]] = True
        level_m = float(np.median(left[member]))
        levels.append((level_m, area_m2 * float(counts[k])))
        left = left[np.abs(left - level_m) > step_m]
    return sorted(levels, key=lambda level: -level[1])
