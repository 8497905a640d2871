"""Why each candidate became a wall or not, with the numbers that decided."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from indoorfit.model import FaceClass, Note, Rays, Segments, Surfels

from .cuts import Trial
from .discover import DiscoverConfig, planned
from .evidence import Evidence
from .labelling import cell_costs, plan_energy
from .level_task import Grid
from .minimise import PlanEnergy, minimise
from .overrides import PlanOverrides, outlines
from .planning import Plan
from .world import square_classes

Verdict = Literal["accepted", "refused", "forbidden"]

_CHEAP_CELLS = 3_000
"""Up to so many cells the plan is labelled once more for every candidate: for 50 candidates that takes
seconds. Beyond, the differences of energy are left out."""
_COMPELLED = 1e6
"""Reward in nats that makes the outline run along one border, whatever the evidence."""


@dataclass(frozen=True)
class Beside:
    """What was seen on one side of a border."""

    ceiling: float
    """Share of the cell's area with ceiling."""
    floor: float
    log_odds: float
    """For being inside, of this cell's ceiling and floor alone, nats."""
    room: int
    """Number of its room, 0 outside."""


@dataclass(frozen=True)
class CandidateReport:
    """One candidate and what became of it; Manhattan frame, metres."""

    id: str
    """``x1``, ``x2``... in increasing order of position; ``y1``... likewise."""
    axis: int
    """The axis that the wall would be perpendicular to."""
    position_m: float
    seen: bool
    """Whether wall was seen there; else floor, ceiling or a wall ends there, or a person forced it."""
    forced: bool
    verdict: Verdict
    wall_m: float
    """Length of wall seen on it: the shares seen of its borders, times their lengths."""
    passed_m: float | None
    """The same of the stretch below the ceiling where lines of sight passed and no wall was seen; None where
    the sensor's places are not known."""
    outline_m: float
    """Length on which a room ends there."""
    outline_seen: float
    """Share of wall seen on this length; 0 where no room ends."""
    stretch_m: tuple[float, float]
    """Along the other axis: where rooms end there, else the border that speaks most for a wall."""
    beside: tuple[Beside, Beside]
    """The cells below and above that border of the candidate that speaks most for a wall."""
    difference_nats: float | None
    """Accepted: by how much the best plan without any wall on it is worse. Else: by how much the best plan
    with a wall on that border is worse. None where forbidden, or where the plan has too many cells."""
    reason: str
    """In words."""


@dataclass(frozen=True)
class Explanation:
    """The decision on the plan and what it rests on; Manhattan frame."""

    grid: Grid
    """Positions of the candidates: they bound the cells."""
    candidates: tuple[CandidateReport, ...]
    oblique: tuple[Trial, ...]
    """Walls that follow neither axis, and what became of them."""
    evidence: Evidence
    log_odds: Float[np.ndarray, "nx ny"]
    """For each cell being inside, of its ceiling and floor alone, nats."""
    inside: Bool[np.ndarray, "nx ny"]
    """The labels of least energy."""
    room: Int[np.ndarray, "nx ny"]
    """Number of each cell's room, by decreasing area, 0 outside."""
    energy_nats: float
    """Of these labels; 0 is a plan without any room."""
    corner_price_nats: float
    """What each corner of the outline costs."""
    heights_m: tuple[float, float]
    """Main levels of floor and ceiling."""
    notes: tuple[Note, ...]


def explain(
    surfels: Surfels,
    segments: Segments,
    classes: tuple[FaceClass | None, ...],
    config: DiscoverConfig,
    overrides: PlanOverrides,
    rays: Rays | None = None,
) -> Explanation:
    """Find the plan as `discover` does, and ask of every candidate what a plan with or without it would cost.

    Args:
        surfels: Manhattan frame.
        segments: of these surfels.
        classes: of these segments.
        config: see `DiscoverConfig`.
        overrides: walls that a person forced or forbade.
        rays: lines of sight, Manhattan frame, where the sensor's places are known.

    Raises:
        InputError: no walls, no floor, or no closed room.
        ConfigError: an override that cannot be meant.
    """
    classes = square_classes(segments, classes, config.world)
    surfaces, plan = planned(surfels, segments, classes, config, overrides, rays)
    energy = plan_energy(plan.evidence, plan.grid, plan.price, config.labels, plan.forbidden)
    odds = -cell_costs(plan.evidence, np.outer(*(np.diff(line) for line in plan.grid)), config.labels)
    candidates = tuple(
        _report(plan, energy, odds, axis, k, config.labels.max_open_cells)
        for axis in (0, 1)
        for k in range(len(plan.grid[axis]))
    )
    return Explanation(
        grid=plan.grid,
        candidates=candidates,
        oblique=plan.trials,
        evidence=plan.evidence,
        log_odds=odds,
        inside=plan.inside,
        room=plan.room_of_cell,
        energy_nats=energy.of(plan.inside),
        corner_price_nats=float(np.max(energy.corner_price)),
        heights_m=(surfaces.floor_height_m, surfaces.ceiling_height_m),
        notes=plan.notes,
    )


def _report(
    plan: Plan, energy: PlanEnergy, odds: Float[np.ndarray, "nx ny"], axis: int, k: int, max_open: int
) -> CandidateReport:
    """Everything about line `k` of an axis."""
    along_m = plan.grid[1 - axis]
    lengths_m = np.diff(along_m)
    walls, costs, ends, forbidden, forced = (
        np.moveaxis(pair[axis], axis, 0)[k]
        for pair in (
            plan.evidence.walls,
            energy.borders,
            outlines(plan.room_of_cell),
            plan.forbidden,
            plan.forced,
        )
    )
    strongest = int(np.argmin(costs))
    accepted = bool(np.any(ends))
    # Where more wall was seen on the rest of a line than a person struck out, it is judged by that.
    struck_out = float(np.sum(lengths_m[forbidden])) > float(np.sum(walls * lengths_m))
    verdict: Verdict = "accepted" if accepted else "forbidden" if struck_out else "refused"
    outline_m = float(np.sum(lengths_m[ends]))
    drawn = np.flatnonzero(ends) if accepted else np.array([strongest])
    report = CandidateReport(
        id=f"{'xy'[axis]}{k + 1}",
        axis=axis,
        position_m=float(plan.grid[axis][k]),
        seen=bool(plan.lines[axis].seen[k]),
        forced=bool(np.any(forced)),
        verdict=verdict,
        wall_m=float(np.sum(walls * lengths_m)),
        passed_m=_passed_m(plan, axis, k),
        outline_m=outline_m,
        outline_seen=float(np.sum((walls * lengths_m)[ends]) / outline_m) if accepted else 0.0,
        stretch_m=(float(along_m[drawn[0]]), float(along_m[drawn[-1] + 1])),
        beside=_beside(plan, odds, axis, k, strongest),
        difference_nats=None,
        reason="",
    )
    if verdict != "forbidden" and plan.inside.size <= _CHEAP_CELLS:
        nats = _difference(plan, energy, axis, k, None if accepted else strongest, max_open)
        report = replace(report, difference_nats=nats)
    rooms = sorted({int(r) for r in _rooms_at(plan, axis, k, ends)} - {0})
    reason = _reason(report, rooms, plan.inside, axis, k, strongest)
    return replace(report, reason=" ".join([reason, *_moves(plan, axis, k)]))


def _moves(plan: Plan, axis: int, k: int) -> list[str]:
    """What became of the walls on line `k` that nobody saw, in words."""
    along_m = plan.grid[1 - axis]
    return [
        f"Nobody saw it from {along_m[wall.cells.start]:.2f} to {along_m[wall.cells.stop]:.2f} m: there it "
        f"may stand elsewhere in a shadow, and is put at {place.offset_m:.2f} m "
        f"(standard uncertainty {place.std_m:.2f} m)."
        for wall, place in plan.outline.moved
        if wall.axis == axis and wall.line == k
    ]


def _passed_m(plan: Plan, axis: int, k: int) -> float | None:
    """How much of line `k` of an axis lines of sight passed."""
    free = plan.evidence.free
    if free is None:
        return None
    return float(np.sum(np.moveaxis(free.walls[axis], axis, 0)[k] * np.diff(plan.grid[1 - axis])))


def _sides(
    cells: np.ndarray, axis: int, k: int
) -> tuple[Shaped[np.ndarray, " borders"], Shaped[np.ndarray, " borders"]]:
    """Values of the cells below and above a line, for each of its borders; beyond the grid zero."""
    padded = np.moveaxis(np.pad(cells, [(1, 1) if a == axis else (0, 0) for a in (0, 1)]), axis, 0)
    return padded[k], padded[k + 1]


def _beside(
    plan: Plan, odds: Float[np.ndarray, "nx ny"], axis: int, k: int, border: int
) -> tuple[Beside, Beside]:
    shown = (plan.evidence.ceiling, plan.evidence.floor, odds)
    ceiling, floor, nats = (_sides(values, axis, k) for values in shown)
    room = _sides(plan.room_of_cell, axis, k)
    below, above = (
        Beside(
            float(ceiling[s][border]), float(floor[s][border]), float(nats[s][border]), int(room[s][border])
        )
        for s in (0, 1)
    )
    return below, above


def _rooms_at(plan: Plan, axis: int, k: int, ends: Bool[np.ndarray, " borders"]) -> Int[np.ndarray, " _"]:
    below, above = _sides(plan.room_of_cell, axis, k)
    return np.concatenate([below[ends], above[ends]])


def _difference(
    plan: Plan, energy: PlanEnergy, axis: int, k: int, border: int | None, max_open: int
) -> float:
    """How much worse the best plan is without an outline on a line, or with one on a border of it, nats.

    Without: the cells on both sides of the line are bound together, as though the line were not there.
    """
    changed = np.moveaxis(energy.borders[axis].copy(), axis, 0)
    if border is None:
        changed[k] = _COMPELLED
    else:
        changed[k, border] = -_COMPELLED
    borders = [*energy.borders]
    borders[axis] = np.moveaxis(changed, 0, axis)
    other, _ = minimise(replace(energy, borders=(borders[0], borders[1])), max_open)
    return energy.of(other) - energy.of(plan.inside)


def _reason(
    report: CandidateReport,
    rooms: list[int],
    inside: Bool[np.ndarray, "nx ny"],
    axis: int,
    k: int,
    border: int,
) -> str:
    difference = report.difference_nats
    if report.verdict == "forbidden":
        return "Forbidden by an override."
    if report.verdict == "accepted":
        return _accepted(report, rooms)
    cost = "" if difference is None else f" The best plan with a wall there is {difference:.1f} nats worse."
    found = f"{report.wall_m:.2f} m of wall were seen on it" if report.seen else "No wall was seen on it"
    if report.passed_m is not None and round(report.passed_m, 2) > 0.0:
        found += f", lines of sight pass it on {report.passed_m:.2f} m"
    if report.forced:
        found = "It was forced by an override"
    below, above = report.beside
    shares = "; ".join(
        f"{100 * side.ceiling:.0f} % ceiling, {100 * side.floor:.0f} % floor ({side.log_odds:+.1f} nats)"
        for side in report.beside
    )
    where = f"cells below and above it at {report.stretch_m[0]:.2f} to {report.stretch_m[1]:.2f} m: {shares}"
    low, high = (bool(side[border]) for side in _sides(inside, axis, k))
    if below.room and below.room == above.room:
        why = f"room {below.room} goes on at both sides"
    elif low != high:
        why = "the best plan ends there, but what it encloses is no room of its own (too small, or open)"
    elif low:
        why = "what lies at both sides is no room of its own (too small, or open)"
    else:
        why = "it lies outside of every room"
    return f"{found}, but {why}: {where}.{cost}"


def _accepted(report: CandidateReport, rooms: list[int]) -> str:
    names = " and ".join(f"room {r}" for r in rooms)
    source = "wall was seen" if report.seen else "no wall was seen; floor, ceiling or a wall ends there; seen"
    if report.forced:
        source = "forced by an override, taken as seen"
    text = f"{names} ends there on {report.outline_m:.2f} m; {source} on {100 * report.outline_seen:.0f} %."
    text = text[0].upper() + text[1:]
    difference = report.difference_nats
    if difference is None:
        return text
    if difference > 0:
        return f"{text} The best plan without a wall there is {difference:.1f} nats worse."
    return f"{text} It parts rooms by the wall seen on it; inside and outside do not hang on it."
