"""A scene as data: rooms, what is built into them and what stands in them; TOML or JSON on disk."""

import json
import os
import tomllib
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

import cattrs
import numpy as np

from indoorfit.errors import ConfigError, OutputError
from indoorfit.geometry import exposures, room_of_planes
from indoorfit.model import Shape

Point2 = tuple[float, float]
Colour = tuple[int, int, int]
FurnitureKind = Literal["box", "bookcase", "cupboard", "table", "chair", "lamp", "pendant", "curtain"]
Texture = Literal["plain", "stripes", "posters", "grain", "mosaic"]


@dataclass(frozen=True)
class RoomPlan:
    """One room: cells of a grid between a floor and a ceiling."""

    x_lines_m: tuple[float, ...]
    y_lines_m: tuple[float, ...]
    cells: tuple[str, ...]
    """One string per row of cells, the row of highest y first, as the plan is drawn; `#` is room."""
    floor_m: float = 0.0
    ceiling_m: float = 2.7


@dataclass(frozen=True)
class Step:
    """A platform on the floor, or a lowered part of the ceiling (a beam, if it is narrow)."""

    room: int
    on: Literal["floor", "ceiling"]
    low_m: Point2
    high_m: Point2
    height_m: float
    """Above the floor, or below the ceiling."""


@dataclass(frozen=True)
class Opening:
    """A hole in the wall or walls near a point: doors join rooms where a wall of both is in reach."""

    kind: Literal["door", "window"]
    axis: Literal["x", "y"]
    """Axis that the wall is perpendicular to."""
    centre_m: Point2
    width_m: float
    bottom_m: float
    top_m: float
    view_m: float | None = None
    """What is seen through it where no room is behind: a corridor (door) or a facade (window) at this
    distance; None for nothing, no return at all. It must not reach into the scene's own rooms."""
    glazed: bool = False
    reach_m: float = 0.35
    """Walls whose plane is this near to `centre_m` are pierced; more than a wall's thickness."""
    depth_m: float = 0.2
    """Thickness of an outer wall."""


@dataclass(frozen=True)
class ObliqueWall:
    """A vertical wall across a corner; the room lies to the left when walking from start to end."""

    room: int
    start_m: Point2
    end_m: Point2


@dataclass(frozen=True)
class Furniture:
    """A thing in the room."""

    kind: FurnitureKind
    centre_m: Point2
    size_m: tuple[float, float, float]
    """Along its own x and y (before the turn) and its height."""
    base_m: float = 0.0
    """Height of its foot above z = 0."""
    yaw_rad: float = 0.0
    colour: Colour = (140, 100, 70)


@dataclass(frozen=True)
class Finish:
    """How surfaces look and how flat they are. Of several that match, the last one counts."""

    face: Literal["all", "wall", "front", "back", "left", "right", "floor", "ceiling"] = "all"
    room: int | None = None
    near_m: float | None = None
    """Only planes within 1 cm of this Manhattan offset."""
    colour: Colour = (225, 222, 212)
    texture: Texture = "plain"
    bow_m: float = 0.0
    """Height of a bow over the whole plane: its middle lies this much further out than its ends."""
    tilt_m: tuple[float, float] = (0.0, 0.0)
    """Rise over the half extent along the plane's two axes. The mean plane stays where it is."""


@dataclass(frozen=True)
class Scene:
    """Everything that can be scanned. All coordinates are in the Manhattan frame, metres, z up."""

    rooms: tuple[RoomPlan, ...]
    name: str = "scene"
    steps: tuple[Step, ...] = ()
    openings: tuple[Opening, ...] = ()
    oblique_walls: tuple[ObliqueWall, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    finishes: tuple[Finish, ...] = ()


def room_plans(shape: Shape) -> tuple[RoomPlan, ...]:
    """The plans of a shape without floor or ceiling steps, such as those of presets and random rooms."""
    home, plans = room_of_planes(shape), []
    for room in shape.rooms:
        floor = next(
            e
            for e in exposures(shape)
            if home[e.plane] == room.id and shape.planes[e.plane].face_class == "floor"
        )
        # Lines of other rooms and of open sides lie outside; they would only add empty cells.
        (i0, i1), (j0, j1) = (
            (int(k[0]), int(k[-1])) for k in (np.flatnonzero(floor.mask.any(axis=a)) for a in (1, 0))
        )
        mask = floor.mask[i0 : i1 + 1, j0 : j1 + 1]
        rows = tuple("".join(".#"[int(cell)] for cell in mask[:, j]) for j in reversed(range(mask.shape[1])))
        low_m, high_m = shape.bounds_m()[room.id]
        x_m, y_m = floor.u_m[i0 : i1 + 2].tolist(), floor.v_m[j0 : j1 + 2].tolist()
        plans.append(RoomPlan(tuple(x_m), tuple(y_m), rows, float(low_m[2]), float(high_m[2])))
    return tuple(plans)


_CONVERTER = cattrs.Converter(forbid_extra_keys=True)


def scene_from_dict(data: dict[str, Any], where: str = "scene") -> Scene:
    """A scene from plain values.

    Raises:
        ConfigError: a key is unknown or missing, or a value has the wrong type.
    """
    try:
        return _CONVERTER.structure(data, Scene)
    except Exception as e:
        problems = "; ".join(cattrs.transform_error(e))
        raise ConfigError(
            f"{where}: not a scene: {problems}. Fix: correct the entry; a scene written by "
            "`write_scene` shows every key."
        ) from e


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read a scene from a TOML or JSON file, by its suffix.

    Raises:
        ConfigError: the file is missing, is not TOML or JSON, or holds no scene.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        data = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    except OSError as e:
        raise ConfigError(f"{path.name}: cannot be read ({e.strerror}). Fix: check the path.") from e
    except ValueError as e:
        raise ConfigError(f"{path.name}: not valid {path.suffix[1:].upper()}: {e}. Fix: correct it.") from e
    return scene_from_dict(data, path.name)


def write_scene(scene: Scene, path: str | os.PathLike[str]) -> None:
    """Write a scene as TOML or JSON, by the suffix; reading it back gives an equal scene.

    Raises:
        OutputError: the file cannot be written.
    """
    path = Path(path)
    text = json.dumps(asdict(scene), indent=1) + "\n" if path.suffix == ".json" else scene_toml(scene)
    temporary = path.with_name(path.name + ".part")
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as e:
        temporary.unlink(missing_ok=True)
        raise OutputError(f"{path.name}: cannot be written ({e.strerror}). Fix: check the folder.") from e


def scene_toml(scene: Scene) -> str:
    """The scene as TOML text; floats keep every digit, None is left out."""
    lines = [f"name = {_toml(scene.name)}"]
    for field in fields(scene):
        if field.name == "name":
            continue
        for item in getattr(scene, field.name):
            lines += ["", f"[[{field.name}]]"]
            lines += [f"{key} = {_toml(value)}" for key, value in asdict(item).items() if value is not None]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    # JSON's strings, numbers and booleans are valid TOML, and repr-exact.
    return json.dumps(value)
