"""The options of ``indoorfit simulate`` in groups, and which of them each way of simulating uses."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

from indoorfit.errors import ConfigError

from .maybe import Flag, Maybe

Preset = Literal["box", "L", "U", "X", "T", "Z", "stair"]


@dataclass(frozen=True)
class Plan:
    """Size of a preset plan (box to stair); the height also holds for `random`."""

    length: Maybe[float] = None
    """Extent along x, metres; default: the kind's own."""
    width: Maybe[float] = None
    """Extent along y, metres."""
    height: Maybe[float] = None
    """Floor to ceiling, metres; default: 2.70, and 2.3 to 3.2 for `random`."""
    notch_length: Maybe[float] = None
    """Extent of the (largest) notch along x, metres."""
    notch_width: Maybe[float] = None
    """Extent of the (largest) notch along y, metres."""


@dataclass(frozen=True)
class Sampling:
    """Points drawn evenly from all surfaces: a preset plan without --sensor."""

    points: Maybe[int] = None
    """Number of points; default: 150 000."""
    noise: Maybe[float] = None
    """Standard deviation of the noise, metres; default: 0.005 as in the thesis (5.1.1)."""
    noise_model: Maybe[Literal["normal", "isotropic", "kinect"]] = None
    """normal (default): along the surface normal; isotropic; kinect: line of sight, 4 cm at 5 m, growing
    with d²."""
    outliers: Maybe[float] = None
    """Share of points spread over the bounding box, 0 to 1; default: 0."""


@dataclass(frozen=True)
class Contents:
    """What the scene holds. A preset plan is empty by default; all but the first two need --sensor there."""

    furniture: Maybe[int] = None
    """Number of things; default: 5 for `random`. Some may find no place."""
    windows: Maybe[int] = None
    """Number of windows; default: 1 for `random`."""
    doors: Maybe[int] = None
    """Number of doors open to a corridor; default: 1 for `random`. Doors between rooms come by themselves."""
    bookcase: Flag = False
    """A bookcase hides half of the longest wall."""
    glass_wall: Flag = False
    """One whole wall is glass."""
    floor_step: Flag = False
    """A platform of 12 to 35 cm at one end."""
    beam: Flag = False
    """A beam of 20 to 40 cm crosses below the ceiling."""
    oblique: Flag = False
    """A corner is cut off at about 45 degrees: not a Manhattan world any more."""
    uneven: Maybe[float] = None
    """Bow and tilt of every wall, at most, metres; DIN 18202 allows 0.01 over 4 m. Default: 0."""
    walls: Maybe[int] = None
    """Walls of a `random` room, even, from 4; default: 8."""
    rooms: Maybe[int] = None
    """Box rooms side by side in a `random` scene; default: 1."""
    scene: Maybe[Path] = None
    """The TOML or JSON file of `indoorfit simulate scene`."""


@dataclass(frozen=True)
class Scanning:
    """The virtual scanner: for `random` and `scene`, and for a preset plan with --sensor."""

    sensor: Maybe[str] = None
    """kinect_v1 (default), phone_lidar, tof_camera, tls, or a TOML file like the presets."""
    exact: Flag = False
    """Switch all errors of the sensor off; occlusion and limits stay."""
    frames: Maybe[int] = None
    """Frames of a hand-held camera; default: 90."""
    stations: Maybe[int] = None
    """Stations of a scanner on a tripod; default: 2, or one per room."""
    motion: Maybe[Literal["walk", "spin"]] = None
    """walk (default): turn on the way; spin: stand at a few places and turn once round."""
    pixel_step: Maybe[int] = None
    """Keep every n-th row and column; default: 4."""
    registration: Maybe[Literal["0", "5mm", "2cm", "5cm"]] = None
    """RMS of the pose errors along each axis, drift with its loop closed; default: 0."""
    jump_share: Maybe[float] = None
    """Share of that variance which jumps between sectors of frames instead of drifting; default: 0."""
    slip_share: Maybe[float] = None
    """Share of frames, one block, that is displaced by 6 cm and 1 degree; default: 0."""
    scale_error: Maybe[float] = None
    """Everything is larger by this share; default: 0."""
    no_frame_ids: Flag = False
    """Do not tell for each point which frame or station it comes from (property `frame`)."""
    sensor_poses: Flag = False
    """Also write the estimated sensor poses to SCAN.frames.json."""
    write_scene: Maybe[Path] = None
    """Also write the scene as TOML or JSON, to be edited and passed to `simulate scene`."""
    rgbd: Maybe[Path] = None
    """Also write the frames as RGB-D images in the layout of the TUM benchmark; a new directory."""


Way = Literal["sampled", "scanned", "random", "scene"]
"""A preset plan sampled, or scanned; a random scene; a scene from a file."""

_WAYS: dict[Way, str] = {
    "sampled": "a preset plan without --sensor",
    "scanned": "a preset plan with --sensor",
    "random": "random",
    "scene": "scene",
}
_PLANS: tuple[Way, ...] = ("sampled", "scanned")
_MADE: tuple[Way, ...] = ("scanned", "random")
_USED_BY: dict[str, tuple[Way, ...]] = {
    "height": (*_PLANS, "random"),
    "furniture": (*_PLANS, "random"),
    "windows": (*_PLANS, "random"),
    "walls": ("random",),
    "rooms": ("random",),
    "scene": ("scene",),
}
"""The options that differ from the rest of their group."""
_GROUP_USED_BY: dict[type, tuple[Way, ...]] = {
    Plan: _PLANS,
    Sampling: ("sampled",),
    Contents: _MADE,
    Scanning: (*_MADE, "scene"),
}


def refuse_unused(way: Way, kind: str, groups: tuple[Any, ...]) -> None:
    """Options without effect are mistakes: say so rather than write something else than was meant.

    Raises:
        ConfigError: an option was given that this way of simulating does not use.
    """
    for group in groups:
        for field in fields(group):
            used_by = _USED_BY.get(field.name, _GROUP_USED_BY[type(group)])
            if way not in used_by and getattr(group, field.name) != field.default:
                raise ConfigError(
                    f"simulate {kind}: --{field.name.replace('_', '-')} has no effect here; it belongs to "
                    f"{' or '.join(_WAYS[other] for other in used_by)}. Fix: leave it out, or simulate that."
                )
