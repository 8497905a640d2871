"""From surfaces to rooms in the plan: candidates, evidence, labels. Discovery and explanation share it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from indoorfit.errors import InputError
from indoorfit.model import Note

from .candidates import CandidateConfig, Lines, candidate_lines
from .evidence import Evidence, gather_evidence
from .labelling import Borders, LabelConfig, label_cells
from .level_task import Grid
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
    evidence: Evidence
    forced: Borders
    """Borders that a person said are wall."""
    forbidden: Borders
    """Borders that a person said are none."""
    seen_m2: float
    """Area of all surfaces that were seen."""
    inside: Bool[np.ndarray, "nx ny"]
    """The labels of least energy."""
    rooms: list[Bool[np.ndarray, "nx ny"]]
    """What became of the inside: the cells of each room, by decreasing area."""
    notes: tuple[Note, ...]

    @property
    def grid(self) -> Grid:
        """Positions of the lines, metres."""
        return self.lines[0].offsets_m, self.lines[1].offsets_m

    @property
    def room_of_cell(self) -> Int[np.ndarray, "nx ny"]:
        """Number of each cell's room, 0 outside."""
        return _numbered(self.rooms)


def find_plan(
    surfaces: Surfaces,
    seen_m2: float,
    candidates: CandidateConfig,
    labels: LabelConfig,
    rooms: RoomConfig,
    overrides: PlanOverrides,
) -> Plan:
    """Decide which cells belong to which room.

    Args:
        surfaces: sorted evidence, Manhattan frame.
        seen_m2: area of all surfaces that were seen.
        candidates, labels, rooms: settings of the three steps.
        overrides: walls that a person forced or forbade.

    Raises:
        InputError: no closed room.
        ConfigError: an override that cannot be meant.
    """
    lines = candidate_lines(surfaces, candidates)
    lines = with_forced(lines, overrides.forced, surfaces, candidates.merge_m)
    for axis, found in zip("xy", lines, strict=True):
        if len(found.offsets_m) < 2:
            raise InputError(
                f"discover: {len(found.offsets_m)} wall position(s) across {axis}, a room needs two. "
                "Fix: scan the whole room, floor and ceiling included, so that unseen walls can be inferred."
            )
    forced, forbidden = borders_of(lines, overrides.forced), forbidden_borders(lines, overrides.forbidden)
    evidence = overridden_evidence(gather_evidence(surfaces, lines), forced, forbidden)
    grid = (lines[0].offsets_m, lines[1].offsets_m)
    inside, notes = label_cells(evidence, grid, seen_m2, labels, forbidden)
    found_rooms = split_rooms(inside, evidence, grid, rooms)
    notes = (*override_notes(overrides, lines, _numbered(found_rooms)), *notes)
    return Plan(lines, evidence, forced, forbidden, seen_m2, inside, found_rooms, notes)


def _numbered(rooms: list[Bool[np.ndarray, "nx ny"]]) -> Int[np.ndarray, "nx ny"]:
    number = np.zeros(rooms[0].shape, int)
    for k, mask in enumerate(rooms):
        number[mask] = k + 1
    return number
