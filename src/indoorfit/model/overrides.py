"""What a person who knows better says about a scan, in the scan's own coordinates."""

from dataclasses import dataclass
from typing import Literal

from indoorfit.errors import ConfigError

Point = tuple[float, float, float]


@dataclass(frozen=True)
class WallLine:
    """A wall in the plan: either two points of it, or axis and position as `indoorfit explain` tells."""

    from_m: Point | None = None
    """A point on one end of the wall, scan coordinates, metres; its height does not matter."""
    to_m: Point | None = None
    """A point on the other end."""
    axis: Literal["x", "y"] | None = None
    """The axis of the Manhattan frame that the wall is perpendicular to; the wall may run anywhere on it."""
    position_m: float | None = None
    """Where along this axis."""

    def __post_init__(self) -> None:
        by_points = (self.from_m is not None) + (self.to_m is not None)
        by_axis = (self.axis is not None) + (self.position_m is not None)
        if (by_points, by_axis) not in ((2, 0), (0, 2)):
            given = [n for n in ("from_m", "to_m", "axis", "position_m") if getattr(self, n) is not None]
            raise ConfigError(
                f"overrides: a wall with {' and '.join(given) or 'nothing given'}; needed either from_m and "
                "to_m (two points of the wall, scan coordinates), or axis and position_m. "
                "Fix: `indoorfit explain` lists both for every candidate."
            )


@dataclass(frozen=True)
class IgnoredBox:
    """A box whose points are left out before everything else; sides along the scan's axes."""

    low_m: Point
    """Least coordinates, scan frame, metres."""
    high_m: Point
    """Greatest coordinates."""

    def __post_init__(self) -> None:
        for name, low, high in zip("xyz", self.low_m, self.high_m, strict=True):
            if not low < high:
                raise ConfigError(
                    f"overrides.ignore_box: {name} from {low:g} to {high:g} m is empty; low_m must be less "
                    "than high_m in x, y and z. Fix: exchange the two."
                )


@dataclass(frozen=True)
class OverrideConfig:
    """What a person who knows better says; recorded in the provenance and in the note `OVERRIDDEN`."""

    forbid_wall: tuple[WallLine, ...] = ()
    """Walls that are not there: no outline and no partition runs on the candidate (there)."""
    force_wall: tuple[WallLine, ...] = ()
    """Walls that are there: taken as seen on their whole area, whatever the scan shows."""
    ignore_box: tuple[IgnoredBox, ...] = ()
    """Boxes whose points are left out: what was seen in a mirror, people, a pile of boxes."""
    yaw_deg: float | None = None
    """Direction of the walls: the Manhattan x axis is turned by this angle from the scan's x (y where x is
    up), counter-clockwise seen from above. By default found from the walls. The fit still refines it."""
    up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None
    """The up axis in scan coordinates; wins over orient.up."""

    def __post_init__(self) -> None:
        if self.yaw_deg is not None and not -360.0 <= self.yaw_deg <= 360.0:
            raise ConfigError(
                f"overrides.yaw_deg: got {self.yaw_deg}; needed -360 to 360 degrees. Fix: degrees."
            )

    @property
    def has_walls(self) -> bool:
        """Whether any wall is forced or forbidden."""
        return bool(self.forbid_wall or self.force_wall)
