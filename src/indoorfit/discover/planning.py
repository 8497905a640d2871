"""From surfaces to rooms in the plan: candidates, evidence, labels. Discovery and explanation share it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int

from indoorfit.errors import InputError
from indoorfit.model import Note, Rays

from .candidates import CandidateConfig, Lines, candidate_lines, closed_where_seen_ends, told_apart, widened
from .cuts import Cut, Trial, accepted_cuts, cut_evidence, neutral, try_cuts, wall_nats
from .doubles import doubles
from .evidence import Evidence, gather_evidence
from .free_shares import free_shares
from .free_space import trace
from .guesses import guess_places
from .labelling import Borders, LabelConfig, label_cells, plan_energy, price_of_one, price_of_wall
from .level_task import Grid
from .minimise import minimise
from .oblique import ObliqueLine
from .outline import Outline
from .overrides import (
    PlanOverrides,
    borders_of,
    forbidden_borders,
    overridden_evidence,
    override_notes,
    with_forced,
)
from .rooms import RoomConfig, split_rooms
from .surfaces import Surfaces


@dataclass(frozen=True)
class Plan:
    """Everything that the decision on the plan rests on, and the decision; Manhattan frame."""

    lines: tuple[Lines, Lines]
    """Candidates along x and along y; between them lie the cells."""
    candidates: CandidateConfig
    """What made them, as `widened` for this scan; holds for its levels, too."""
    evidence: Evidence
    forced: Borders
    """Borders that a person said are wall."""
    forbidden: Borders
    """Borders that a person said are none."""
    price: float
    """Of a wall of the outline, nats."""
    inside: Bool[np.ndarray, "nx ny"]
    """The labels of least energy; corners that are cut off count as though they were square."""
    trials: tuple[Trial, ...]
    """What became of the oblique walls."""
    rooms: list[Bool[np.ndarray, "nx ny"]]
    """What became of the inside: the cells of each room, by decreasing area."""
    outline: Outline
    """The same with the walls that nobody saw where they are likeliest."""
    notes: tuple[Note, ...]

    @property
    def grid(self) -> Grid:
        """Positions of the lines, metres."""
        return self.lines[0].offsets_m, self.lines[1].offsets_m

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """The corners that oblique walls cut off."""
        return accepted_cuts(self.trials)

    @property
    def room_of_cell(self) -> Int[np.ndarray, "nx ny"]:
        """Number of each cell's room, 0 outside."""
        return _numbered(self.rooms)


def find_plan(
    surfaces: Surfaces,
    oblique: Sequence[ObliqueLine],
    seen_m2: float,
    candidates: CandidateConfig,
    labels: LabelConfig,
    rooms: RoomConfig,
    overrides: PlanOverrides,
    rays: Rays | None = None,
) -> Plan:
    """Decide which cells belong to which room.

    Args:
        surfaces: sorted evidence, Manhattan frame.
        oblique: walls that follow neither axis.
        seen_m2: area of all surfaces that were seen.
        candidates, labels, rooms: settings of the three steps.
        overrides: walls that a person forced or forbade.
        rays: lines of sight, Manhattan frame, where the sensor's places are known.

    Raises:
        InputError: no room.
        ConfigError: an override that cannot be meant.
    """
    one = price_of_one(seen_m2, labels)
    # Furniture that stands askew ends no room.
    walls = [line for line in oblique if wall_nats(line, line.ends_m, surfaces, labels) < 0.0]
    lines = candidate_lines(surfaces, told_apart(candidates, surfaces), walls)
    candidates = widened(candidates, surfaces, one)
    lines = with_forced(lines, overrides.forced, surfaces, candidates.merge_m)
    lines, partial = _two_each(lines, surfaces)
    while True:
        plan = _plan_on(lines, surfaces, oblique, candidates, labels, rooms, overrides, rays)
        pairs = doubles(
            plan.rooms, plan.lines, plan.evidence.walls, plan.forced, surfaces.scatter_m, one, labels
        )
        if not pairs:
            return replace(plan, notes=(*partial, *plan.notes))
        x, y = (
            of_axis.joined([pair[1:] for pair in pairs if pair[0] == axis])
            for axis, of_axis in enumerate(lines)
        )
        lines = x, y


def _plan_on(
    lines: tuple[Lines, Lines],
    surfaces: Surfaces,
    oblique: Sequence[ObliqueLine],
    candidates: CandidateConfig,
    labels: LabelConfig,
    rooms: RoomConfig,
    overrides: PlanOverrides,
    rays: Rays | None,
) -> Plan:
    """The best plan on some lines, two of each axis at least."""
    price = price_of_wall(lines, labels)
    forced, forbidden = borders_of(lines, overrides.forced), forbidden_borders(lines, overrides.forbidden)
    free = None if rays is None else trace(rays, surfaces, lines)
    grid = (lines[0].offsets_m, lines[1].offsets_m)

    def evidence_with(cuts: Sequence[Cut]) -> Evidence:
        seen = gather_evidence(*cut_evidence(surfaces, lines, cuts))
        if free is not None:
            seen = replace(seen, free=free_shares(free, seen, surfaces, lines))
        return overridden_evidence(neutral(seen, grid, cuts, labels), forced, forbidden)

    def solve(cuts: Sequence[Cut]) -> tuple[Bool[np.ndarray, "nx ny"], float]:
        energy = plan_energy(evidence_with(cuts), grid, price, labels, forbidden)
        inside, _ = minimise(energy, labels.max_open_cells)
        return inside, energy.of(inside)

    trials = try_cuts(lines, surfaces, oblique, solve, price, labels)
    evidence = evidence_with(accepted_cuts(trials))
    inside, notes = label_cells(evidence, grid, price, labels, forbidden)
    found_rooms = split_rooms(inside, evidence, grid, rooms)
    notes = (*override_notes(overrides, lines, _numbered(found_rooms)), *notes)
    settled = _settled(forced, accepted_cuts(trials))
    outline = guess_places(found_rooms, lines, evidence, settled, surfaces, free, candidates.merge_m, labels)
    return Plan(
        lines, candidates, evidence, forced, forbidden, price, inside, trials, found_rooms, outline, notes
    )


def _settled(forced: Borders, cuts: Sequence[Cut]) -> Borders:
    """Borders whose place is no guess, seen or not: those of forced walls and of the corners cut off."""
    settled = tuple(borders.copy() for borders in forced)
    for cut in cuts:
        for axis in (0, 1):
            np.moveaxis(settled[axis], axis, 0)[cut.at[axis]] = True
    return settled[0], settled[1]


def _two_each(lines: tuple[Lines, Lines], surfaces: Surfaces) -> tuple[tuple[Lines, Lines], tuple[Note, ...]]:
    """At least two lines of each axis: where there is one, the room is closed where the scan ends."""
    closed, notes = list(lines), []
    for axis, name in enumerate("xy"):
        found = len(lines[axis].offsets_m)
        if found == 0:
            raise InputError(
                f"discover: no wall position across {name}, a room needs two. "
                "Fix: scan the whole room, floor and ceiling included, so that unseen walls can be inferred."
            )
        if found == 1:
            closed[axis] = closed_where_seen_ends(lines[axis], surfaces, axis)
            notes.append(
                Note(
                    "PARTIAL_SCAN",
                    f"{(_ONE_SEEN if lines[axis].seen[0] else _NONE_SEEN).format(name)} The room is closed "
                    "where the scan ends, and is at least as long as that; the true length is not in its "
                    "interval. Scan the walls that are missing.",
                )
            )
    return (closed[0], closed[1]), tuple(notes)


_ONE_SEEN = "Only one wall across {} was seen."
_NONE_SEEN = "No wall across {} was seen, only where floor, ceiling or another wall ends."


def _numbered(rooms: list[Bool[np.ndarray, "nx ny"]]) -> Int[np.ndarray, "nx ny"]:
    number = np.zeros(rooms[0].shape, int)
    for k, mask in enumerate(rooms):
        number[mask] = k + 1
    return number
