"""What a person said of the scan, put to work: boxes on the points, walls into the Manhattan frame."""

from dataclasses import replace

import numpy as np

from indoorfit.config import RunConfig
from indoorfit.discover import PlanOverrides, WallStretch
from indoorfit.errors import ConfigError
from indoorfit.model import Frame, Note, OverrideConfig, Scan, WallLine

_OFF_DEG = 10.0
"""Two points clicked 10 cm off on a wall of 1 m turn it by up to 11 degrees."""
_SHORTEST_M = 0.1
"""Of a wall given by two points: what is shorter is a slip of the hand."""


def overridden(scan: Scan, config: RunConfig) -> tuple[Scan, RunConfig]:
    """The scan without the ignored boxes, with a note of it; the settings with the up axis said.

    Raises:
        ConfigError: a box without points, boxes that hold all of them, or walls with the greedy method.
    """
    said = config.overrides
    if said.has_walls and config.method == "greedy":
        raise ConfigError(
            "overrides: forced and forbidden walls need the joint method; the greedy one has no candidates. "
            "Fix: --method joint, or leave the walls out."
        )
    if said.up is not None:
        config = replace(config, orient=replace(config.orient, up=said.up))
    told = []
    if said.up is not None:
        told.append(f"up is {said.up}")
    if said.yaw_deg is not None:
        told.append(f"the walls are turned by {said.yaw_deg:g} degrees")
    if said.ignore_box:
        smaller = without_boxes(scan, said)
        count, scan = scan.n_points - smaller.n_points, smaller
        told.append(f"{count} points in {len(said.ignore_box)} box(es) ignored")
    if told:
        note = Note("OVERRIDDEN", f"By override, {'; '.join(told)}.")
        scan = replace(scan, notes=(*scan.notes, note))
    return scan, config


def without_boxes(scan: Scan, said: OverrideConfig) -> Scan:
    """The scan without the points that are to be ignored.

    Raises:
        ConfigError: a box holds no point, or the boxes hold all of them.
    """
    dropped = np.zeros(scan.n_points, bool)
    for k, box in enumerate(said.ignore_box):
        inside = np.all((scan.points_m >= box.low_m) & (scan.points_m <= box.high_m), axis=1)
        if not np.any(inside):
            low, high = scan.points_m.min(axis=0), scan.points_m.max(axis=0)
            extent = ", ".join(f"{n} {a:.2f} to {b:.2f}" for n, a, b in zip("xyz", low, high, strict=True))
            raise ConfigError(
                f"overrides.ignore_box: no point of {scan.name} lies in box {k + 1}; the scan has {extent} "
                "m. Fix: give the box in the scan's own coordinates, in metres."
            )
        dropped |= inside
    if np.all(dropped):
        raise ConfigError("overrides.ignore_box: the boxes hold every point. Fix: make them smaller.")
    kept = ~dropped
    return replace(
        scan,
        points_m=scan.points_m[kept],
        colours=None if scan.colours is None else scan.colours[kept],
        frame_ids=None if scan.frame_ids is None else scan.frame_ids[kept],
    )


def plan_overrides(said: OverrideConfig, frame: Frame) -> PlanOverrides:
    """Walls in the Manhattan frame.

    Raises:
        ConfigError: two points that lie on no possible wall.
    """
    return PlanOverrides(
        forbidden=tuple(_stretch(wall, frame, "forbid_wall") for wall in said.forbid_wall),
        forced=tuple(_stretch(wall, frame, "force_wall") for wall in said.force_wall),
    )


def _stretch(wall: WallLine, frame: Frame, name: str) -> WallStretch:
    if wall.axis is not None and wall.position_m is not None:
        return WallStretch("xy".index(wall.axis), wall.position_m)
    ends_m = frame.to_manhattan(np.array([wall.from_m, wall.to_m]))[:, :2]
    run_m = np.abs(ends_m[1] - ends_m[0])
    axis = int(np.argmin(run_m))
    if run_m[1 - axis] < _SHORTEST_M:
        raise ConfigError(
            f"overrides.{name}: from_m and to_m are {run_m[1 - axis]:.3f} m apart in the plan; needed at "
            f"least {_SHORTEST_M} m. Fix: give two points at the two ends of the wall."
        )
    off_deg = float(np.rad2deg(np.arctan2(run_m[axis], run_m[1 - axis])))
    if off_deg > _OFF_DEG:
        raise ConfigError(
            f"overrides.{name}: the line from {wall.from_m} to {wall.to_m} is {off_deg:.0f} degrees off the "
            f"nearest direction of walls; needed at most {_OFF_DEG:.0f}. Fix: give two points of one wall."
        )
    low_m, high_m = np.sort(ends_m[:, 1 - axis])
    return WallStretch(axis, float(ends_m[:, axis].mean()), float(low_m), float(high_m))
