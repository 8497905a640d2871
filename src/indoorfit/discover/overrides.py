"""Walls that a person forced or forbade, on the candidates and the evidence."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from indoorfit.errors import ConfigError
from indoorfit.model import Note

from .candidates import Lines
from .evidence import Evidence
from .labelling import Borders
from .surfaces import Surfaces

_REACH_M = 0.10
"""A forbidden wall is the nearest candidate within this distance: a person's click on a scan is no better,
and the thesis takes walls within 10 cm for one."""


@dataclass(frozen=True)
class WallStretch:
    """A stretch of an upright plane in the plan, Manhattan frame, metres."""

    axis: int
    """Perpendicular to x (0) or y (1)."""
    position_m: float
    low_m: float = -np.inf
    """Where it begins along the other axis; by default it has no ends."""
    high_m: float = np.inf

    @property
    def text(self) -> str:
        """For messages."""
        ends = f" from {self.low_m:.2f} to {self.high_m:.2f} m" if np.isfinite(self.low_m) else ""
        return f"{'xy'[self.axis]} = {self.position_m:.3f} m{ends}"


@dataclass(frozen=True)
class PlanOverrides:
    """What a person said of the plan."""

    forbidden: tuple[WallStretch, ...] = ()
    forced: tuple[WallStretch, ...] = ()


def with_forced(
    lines: tuple[Lines, Lines], forced: Sequence[WallStretch], surfaces: Surfaces, merge_m: float
) -> tuple[Lines, Lines]:
    """The candidates with those of the forced walls among them.

    Args:
        lines: candidates along x, along y.
        forced: of the person.
        surfaces: what was seen; a forced wall must lie within it.
        merge_m: nearer candidates are the same; where wall was seen, the seen position stays.

    Raises:
        ConfigError: a forced wall outside of everything that was scanned.
    """
    everything = [*surfaces.walls_m, surfaces.floor_m, surfaces.ceiling_m]
    points_m = np.concatenate(everything)[:, :2]
    low_m, high_m = points_m.min(axis=0) - merge_m, points_m.max(axis=0) + merge_m
    found = list(lines)
    for wall in forced:
        across, along = wall.axis, 1 - wall.axis
        if not (low_m[across] <= wall.position_m <= high_m[across]) or (
            wall.high_m < low_m[along] or wall.low_m > high_m[along]
        ):
            raise ConfigError(
                f"overrides.force_wall: {wall.text} is outside of the room: surfaces were seen for "
                f"x from {low_m[0]:.2f} to {high_m[0]:.2f} m and y from {low_m[1]:.2f} to {high_m[1]:.2f} m "
                "(Manhattan frame). Fix: `indoorfit explain` draws the plan with its coordinates."
            )
        found[across] = _with_line(found[across], wall.position_m, merge_m)
    return found[0], found[1]


def _with_line(lines: Lines, position_m: float, merge_m: float) -> Lines:
    gaps_m = np.abs(lines.offsets_m - position_m)
    k = int(np.argmin(gaps_m)) if len(gaps_m) else 0
    if len(gaps_m) and gaps_m[k] < merge_m:
        if lines.seen[k]:
            return lines
        offsets_m = lines.offsets_m.copy()
        offsets_m[k] = position_m
        return replace(lines, offsets_m=offsets_m)
    return lines.with_unseen(np.array([position_m]))


def borders_of(lines: tuple[Lines, Lines], walls: Sequence[WallStretch]) -> Borders:
    """The borders of the cells along the walls' nearest candidates: those that a wall covers by half."""
    n_x, n_y = (len(line.offsets_m) for line in lines)
    chosen = (np.zeros((n_x, n_y - 1), bool), np.zeros((n_x - 1, n_y), bool))
    for wall in walls:
        k = int(np.argmin(np.abs(lines[wall.axis].offsets_m - wall.position_m)))
        ends_m = lines[1 - wall.axis].offsets_m
        covered_m = np.minimum(ends_m[1:], wall.high_m) - np.maximum(ends_m[:-1], wall.low_m)
        row = covered_m >= 0.5 * np.diff(ends_m)
        np.moveaxis(chosen[wall.axis], wall.axis, 0)[k] |= row
    return chosen


def forbidden_borders(lines: tuple[Lines, Lines], walls: Sequence[WallStretch]) -> Borders:
    """The borders that may be no wall.

    Raises:
        ConfigError: no candidate is near a forbidden wall.
    """
    for wall in walls:
        offsets_m = lines[wall.axis].offsets_m
        nearest_m = float(offsets_m[np.argmin(np.abs(offsets_m - wall.position_m))])
        if abs(nearest_m - wall.position_m) > _REACH_M:
            raise ConfigError(
                f"overrides.forbid_wall: no candidate within {_REACH_M:.2f} m of {wall.text}, the nearest "
                f"is at {nearest_m:.3f} m. Fix: give one of the candidates that `indoorfit explain` lists."
            )
    return borders_of(lines, walls)


def overridden_evidence(evidence: Evidence, forced: Borders, forbidden: Borders) -> Evidence:
    """Forced walls as seen on their whole area and passed by no look, forbidden ones as never seen."""
    walls, lintels = (
        tuple(
            np.where(no, 0.0, np.where(yes, 1.0, share))
            for share, yes, no in zip(shares, forced, forbidden, strict=True)
        )
        for shares in (evidence.walls, evidence.lintels)
    )
    free = evidence.free
    if free is not None:
        passed, over = (
            tuple(np.where(yes, 0.0, share) for share, yes in zip(shares, forced, strict=True))
            for shares in (free.walls, free.over)
        )
        free = replace(free, walls=(passed[0], passed[1]), over=(over[0], over[1]))
    return replace(evidence, walls=(walls[0], walls[1]), lintels=(lintels[0], lintels[1]), free=free)


def outlines(room: Int[np.ndarray, "nx ny"]) -> Borders:
    """The borders on which a room ends.

    Args:
        room: number of each cell's room, 0 outside.
    """
    padded = np.pad(room, 1)
    return padded[1:, 1:-1] != padded[:-1, 1:-1], padded[1:-1, 1:] != padded[1:-1, :-1]


def override_notes(
    overrides: PlanOverrides,
    lines: tuple[Lines, Lines],
    room: Int[np.ndarray, "nx ny"],
) -> tuple[Note, ...]:
    """What was forced and forbidden, and whether the plan could follow."""
    if not overrides.forbidden and not overrides.forced:
        return ()
    ends = outlines(room)
    told = []
    for verb, walls in (("forbidden", overrides.forbidden), ("forced", overrides.forced)):
        for wall in walls:
            length_m = _length_m(borders_of(lines, [wall]), ends, lines)
            if verb == "forbidden":
                outcome = (
                    "no wall runs there" if length_m == 0 else f"yet {length_m:.2f} m of wall remain there"
                )
            elif length_m > 0:
                outcome = f"it bounds rooms on {length_m:.2f} m"
            else:
                outcome = "yet no room could end there: it closes nothing off, or lies outside of every room"
            told.append(f"wall {wall.text} {verb}: {outcome}")
    return (Note("OVERRIDDEN", f"The plan is not the scan's alone. {'; '.join(told)}."),)


def _length_m(chosen: Borders, ends: Borders, lines: tuple[Lines, Lines]) -> float:
    lengths_m: tuple[Float[np.ndarray, "1 ny"], Float[np.ndarray, "nx 1"]] = (
        np.diff(lines[1].offsets_m)[None, :],
        np.diff(lines[0].offsets_m)[:, None],
    )
    both: list[Bool[np.ndarray, "_ _"]] = [a & b for a, b in zip(chosen, ends, strict=True)]
    return float(sum(np.sum(one * length_m) for one, length_m in zip(both, lengths_m, strict=True)))
