"""What the search for levels works on, and the cells of a plan on finer grids."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from .candidates import CandidateConfig
from .labelling import LabelConfig
from .surfaces import Surfaces

Grid = tuple[Float[np.ndarray, " _"], Float[np.ndarray, " _"]]
Kind = Literal["floor", "ceiling"]
KINDS: tuple[Kind, Kind] = ("floor", "ceiling")


@dataclass(frozen=True)
class LevelConfig:
    """What counts as another level of a floor or a ceiling."""

    step_m: float = 0.08
    """Levels that differ by more are two, as for walls, and by more still where floor and ceiling scatter;
    what floors are out of level is less."""
    min_area_m2: float = 0.3
    """Least area of a level: a tread, or a beam of 10 cm over 3 m. Lamps and shelves are smaller."""
    max_levels: int = 18
    """Most levels of one floor or ceiling: a stair from storey to storey has no more treads (DIN 18065: at
    most 18 in one flight). More heights than that are a slope, a vault or noise, and none is a level."""
    walkable_m: float = 0.8
    """Least width of a platform that does not reach from wall to wall: what one can walk on (DIN 18065 asks
    80 cm of stairs). Narrower boxes on the floor are furniture."""
    max_rise_m: float = 0.21
    """Highest rise of such a platform: what one can step on (DIN 18065). Beds and chests are higher."""


@dataclass(frozen=True)
class FoundLevel:
    """One connected piece of a level."""

    on: Kind
    offset_m: float
    grid: Grid
    cells: Bool[np.ndarray, "nx ny"]


@dataclass(frozen=True)
class LevelTask:
    """Where to look."""

    on: Kind
    mask: Bool[np.ndarray, "nx ny"]
    """The room's cells."""
    grid: Grid
    surfaces: Surfaces
    candidates: CandidateConfig
    """As `widened` for this scan."""
    labels: LabelConfig
    price: float
    """Of one parameter (nats)."""

    @property
    def points_m(self) -> Float[np.ndarray, "n 3"]:
        """Level surfels over the room."""
        on_floor = self.on == "floor"
        level_m = self.surfaces.floor_m if on_floor else self.surfaces.ceiling_m
        middle_m = 0.5 * (self.surfaces.floor_height_m + self.surfaces.ceiling_height_m)
        # What is in the other half of the height is neither; segments of a vault reach down to it.
        level_m = level_m[(level_m[:, 2] < middle_m) == on_floor]
        return level_m[within(level_m, self.grid, self.mask)]


def within(points_m: Float[np.ndarray, "n 3"], grid: Grid, mask: Bool[np.ndarray, "nx ny"]) -> np.ndarray:
    """Which points lie over cells of the mask; (n,) bool."""
    i = np.searchsorted(grid[0], points_m[:, 0], side="right")
    j = np.searchsorted(grid[1], points_m[:, 1], side="right")
    return np.pad(mask, 1)[i, j]


def refined(mask: Bool[np.ndarray, "nx ny"], grid: Grid, finer: Grid) -> Bool[np.ndarray, "mx my"]:
    """The same cells on a grid that has all lines of the first and others."""
    x, y = (0.5 * (line[1:] + line[:-1]) for line in finer)
    i, j = np.searchsorted(grid[0], x, side="right"), np.searchsorted(grid[1], y, side="right")
    return np.pad(mask, 1)[np.ix_(i, j)]
