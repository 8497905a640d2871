"""Where a sensor stands and looks: hand-held paths and tripod stations inside the free floor."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage, sparse
from scipy.sparse import csgraph

from indoorfit.errors import ConfigError

from .scene import Opening, RoomPlan, Scene
from .scene_shape import room_mask

_CELL_M = 0.1
_CLEARANCE_M = 0.35
"""Half the width of a person; still passes a door of 0.8 m."""
_IN_THE_OPEN = 0.75
"""A tripod is put up on the roomiest quarter of the floor."""
_PITCHES_RAD = np.radians([-28.0, -3.0, 24.0])
"""A 43 degree camera held 1.5 m high needs these three to see floor, walls and ceiling."""


@dataclass(frozen=True)
class Pose:
    """A true pose of the sensor, Manhattan frame."""

    position_m: Float[np.ndarray, " 3"]
    R_manhattan_sensor: Float[np.ndarray, "3 3"]


def looking(position_m: Float[np.ndarray, " 3"], yaw_rad: float, pitch_rad: float) -> Pose:
    """A camera (x right, y down, z forward) that looks along an azimuth and an elevation."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    forward = np.array([c * np.cos(pitch_rad), s * np.cos(pitch_rad), np.sin(pitch_rad)])
    right = np.array([s, -c, 0.0])
    return Pose(position_m, np.stack([right, np.cross(forward, right), forward], axis=1))


def handheld_path(
    scene: Scene,
    n_frames: int,
    rng: np.random.Generator,
    style: Literal["walk", "spin"] = "walk",
    n_stops: int | None = None,
) -> tuple[Pose, ...]:
    """Poses of a camera carried through the free floor, 1.5 m high.

    Args:
        scene: keeps the path off walls and furniture; it passes doors that join rooms.
        n_frames: number of poses.
        rng: decides the way.
        style: `walk` keeps moving and turns on the way, `spin` stands at each stop and turns once round.
        n_stops: places visited; None for one per 6 m² of free floor, 2 to 12.

    Raises:
        ConfigError: no free floor is left, or not one pose was asked for.
    """
    _check_count("frame", n_frames)
    grid = _free_grid(scene)
    n_stops = _default_stops(grid) if n_stops is None else n_stops
    stops = _far_apart(grid.cells, n_stops, rng)
    if style == "spin":
        stop = np.arange(n_frames) * len(stops) // n_frames
        places_m = grid.centres_m(stops)[stop]
        turn = np.arange(n_frames) * len(stops) / n_frames
    else:
        places_m = _along(grid.centres_m(_round_trip(grid.cells, stops)), n_frames)
        turn = np.arange(n_frames) * max(len(stops), 2) / n_frames
    places_m = places_m + rng.normal(0.0, 0.03, places_m.shape)
    yaw = rng.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * turn
    poses = []
    for k in range(n_frames):
        height_m = min(1.5, scene.rooms[0].ceiling_m - scene.rooms[0].floor_m - 0.5)
        z = scene.rooms[0].floor_m + height_m + rng.normal(0.0, 0.04)
        # Consecutive frames nod through the pitches, so that each direction is seen at all of them.
        pitch = _PITCHES_RAD[k % 3] + rng.normal(0.0, 0.03)
        poses.append(looking(np.array([*places_m[k], z]), yaw[k] + rng.normal(0.0, 0.05), pitch))
    return tuple(poses)


def stations(scene: Scene, n_stations: int, rng: np.random.Generator) -> tuple[Pose, ...]:
    """Upright poses of a scanner on a tripod, 1.6 m high, far apart: one in each room, then where they lack.

    Raises:
        ConfigError: no free floor is left, or not one pose was asked for.
    """
    _check_count("station", n_stations)
    grid = _free_grid(scene)
    chosen: list[Int[np.ndarray, " 2"]] = []
    for room in scene.rooms[:n_stations]:
        inside = grid.cells & _in_room(room, *grid.mesh_m())
        if inside.any():
            chosen += list(_far_apart(inside, 1, rng, _IN_THE_OPEN))
    chosen += list(_far_apart(grid.cells, n_stations - len(chosen), rng, _IN_THE_OPEN, chosen))
    poses = []
    for place_m in grid.centres_m(np.array(chosen)):
        c, s = np.cos(yaw := rng.uniform(0.0, 2.0 * np.pi)), np.sin(yaw)
        z = scene.rooms[0].floor_m + 1.6
        poses.append(Pose(np.array([*place_m, z]), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])))
    return tuple(poses)


def _check_count(name: str, n: int) -> None:
    if n < 1:
        raise ConfigError(f"simulate: {n} {name}s; at least one is needed. Fix: ask for one or more.")


@dataclass(frozen=True)
class _Grid:
    """Free floor, rasterised."""

    low_m: Float[np.ndarray, " 2"]
    cells: Bool[np.ndarray, "nx ny"]

    def centres_m(self, index: Int[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Middles of cells."""
        return self.low_m + (index + 0.5) * _CELL_M

    def mesh_m(self) -> tuple[Float[np.ndarray, "nx ny"], Float[np.ndarray, "nx ny"]]:
        """Coordinates of the middles of all cells."""
        x_m, y_m = (self.low_m[k] + (np.arange(self.cells.shape[k]) + 0.5) * _CELL_M for k in range(2))
        return np.broadcast_arrays(x_m[:, None], y_m[None, :])  # type: ignore[return-value]


def _free_grid(scene: Scene) -> _Grid:
    low_m = np.min([(r.x_lines_m[0], r.y_lines_m[0]) for r in scene.rooms], axis=0)
    high_m = np.max([(r.x_lines_m[-1], r.y_lines_m[-1]) for r in scene.rooms], axis=0)
    n = np.ceil((high_m - low_m) / _CELL_M).astype(int)
    x_m, y_m = np.meshgrid(*(low_m[k] + (np.arange(n[k]) + 0.5) * _CELL_M for k in range(2)), indexing="ij")
    free = np.zeros(x_m.shape, bool)
    for room in scene.rooms:
        free |= _in_room(room, x_m, y_m)
    for opening in scene.openings:
        free |= _in_door(opening, x_m, y_m)
    for wall in scene.oblique_walls:
        (x0, y0), (x1, y1) = wall.start_m, wall.end_m
        # Behind the wall, and only in the corner that it cuts off: its line may run on through other rooms.
        behind = (x1 - x0) * (y_m - y0) - (y1 - y0) * (x_m - x0) <= 0.0
        behind &= (x_m > min(x0, x1)) & (x_m < max(x0, x1)) & (y_m > min(y0, y1)) & (y_m < max(y0, y1))
        free &= ~behind
    for item in scene.furniture:
        if item.base_m < 1.2:
            c, s = np.cos(item.yaw_rad), np.sin(item.yaw_rad)
            dx, dy = x_m - item.centre_m[0], y_m - item.centre_m[1]
            u, v = c * dx + s * dy, -s * dx + c * dy
            free &= (np.abs(u) > 0.5 * item.size_m[0]) | (np.abs(v) > 0.5 * item.size_m[1])
    # The border of the grid is wall, hence the padding.
    reach_m = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * _CELL_M  # type: ignore[index]
    labels, n_parts = ndimage.label(reach_m > _CLEARANCE_M)  # type: ignore[misc]
    if n_parts == 0:
        raise ConfigError(
            f"{scene.name}: no place to stand {_CLEARANCE_M:g} m from walls and furniture. "
            "Fix: less furniture or larger rooms."
        )
    largest = np.argmax(np.bincount(labels.ravel())[1:]) + 1
    return _Grid(low_m, labels == largest)


def _in_room(
    room: RoomPlan, x_m: Float[np.ndarray, "nx ny"], y_m: Float[np.ndarray, "nx ny"]
) -> Bool[np.ndarray, "nx ny"]:
    i, j = np.searchsorted(room.x_lines_m, x_m), np.searchsorted(room.y_lines_m, y_m)
    return np.pad(room_mask(room), 1)[i, j]


def _in_door(
    opening: Opening, x_m: Float[np.ndarray, "nx ny"], y_m: Float[np.ndarray, "nx ny"]
) -> Bool[np.ndarray, "nx ny"]:
    # A door to a corridor is not walked through: nothing is known of the floor behind it.
    if opening.kind != "door" or opening.view_m is not None:
        return np.zeros(x_m.shape, bool)
    across, along = (x_m, y_m) if opening.axis == "x" else (y_m, x_m)
    at_m, along_m = opening.centre_m if opening.axis == "x" else opening.centre_m[::-1]
    return (np.abs(across - at_m) < 0.5 * opening.reach_m) & (np.abs(along - along_m) < 0.5 * opening.width_m)


def _default_stops(grid: _Grid) -> int:
    return int(np.clip(round(grid.cells.sum() * _CELL_M**2 / 6.0), 2, 12))


def _far_apart(
    cells: Bool[np.ndarray, "nx ny"],
    n: int,
    rng: np.random.Generator,
    open_share: float = 0.5,
    before: Sequence[Int[np.ndarray, " 2"]] = (),
) -> Int[np.ndarray, "n 2"]:
    """Free cells, each as far as possible from those before it; the very first at random."""
    free = np.argwhere(cells)
    # People stand in the middle of things, not in corners: only the roomier part of the floor counts.
    reach = ndimage.distance_transform_edt(np.pad(cells, 1))[1:-1, 1:-1]  # type: ignore[index]
    roominess = reach[tuple(free.T)]
    free = free[roominess >= min(10.0 * open_share, float(np.quantile(roominess, open_share)))]
    chosen = list(before)
    while len(chosen) < len(before) + n:
        if not chosen:
            chosen.append(free[rng.integers(len(free))])
            continue
        distance = np.min([((free - c) ** 2).sum(axis=1) for c in chosen], axis=0)
        chosen.append(free[np.argmax(distance * rng.uniform(0.7, 1.0, len(free)))])
    return np.array(chosen[len(before) :], int).reshape(-1, 2)


def _round_trip(cells: Bool[np.ndarray, "nx ny"], stops: Int[np.ndarray, "n 2"]) -> Int[np.ndarray, "m 2"]:
    """Cells along the shortest ways from each stop to the nearest unvisited one, and back to the first."""
    free = np.argwhere(cells)
    number = np.full(cells.shape, -1)
    number[tuple(free.T)] = np.arange(len(free))
    links = []
    for shift in ((1, 0), (0, 1), (1, 1), (1, -1)):
        padded = np.pad(number, 1, constant_values=-1)
        other = padded[1 + free[:, 0] + shift[0], 1 + free[:, 1] + shift[1]]
        here = np.flatnonzero(other >= 0)
        links.append((here, other[here], np.full(len(here), np.hypot(*shift))))
    a, b, length = (np.concatenate(part) for part in zip(*links, strict=True))
    graph = sparse.coo_matrix((length, (a, b)), shape=(len(free), len(free)))
    nodes = number[tuple(stops.T)]
    distance, before = csgraph.dijkstra(graph, directed=False, indices=nodes, return_predecessors=True)
    route, todo = [0], set(range(1, len(stops)))
    while todo:
        nearest = min(todo, key=lambda k: (distance[route[-1], nodes[k]], k))
        todo.remove(nearest)
        route.append(nearest)
    way = [int(nodes[0])]
    for start, end in zip(route, [*route[1:], 0], strict=True):
        leg, node = [], int(nodes[end])
        while node != nodes[start] and node >= 0:
            leg.append(node)
            node = int(before[start, node])
        way += leg[::-1]
    return free[way]


def _along(way_m: Float[np.ndarray, "m 2"], n: int) -> Float[np.ndarray, "n 2"]:
    """Points at even distances along a way."""
    if len(way_m) == 1:
        return np.repeat(way_m, n, axis=0)
    length_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way_m, axis=0), axis=1))])
    at_m = np.arange(n) / n * length_m[-1]
    return np.stack([np.interp(at_m, length_m, way_m[:, k]) for k in range(2)], axis=1)
