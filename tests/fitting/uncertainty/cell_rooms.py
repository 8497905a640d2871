"""Simulated rooms at cell level: tiles of walls seen by badly registered frames, without casting rays.

A `tile` is a 0.25 m square of a plane as seen in one frame: a number of points with one common error (pose,
warped wall, lens) and Kinect noise. Tiles are gathered to cells as a fit would gather its points. Pose errors
act exactly (finite rotations), so the linear models are tested against something that they are not.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial.transform import Rotation

from indoorfit.fitting.uncertainty import Cells, Contrasts
from indoorfit.fitting.uncertainty.location import student_t_precisions, weighted_map
from indoorfit.geometry import MAD_TO_STD

TILE_M = 0.25
FOCAL_PX = 59.0  # 64 x 48 rays over 57 x 43 degrees
HALF_FOV = np.tan(np.deg2rad([28.5, 21.5]))
RANGE_M = 0.5, 5.0
NOISE_PER_M = 1.425e-3  # Khoshelham and Elberink 2012
FEW_POINTS = 300  # planes with fewer are not scored
DISPLACED_FACE = 6


@dataclass(frozen=True)
class Regime:
    """What is wrong with a scan."""

    pose_m: float
    """Root mean square pose error per axis; rotation: a third of it in radians."""
    dirty: bool = False
    """Wavy walls, lens bowl, incidence bias, protrusions, furniture, windows."""
    slipped_block: bool = False
    """8 to 20 % of the frames displaced together by 6 cm and a degree."""
    displaced_face: bool = False
    """All frames that see one notch face displaced by 15 cm (the thesis' dimension D)."""


REGIMES = {
    "p0": Regime(0.0),
    "p5": Regime(0.005),
    "p20": Regime(0.02),
    "p50": Regime(0.05),
    "p5real": Regime(0.005, dirty=True),
    "p20real": Regime(0.02, dirty=True),
    "p5bad": Regime(0.005, dirty=True, slipped_block=True),
    "D": Regime(0.005, dirty=True, displaced_face=True),
}


@dataclass(frozen=True)
class Walls:
    """Rectangles: axis, offset, and the extent along the two other axes."""

    axis: Int[np.ndarray, " planes"]
    offset_m: Float[np.ndarray, " planes"]
    low_m: Float[np.ndarray, "planes 3"]
    high_m: Float[np.ndarray, "planes 3"]
    notch_m: Float[np.ndarray, "2 2"] | None
    """Low and high corner of the notch in plan, or None for a box."""


@dataclass(frozen=True)
class Tiles:
    """What was seen: one row per frame and tile."""

    plane: Int[np.ndarray, " tiles"]
    frame: Int[np.ndarray, " tiles"]
    points_m: Float[np.ndarray, "tiles 3"]
    count: Float[np.ndarray, " tiles"]
    noise_m: Float[np.ndarray, " tiles"]


@dataclass(frozen=True)
class CellRoom:
    """One scan, as a fit would hand it over, with its truth."""

    cells: Cells
    """Plane x 0.7 m patch, frames mixed."""
    frame_cells: Cells
    """Frame x plane x 1 m patch."""
    contrasts: Contrasts
    truth_m: Float[np.ndarray, " dims"]
    kinds: tuple[str, ...]
    iid_covariance_m2: Float[np.ndarray, "params params"]
    """Of all points as if they were independent, around the common residual scatter."""
    pose_errors: Float[np.ndarray, "frames 6"]
    """True (shift m, rotation rad) of every frame."""


def simulate_cell_room(seed: int, regime: Regime) -> CellRoom:
    """A random box or L room with a random trajectory; same seed, same room and path in every regime."""
    rng = np.random.default_rng([seed, 77])
    walls = _random_walls(rng, notch=regime.displaced_face or rng.random() < 0.6)
    centres, rotations = _random_path(rng, walls)
    tiles = _see(walls, centres, rotations)
    poses = _pose_errors(rng, len(centres), regime, tiles)
    if regime.dirty:
        tiles = _dirty(rng, walls, tiles, centres, rotations)
    tiles = replace(tiles, points_m=_displace(tiles, centres, poses) + _noise(rng, walls, tiles))
    return _gather(walls, tiles, centres, poses)


def _random_walls(rng: np.random.Generator, notch: bool) -> Walls:
    length, width = rng.uniform(3, 7, 2)
    height = rng.uniform(2.3, 3.2)
    cut = np.array([rng.uniform(0.2, 1.5), rng.uniform(0.2, 1.5)]) if notch else np.zeros(2)
    inner = np.array([length, width]) - cut
    rows = [
        (2, 0.0, (0, 0, 0), (length, width, 0)),
        (2, height, (0, 0, height), (length, width, height)),
        (0, 0.0, (0, 0, 0), (0, width, height)),
        (0, length, (length, 0, 0), (length, inner[1], height)),
        (1, 0.0, (0, 0, 0), (length, 0, height)),
        (1, width, (0, width, 0), (inner[0], width, height)),
    ]
    if notch:
        rows.append((0, inner[0], (inner[0], inner[1], 0), (inner[0], width, height)))
        rows.append((1, inner[1], (inner[0], inner[1], 0), (length, inner[1], height)))
    axis, offset, low, high = zip(*rows, strict=True)
    middle = np.array([length, width, height]) / 2
    axes = np.array(axis)
    corners = np.array([inner, [length, width]]) - middle[:2] if notch else None
    return Walls(
        axes, np.array(offset, float) - middle[axes], np.array(low) - middle, np.array(high) - middle, corners
    )


def _random_path(
    rng: np.random.Generator, walls: Walls
) -> tuple[Float[np.ndarray, "frames 3"], Float[np.ndarray, "frames 3 3"]]:
    frames = int(rng.integers(20, 151))
    half = walls.high_m.max(axis=0)
    floor_m = walls.low_m[0, 2]

    def inside(count: int) -> Float[np.ndarray, "count 2"]:
        spots = rng.uniform(-0.7, 0.7, (100 * count, 2)) * half[:2]
        if walls.notch_m is not None:
            spots = spots[~np.all(spots > walls.notch_m[0] - 0.3, axis=1)]
        return spots[:count]

    if rng.random() < 0.5:  # spin at a few stations
        stations = inside(int(rng.integers(1, 5)))
        which = np.sort(np.arange(frames) % len(stations))
        plan = stations[which] + 0.03 * rng.standard_normal((frames, 2))
        heading = np.arange(frames) * 2 * np.pi * len(stations) / frames
    else:  # walk around a loop, looking outward and about
        angle = np.linspace(0, 2 * np.pi, frames, endpoint=False)
        plan = 0.35 * np.column_stack([np.cos(angle), np.sin(angle)]) * half[:2]
        heading = angle + 0.5 * np.sin(3 * angle)
    heading = heading + 0.1 * rng.standard_normal(frames)
    pitch = np.deg2rad(np.array([-28.0, -3.0, 24.0])[np.arange(frames) % 3]) + 0.03 * rng.standard_normal(
        frames
    )
    centres = np.column_stack([plan, floor_m + 1.4 + 0.05 * rng.standard_normal(frames)])
    forward = np.column_stack(
        [np.cos(heading) * np.cos(pitch), np.sin(heading) * np.cos(pitch), np.sin(pitch)]
    )
    right = np.column_stack([np.sin(heading), -np.cos(heading), np.zeros(frames)])
    return centres, np.stack([right, np.cross(forward, right), forward], axis=1)


def _tile_centres(walls: Walls) -> tuple[Int[np.ndarray, " tiles"], Float[np.ndarray, "tiles 3"]]:
    planes, points = [], []
    for plane, axis in enumerate(walls.axis):
        along = [a for a in range(3) if a != axis]
        grids = [np.arange(walls.low_m[plane, a] + TILE_M / 2, walls.high_m[plane, a], TILE_M) for a in along]
        mesh = np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1).reshape(-1, 2)
        tile = np.full((len(mesh), 3), walls.offset_m[plane])
        tile[:, along] = mesh
        if axis == 2 and walls.notch_m is not None:
            tile = tile[~np.all(tile[:, :2] > walls.notch_m[0], axis=1)]
        planes.append(np.full(len(tile), plane))
        points.append(tile)
    return np.concatenate(planes), np.concatenate(points)


def _hidden(
    walls: Walls, eyes: Float[np.ndarray, "frames 1 3"], spots: Float[np.ndarray, "tiles 3"]
) -> Bool[np.ndarray, "frames tiles"]:
    """Whether the line of sight passes through the notch (a clipped segment against the box, in plan)."""
    if walls.notch_m is None:
        return np.zeros((len(eyes), len(spots)), bool)
    start, ray = eyes[..., :2], spots[None, :, :2] - eyes[..., :2]
    ray = np.where(np.abs(ray) < 1e-12, 1e-12, ray)
    first, second = ((walls.notch_m[k] + (0.01 if k == 0 else 9.0) - start) / ray for k in (0, 1))
    enter = np.minimum(first, second).max(axis=2)
    leave = np.maximum(first, second).min(axis=2)
    return (enter < leave) & (enter < 1) & (leave > 0)


def _see(
    walls: Walls, centres: Float[np.ndarray, "frames 3"], rotations: Float[np.ndarray, "frames 3 3"]
) -> Tiles:
    plane, spots = _tile_centres(walls)
    rays = spots[None] - centres[:, None]
    local = np.einsum("fab,ftb->fta", rotations, rays)
    depth = np.maximum(local[..., 2], 1e-6)
    distance = np.linalg.norm(rays, axis=2)
    cosine = np.abs(np.take_along_axis(rays, walls.axis[plane][None, :, None], axis=2)[..., 0]) / distance
    visible = (local[..., 2] > RANGE_M[0]) & (depth < RANGE_M[1]) & (cosine > 0.1)
    visible &= np.all(np.abs(local[..., :2]) < HALF_FOV * depth[..., None], axis=2)
    visible &= ~_hidden(walls, centres[:, None], spots)
    frame, tile = np.nonzero(visible)
    count = np.maximum(np.round(TILE_M**2 * cosine * FOCAL_PX**2 / depth**2)[visible], 1.0)
    noise = NOISE_PER_M * depth[visible] ** 2 * np.maximum(cosine[visible], 0.2)
    return Tiles(plane[tile], frame, spots[tile], count, noise)


def _pose_errors(
    rng: np.random.Generator, frames: int, regime: Regime, tiles: Tiles
) -> Float[np.ndarray, "frames 6"]:
    """Brownian bridge with incomplete loop closure, plus white, plus the regime's special slips."""
    share = rng.uniform(0.3, 0.9)
    walk = np.cumsum(rng.standard_normal((frames, 6)), axis=0)
    ramp = np.linspace(0, 1, frames)[:, None]
    bridge = walk - rng.uniform(0.5, 1.0) * ramp * walk[-1]
    white = rng.standard_normal((frames, 6))
    bridge /= np.sqrt(np.mean(bridge**2))
    errors = regime.pose_m * (np.sqrt(share) * bridge + np.sqrt(1 - share) * white)
    errors[:, 3:] /= 3
    slip, block = rng.standard_normal(6), rng.uniform(0.08, 0.2)
    first = int(rng.integers(0, frames))
    if regime.slipped_block:
        chosen = (first + np.arange(max(1, int(block * frames)))) % frames
        scale = np.array([0.06] * 3 + [np.deg2rad(1.0)] * 3) / np.sqrt(3)
        errors[chosen] += slip * scale
        errors[chosen, :3] += 0.02 * rng.standard_normal((len(chosen), 3))
    if regime.displaced_face:
        seeing = np.unique(tiles.frame[tiles.plane == DISPLACED_FACE])
        errors[seeing, 0] += 0.15
    return errors


def _dirty(
    rng: np.random.Generator,
    walls: Walls,
    tiles: Tiles,
    centres: Float[np.ndarray, "frames 3"],
    rotations: Float[np.ndarray, "frames 3 3"],
) -> Tiles:
    """Errors that belong to the wall or the lens and not to the pose; positive is along +axis."""
    planes = len(walls.axis)
    waves = rng.standard_normal((planes, 6, 3)) * 2 * np.pi / rng.uniform(2, 8, (planes, 6, 1))
    phase, weight = rng.uniform(0, 2 * np.pi, (planes, 6)), rng.standard_normal((planes, 6)) / np.sqrt(3)
    angle = np.einsum("twk,tk->tw", waves[tiles.plane], tiles.points_m) + phase[tiles.plane]
    shift = 0.004 * np.sum(weight[tiles.plane] * np.cos(angle), axis=1)
    rays = tiles.points_m - centres[tiles.frame]
    local = np.einsum("tab,tb->ta", rotations[tiles.frame], rays)
    radius2 = np.sum((local[:, :2] / local[:, 2:] / HALF_FOV) ** 2, axis=1)
    along = np.take_along_axis(rays, walls.axis[tiles.plane][:, None], axis=1)[:, 0]
    cosine = np.abs(along) / np.linalg.norm(rays, axis=1)
    shift += (0.004 * (radius2 - 0.67) + 0.003 * (1 - cosine)) * np.sign(along)
    count = tiles.count.copy()
    into_room = -np.sign(walls.offset_m[tiles.plane])  # towards the origin, good enough for patches
    for kind in ["patch"] * int(rng.integers(2, 6)) + ["furniture"] * 2 + ["window"] * 2:
        plane = int(rng.integers(2, planes))
        size = rng.uniform(0.3, 1.2, 3) * (2.0 if kind != "patch" else 1.0)
        # A face that is more than half hidden has no position: a fit measures what hides it.
        size = np.minimum(size, 0.6 * (walls.high_m[plane] - walls.low_m[plane]))
        low = rng.uniform(
            walls.low_m[plane], np.maximum(walls.high_m[plane] - size, walls.low_m[plane] + 1e-9)
        )
        if kind == "furniture":
            low[2] = walls.low_m[0, 2]
        here = (tiles.plane == plane) & np.all((tiles.points_m >= low - 1e-9), axis=1)
        spare = np.arange(3) != walls.axis[plane]
        here &= np.all((tiles.points_m <= low + size)[:, spare], axis=1)
        step = rng.uniform(0.015, 0.10) * (1 if rng.random() < 0.7 or kind == "furniture" else -1)
        shift[here] += 0.0 if kind == "window" else step * into_room[here]
        # A tenth of a cupboard's points lies near enough to pass for wall; a window has none.
        count[here] *= {"patch": 1.0, "furniture": 0.1, "window": 0.0}[kind]
    points = tiles.points_m.copy()
    points[np.arange(len(points)), walls.axis[tiles.plane]] += shift
    keep = count >= 1.0
    return Tiles(
        tiles.plane[keep], tiles.frame[keep], points[keep], np.round(count[keep]), tiles.noise_m[keep]
    )


def _displace(
    tiles: Tiles, centres: Float[np.ndarray, "frames 3"], poses: Float[np.ndarray, "frames 6"]
) -> Float[np.ndarray, "tiles 3"]:
    turn = Rotation.from_rotvec(poses[tiles.frame, 3:])
    arm = tiles.points_m - centres[tiles.frame]
    return turn.apply(arm) + centres[tiles.frame] + poses[tiles.frame, :3]


def _noise(rng: np.random.Generator, walls: Walls, tiles: Tiles) -> Float[np.ndarray, "tiles 3"]:
    noise = np.zeros_like(tiles.points_m)
    scaled = tiles.noise_m / np.sqrt(tiles.count) * rng.standard_normal(len(tiles.count))
    noise[np.arange(len(noise)), walls.axis[tiles.plane]] = scaled
    return noise


def _design(
    axis: Int[np.ndarray, " rows"],
    plane: Int[np.ndarray, " rows"],
    points_m: Float[np.ndarray, "rows 3"],
    planes: int,
) -> Float[np.ndarray, "rows params"]:
    rotation = np.cross(np.eye(3)[axis], points_m)
    return np.hstack([rotation, -np.eye(planes)[plane]])


def _cells(
    walls: Walls,
    tiles: Tiles,
    key: Int[np.ndarray, " tiles"],
    offset_m: Float[np.ndarray, " planes"],
    centres: Float[np.ndarray, "frames 3"] | None,
) -> Cells:
    """Robust location per key: weighted median, then two Tukey steps; noise as three points per tile."""
    _, group = np.unique(key, return_inverse=True)
    groups = int(group.max()) + 1
    axis = walls.axis[tiles.plane]
    residual = tiles.points_m[np.arange(len(axis)), axis] - offset_m[tiles.plane]
    spread = tiles.noise_m[:, None] * np.array([-1.0, 0.0, 1.0]) * np.sqrt(1.5)
    value = (residual[:, None] + spread).ravel()
    weight, owner = np.repeat(tiles.count / 3, 3), np.repeat(group, 3)
    total = np.bincount(group, tiles.count)
    centre = _median(value, weight, owner, groups)
    scale = np.maximum(MAD_TO_STD * _median(np.abs(value - centre[owner]), weight, owner, groups), 1e-9)
    for _ in range(2):
        part = (value - centre[owner]) / (4.685 * scale[owner])
        bite = weight * np.where(np.abs(part) < 1, (1 - part**2) ** 2, 0.0)
        centre = np.bincount(owner, bite * value, groups) / np.bincount(owner, bite, groups)
    variance = (
        np.bincount(owner, weight * np.minimum(value - centre[owner], 3 * scale[owner]) ** 2, groups) / total
    )
    where = np.column_stack(
        [np.bincount(group, tiles.count * tiles.points_m[:, k]) / total for k in range(3)]
    )
    plane = np.zeros(groups, int)
    plane[group] = tiles.plane
    frame = np.zeros(groups, int)
    frame[group] = tiles.frame
    keep = total >= 5
    design = _design(walls.axis[plane], plane, where, len(walls.axis))
    return Cells(
        plane[keep], design[keep], where[keep], centre[keep], (variance / total)[keep], total[keep],
        frame[keep] if centres is not None else None, centres,
    )  # fmt: skip


def _median(
    value: Float[np.ndarray, " rows"],
    weight: Float[np.ndarray, " rows"],
    owner: Int[np.ndarray, " rows"],
    groups: int,
) -> Float[np.ndarray, " groups"]:
    order = np.lexsort((value, owner))
    running = np.cumsum(weight[order])
    total = np.bincount(owner, weight, groups)
    target = np.concatenate([[0.0], np.cumsum(total)[:-1]]) + total / 2
    return value[order][np.minimum(np.searchsorted(running, target), len(order) - 1)]


def _patch_key(walls: Walls, tiles: Tiles, size_m: float) -> Int[np.ndarray, " tiles"]:
    step = np.floor(tiles.points_m / size_m).astype(int) + 500
    step[np.arange(len(step)), walls.axis[tiles.plane]] = 0
    return ((tiles.plane * 1000 + step[:, 0]) * 1000 + step[:, 1]) * 1000 + step[:, 2]


def _gather(
    walls: Walls, tiles: Tiles, centres: Float[np.ndarray, "frames 3"], poses: Float[np.ndarray, "frames 6"]
) -> CellRoom:
    """Fit the Manhattan frame and the offsets robustly, then express everything there."""
    planes = len(walls.axis)
    offset, turned, eyes = walls.offset_m.copy(), tiles.points_m, centres
    for _ in range(3):
        rough = _cells(walls, replace(tiles, points_m=turned), _patch_key(walls, tiles, 0.7), offset, None)
        step = weighted_map(rough, student_t_precisions(rough, 4.0)) @ rough.residuals_m
        back = Rotation.from_rotvec(step[:3]).inv()
        turned, eyes, offset = back.apply(turned), back.apply(eyes), offset + step[3:]
    tiles = replace(tiles, points_m=turned)
    key = _patch_key(walls, tiles, 0.7)
    cells = _cells(walls, tiles, key, offset, None)
    coarse = _patch_key(walls, tiles, 1.0)
    frame_cells = _cells(walls, tiles, coarse * 1000 + tiles.frame, offset, eyes)
    rows = [(3, 2), (5, 4), (1, 0)] + ([(3, 6), (5, 7)] if planes > 6 else [])
    kinds = ("length", "length", "height") + (("step", "step") if planes > 6 else ())
    points = np.bincount(tiles.plane, tiles.count, planes)
    scored = [k for k, pair in enumerate(rows) if min(points[list(pair)]) >= FEW_POINTS]
    matrix = np.zeros((len(scored), 3 + planes))
    for line, k in zip(matrix, scored, strict=True):
        line[3 + rows[k][0]], line[3 + rows[k][1]] = 1.0, -1.0
    design = _design(walls.axis[tiles.plane], tiles.plane, turned, planes)
    axis = walls.axis[tiles.plane]
    residual = turned[np.arange(len(axis)), axis] - offset[tiles.plane]
    scatter = np.average(residual**2 + tiles.noise_m**2, weights=tiles.count)
    iid = scatter * np.linalg.pinv((design.T * tiles.count) @ design)
    return CellRoom(
        cells, frame_cells,
        Contrasts(matrix, np.concatenate([np.zeros(3), offset])),
        matrix[:, 3:] @ walls.offset_m,
        tuple(kinds[k] for k in scored), iid, poses,
    )  # fmt: skip
