"""Random furnished scenes: one rectilinear room, or a row of box rooms joined by doors."""

from dataclasses import dataclass

import numpy as np

from indoorfit.errors import ConfigError
from indoorfit.geometry import exposures
from indoorfit.model import Shape

from .patches import Box, Patches, shape_patches
from .placement import free_box
from .random_plan import DEFAULT_RANDOM_ROOM, RandomRoomSettings, random_room
from .scene import Finish, Furniture, FurnitureKind, ObliqueWall, Opening, RoomPlan, Scene, Step, room_plans
from .scene_shape import scene_shape


@dataclass(frozen=True)
class RandomSceneSettings:
    """What a random scene holds."""

    n_walls: int = 8
    """Walls of the room; unused if there are several rooms."""
    n_rooms: int = 1
    """Box rooms side by side, with partitions of 10 to 25 cm and a door in each."""
    n_furniture: int = 5
    """Things tried, the bookcase not counted."""
    bookcase: bool = False
    """Whether a bookcase hides half of the longest wall."""
    n_windows: int = 1
    n_doors: int = 1
    """Doors open to a corridor, besides those between rooms."""
    glass_wall: bool = False
    """Whether one whole wall is glass."""
    floor_step: bool = False
    beam: bool = False
    """Whether a beam of 20 to 40 cm crosses below the ceiling."""
    oblique: bool = False
    """Whether a corner is cut off at about 45 degrees."""
    uneven_m: float = 0.0
    """Bow and tilt of every wall, at most; 0.01 is what DIN 18202 allows over 4 m."""
    room: RandomRoomSettings = DEFAULT_RANDOM_ROOM
    """Limits of plan and height."""


DEFAULT_RANDOM_SCENE = RandomSceneSettings()


def random_scene(
    rng: np.random.Generator,
    settings: RandomSceneSettings = DEFAULT_RANDOM_SCENE,
    name: str = "random",
    rooms: tuple[RoomPlan, ...] | None = None,
) -> Scene:
    """A random scene; the same state of `rng` gives the same scene.

    Args:
        rng: decides everything.
        settings: what to build.
        name: of the scene.
        rooms: plans to furnish, such as a preset's; None draws them as the settings say.

    Raises:
        ConfigError: a number is out of range, or the room asked for does not exist (see `random_room`).
    """
    _check(settings)
    openings: list[Opening] = []
    if rooms is not None:
        pass
    elif settings.n_rooms > 1:
        rooms, openings = _row_of_rooms(rng, settings)
    else:
        rooms = room_plans(random_room(rng, settings.n_walls, settings.room))
    bare = Scene(rooms)
    shape = scene_shape(bare)
    patches = shape_patches(shape)
    steps = _steps(rng, shape, settings)
    walls = _walls_by_length(shape)
    if settings.glass_wall:
        openings.append(_on_wall(walls[int(rng.integers(1, min(4, len(walls))))], "window", None, rng))
    free_walls = [wall for wall in walls if not _taken(wall, openings)]
    for kind, count in (("window", settings.n_windows), ("door", settings.n_doors)):
        for _ in range(min(count, len(free_walls) - 1)):
            # The longest wall stays for the bookcase.
            wall = free_walls.pop(int(rng.integers(1, min(5, len(free_walls)))))
            openings.append(_on_wall(wall, kind, 1.0, rng))
    oblique = (_cut_corner(rng, bare),) if settings.oblique else ()
    kept_free = [_before_door(opening) for opening in openings if opening.kind == "door"]
    furniture = _furniture(rng, patches, walls[0], oblique, kept_free, settings)
    return Scene(rooms, name, steps, tuple(openings), oblique, furniture, _finishes(rng, shape, settings))


def _check(settings: RandomSceneSettings) -> None:
    counts = (settings.n_furniture, settings.n_windows, settings.n_doors)
    low_m, high_m = settings.room.height_m
    if settings.n_rooms < 1 or min(counts) < 0 or settings.uneven_m < 0.0 or not 1.9 <= low_m <= high_m:
        raise ConfigError(
            f"simulate: {settings.n_rooms} rooms of height {low_m:g} to {high_m:g} m, {counts[0]} things, "
            f"{counts[1]} windows, {counts[2]} doors, unevenness {settings.uneven_m:g} m. Fix: at least one "
            "room, at least 1.9 m high (furniture and doors need that), nothing negative."
        )


@dataclass(frozen=True)
class _Wall:
    """One rectangular piece of wall."""

    axis: int
    at_m: float
    inward: int
    start_m: float
    end_m: float
    floor_m: float
    ceiling_m: float
    outer: bool
    """Whether no room lies beyond it: only then can there be a view through it."""

    def at(self, along_m: float, off_m: float = 0.0) -> tuple[float, float]:
        """Plan coordinates of a place along the wall, some distance into the room."""
        across = self.at_m + self.inward * off_m
        return (across, along_m) if self.axis == 0 else (along_m, across)

    @property
    def length_m(self) -> float:
        """Clear length."""
        return self.end_m - self.start_m


def _walls_by_length(shape: Shape) -> list[_Wall]:
    walls = []
    ends_m = np.array(
        [[f(p.offset_m for p in shape.planes if p.axis == a) for a in (0, 1)] for f in (min, max)]
    )
    for exposure in exposures(shape):
        plane = shape.planes[exposure.plane]
        if plane.axis == 2:
            continue
        outer = plane.offset_m == ends_m[int(plane.outward > 0), plane.axis]
        row = np.pad(exposure.mask.any(axis=1).astype(int), 1)
        starts, ends = np.flatnonzero(np.diff(row) == 1), np.flatnonzero(np.diff(row) == -1)
        for i0, i1 in zip(starts, ends, strict=True):
            span = (float(exposure.u_m[i0]), float(exposure.u_m[i1]))
            rows = np.flatnonzero(exposure.mask[i0])
            z = (float(exposure.v_m[rows[0]]), float(exposure.v_m[rows[-1] + 1]))
            walls.append(_Wall(plane.axis, plane.offset_m, -plane.outward, *span, *z, bool(outer)))
    return sorted(walls, key=lambda wall: -wall.length_m)


def _row_of_rooms(
    rng: np.random.Generator, settings: RandomSceneSettings
) -> tuple[tuple[RoomPlan, ...], list[Opening]]:
    rooms: list[RoomPlan] = []
    openings: list[Opening] = []
    low, high = settings.room.size_m
    height_m = round(float(rng.uniform(*settings.room.height_m)), 3)
    x = 0.0
    for k in range(settings.n_rooms):
        length, width = (round(float(rng.uniform(low, 0.5 * (low + high))), 3) for _ in range(2))
        rooms.append(RoomPlan((x, x + length), (0.0, width), ("#",), 0.0, height_m))
        if k:
            wall_m = x - rooms[k - 1].x_lines_m[1]
            shared = min(width, rooms[k - 1].y_lines_m[1])
            y = float(rng.uniform(0.7, shared - 0.7))
            openings.append(Opening("door", "x", (x - 0.5 * wall_m, y), 0.9, 0.0, 2.05))
        x += length + round(float(rng.uniform(0.10, 0.25)), 3)
    return tuple(rooms), openings


def _taken(wall: _Wall, openings: list[Opening]) -> bool:
    for opening in openings:
        axis = "xy".index(opening.axis)
        near = wall.axis == axis and abs(wall.at_m - opening.centre_m[axis]) < opening.reach_m
        if near and wall.start_m < opening.centre_m[1 - axis] < wall.end_m:
            return True
    return False


def _on_wall(wall: _Wall, kind: str, share: float | None, rng: np.random.Generator) -> Opening:
    """A door or window somewhere on a wall, or (share None) a pane that is the whole wall."""
    axis = ("x", "y")[wall.axis]
    # The wall's own plane only, not a parallel wall that is a step away.
    reach_m = 0.02
    if share is None:
        middle = wall.at(0.5 * (wall.start_m + wall.end_m))
        view_m = float(rng.uniform(4.0, 15.0)) if wall.outer else None
        return Opening(
            "window", axis, middle, wall.length_m, wall.floor_m, wall.ceiling_m, view_m, True, reach_m
        )
    if kind == "door":
        width_m = min(0.9, 0.8 * wall.length_m)
        along_m = float(rng.uniform(wall.start_m + 0.5 * width_m, wall.end_m - 0.5 * width_m))
        view_m = float(rng.uniform(1.2, 2.5)) if wall.outer else None
        top_m = wall.floor_m + 2.05
        return Opening("door", axis, wall.at(along_m), width_m, wall.floor_m, top_m, view_m, False, reach_m)
    width_m = float(rng.uniform(0.4, 0.7)) * wall.length_m
    along_m = float(rng.uniform(wall.start_m + 0.5 * width_m, wall.end_m - 0.5 * width_m))
    view_m = float(rng.uniform(3.0, 12.0)) if wall.outer and rng.random() < 0.5 else None
    sill_m, top_m = wall.floor_m + 0.9, wall.ceiling_m - 0.3
    return Opening("window", axis, wall.at(along_m), width_m, sill_m, top_m, view_m, True, reach_m)


def _steps(rng: np.random.Generator, shape: Shape, settings: RandomSceneSettings) -> tuple[Step, ...]:
    """A platform over one end of the first room, a beam across it; both span the room's whole width."""
    low_m, high_m = shape.bounds_m()[shape.rooms[0].id]
    steps = []
    if settings.floor_step:
        edge = float(low_m[0] + rng.uniform(0.25, 0.4) * (high_m[0] - low_m[0]))
        height_m = round(float(rng.uniform(0.12, 0.35)), 3)
        steps.append(Step(0, "floor", (float(low_m[0]), float(low_m[1])), (edge, float(high_m[1])), height_m))
    if settings.beam:
        start = float(low_m[1] + rng.uniform(0.4, 0.6) * (high_m[1] - low_m[1]))
        height_m = round(float(rng.uniform(0.2, 0.4)), 3)
        ends = (float(low_m[0]), start), (float(high_m[0]), start + round(float(rng.uniform(0.2, 0.4)), 3))
        steps.append(Step(0, "ceiling", *ends, height_m))
    return tuple(steps)


def _cut_corner(rng: np.random.Generator, scene: Scene) -> ObliqueWall:
    """A wall across a convex corner of the first room's bounding rectangle."""
    room = scene.rooms[0]
    x, y = room.x_lines_m[-1], room.y_lines_m[0]
    if room.cells[-1][-1] == "#":
        dx, dy = (float(d) for d in rng.uniform(0.8, 1.2, 2))
        # Room to the left when walking from the bottom wall to the right wall would be outside.
        return ObliqueWall(0, (x - dx, y), (x, y + dy))
    # Another corner of the row below, which always begins somewhere.
    k = room.cells[-1].index("#")
    x, dx = room.x_lines_m[k], 0.5 * (room.x_lines_m[k + 1] - room.x_lines_m[k])
    dy = 0.5 * (room.y_lines_m[1] - y)
    return ObliqueWall(0, (x, y + dy), (x + dx, y))


_KINDS: tuple[FurnitureKind, ...] = (
    "cupboard", "chair", "box", "table", "chair", "lamp", "pendant", "curtain", "table"
)  # fmt: skip


def _furniture(
    rng: np.random.Generator,
    patches: Patches,
    longest: _Wall,
    oblique: tuple[ObliqueWall, ...],
    boxes: list[Box],
    settings: RandomSceneSettings,
) -> tuple[Furniture, ...]:
    """Things that overlap neither each other nor the `boxes` to keep free."""
    items: list[Furniture] = []
    boxes = list(boxes)
    for wall in oblique:
        # Keeps things out of the corner that was cut off.
        (x0, y0), (x1, y1) = wall.start_m, wall.end_m
        boxes.append(Box((min(x0, x1), min(y0, y1), -9.0), (max(x0, x1), max(y0, y1), 9.0)))
    if settings.bookcase:
        height_m = min(2.1, longest.ceiling_m - longest.floor_m - 0.2)
        size = (0.55 * longest.length_m, 0.32, height_m)
        place = longest.at(longest.start_m + 0.45 * longest.length_m, 0.17)
        yaw_rad = 0.0 if longest.axis == 1 else 0.5 * np.pi
        items.append(Furniture("bookcase", place, size, longest.floor_m, float(yaw_rad), (120, 82, 52)))
        boxes.append(_box(items[-1]))
    floors = np.flatnonzero((patches.axis == 2) & (patches.inward > 0))
    walls = np.flatnonzero(patches.axis < 2)
    for k in range(settings.n_furniture):
        kind = _KINDS[(k + int(rng.integers(2))) % len(_KINDS)]
        for _ in range(30):
            at_wall = kind in ("cupboard", "box", "curtain")
            item = (_at_wall if at_wall else _free)(rng, patches, walls if at_wall else floors, kind)
            if free_box(patches, _box(item), tuple(boxes)):
                items.append(item)
                boxes.append(_box(item))
                break
    return tuple(items)


def _before_door(door: Opening) -> Box:
    """A metre on both sides of a door, for people to pass."""
    x, y = door.centre_m
    half = (1.0, 0.5 * door.width_m) if door.axis == "x" else (0.5 * door.width_m, 1.0)
    return Box((x - half[0], y - half[1], -9.0), (x + half[0], y + half[1], 9.0))


def _box(item: Furniture) -> Box:
    """The upright box around a turned thing."""
    c, s = abs(np.cos(item.yaw_rad)), abs(np.sin(item.yaw_rad))
    half = (0.5 * (c * item.size_m[0] + s * item.size_m[1]), 0.5 * (s * item.size_m[0] + c * item.size_m[1]))
    x, y = item.centre_m
    low = (float(x - half[0]), float(y - half[1]), item.base_m)
    return Box(low, (float(x + half[0]), float(y + half[1]), item.base_m + item.size_m[2]))


def _at_wall(rng: np.random.Generator, patches: Patches, walls: np.ndarray, kind: FurnitureKind) -> Furniture:
    wall = int(rng.choice(walls))
    axis, along = int(patches.axis[wall]), 1 - int(patches.axis[wall])
    low, high = patches.low_m[wall], patches.high_m[wall]
    floor_m = float(patches.low_m[patches.axis == 2, 2].min())
    sizes = {
        "cupboard": (rng.uniform(0.8, 1.8), rng.uniform(0.4, 0.6), rng.uniform(1.8, 2.1)),
        "box": (rng.uniform(0.4, 1.5), rng.uniform(0.3, 0.6), rng.uniform(0.4, 1.1)),
        "curtain": (rng.uniform(0.8, 1.6), 0.1, float(high[2]) - floor_m - 0.05),
    }[kind]
    # 2 cm off the wall: nothing stands flush behind a skirting board.
    off_m = 0.5 * sizes[1] + 0.02
    place = np.zeros(2)
    place[along] = rng.uniform(low[along], high[along])
    place[axis] = low[axis] + patches.inward[wall] * off_m
    yaw_rad = 0.0 if axis == 1 else 0.5 * np.pi
    colour = _colour(rng)
    size = (float(sizes[0]), float(sizes[1]), float(sizes[2]))
    return Furniture(kind, (float(place[0]), float(place[1])), size, floor_m, float(yaw_rad), colour)


def _free(rng: np.random.Generator, patches: Patches, floors: np.ndarray, kind: FurnitureKind) -> Furniture:
    floor = int(rng.choice(floors))
    x, y = rng.uniform(patches.low_m[floor], patches.high_m[floor])[:2]
    floor_m = float(patches.low_m[floor, 2])
    base_m, yaw_rad = floor_m, float(rng.uniform(0.0, np.pi))
    sizes = {
        "table": (rng.uniform(1.0, 1.8), rng.uniform(0.6, 0.9), rng.uniform(0.70, 0.76)),
        "chair": (rng.uniform(0.40, 0.46), rng.uniform(0.42, 0.50), rng.uniform(0.80, 0.95)),
        "lamp": (0.35, 0.35, rng.uniform(1.3, 1.7)),
        "pendant": (0.4, 0.4, 0.6),
    }[kind]
    if kind == "pendant":
        base_m = float(patches.high_m[:, 2].max()) - 0.601
    size = (float(sizes[0]), float(sizes[1]), float(sizes[2]))
    return Furniture(kind, (float(x), float(y)), size, base_m, yaw_rad, _colour(rng))


def _colour(rng: np.random.Generator) -> tuple[int, int, int]:
    """Wood, cloth and paint: a shade with a tint, rather warm than cold."""
    shade = int(rng.integers(55, 190))
    red, green, blue = (shade + int(c) for c in rng.integers((0, -15, -45), (45, 20, 25)))
    return (red, green, max(blue, 0))


def _finishes(rng: np.random.Generator, shape: Shape, settings: RandomSceneSettings) -> tuple[Finish, ...]:
    finishes = []
    for plane in shape.planes:
        if plane.axis == 2:
            continue
        texture = ("plain", "plain", "stripes", "posters")[int(rng.integers(4))]
        shade = int(rng.integers(190, 245))
        bow_m, *tilt_m = (float(x) for x in settings.uneven_m * rng.uniform(-1.0, 1.0, 3) * (1.0, 0.5, 0.5))
        colour = (shade, shade - int(rng.integers(0, 20)), shade - int(rng.integers(0, 40)))
        finishes.append(
            Finish(plane.face_class, None, plane.offset_m, colour, texture, bow_m, (tilt_m[0], tilt_m[1]))
        )
    return tuple(finishes)
