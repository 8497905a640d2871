"""The joint fit: association and least squares in turn until neither moves."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from indoorfit.errors import InputError
from indoorfit.model import Frame, Scan, Shape

from .association import AssociationConfig, associate
from .least_squares import solve
from .moments import plane_moments
from .order import unpassed
from .patches import PatchData
from .residuals import build_cells
from .uncertainty import Cells
from .uncertainty.location import student_t_precisions
from .yaws import turned_to, turning_freely


@dataclass(frozen=True)
class JointConfig:
    """Settings of the joint fit."""

    association: AssociationConfig = field(default_factory=AssociationConfig)
    """Which points belong to a plane."""
    max_rounds: int = 12
    """Rounds of association and least squares; three are usual."""
    settle: float = 0.01
    """The association stands still when nothing moved by more than this share of the reach: points at
    its edge have no weight, and the location within a patch does not depend on the plane."""
    coarse_points: int = 150_000
    """The first rounds use at most this many points, every k-th; the last ones use all."""
    student_dof: float = 4.0
    """Tail of the weights between cells: wide enough for patches on furniture to lose their say."""


@dataclass(frozen=True)
class JointFit:
    """The fitted shape and the residuals that its uncertainty is made of."""

    shape: Shape
    frame: Frame
    data: PatchData
    cells: Cells
    cost: float
    """Half the weighted sum of squares at the minimum."""
    steps: int
    """Solver steps of the last round."""
    rounds: int
    converged: bool
    restless: tuple[int, ...]
    """Planes that still moved in the last rounds, the farthest first; where the fit converged, to and fro."""
    swing_m: Float[np.ndarray, " planes"]
    """Half the distance of the places that a restless plane goes back and forth between, in whose middle it
    is then put; its last movement where it does not come back; 0 at rest."""


def fit_joint(scan: Scan, frame: Frame, start: Shape, config: JointConfig, pixel_m: float) -> JointFit:
    """Fit the shared rotation and all plane offsets to the points together.

    The normals of all planes follow one rotation, each plane has one offset (statistics 3.1). Points
    enter as robust locations of patches, patches with Student-t weights, planes as moments.

    Args:
        scan: metres, scan frame.
        frame: Manhattan frame, right within a few degrees.
        start: the grammar with planes within half the reach of their places.
        config: see `JointConfig`.
        pixel_m: resolution at which coverage is counted.

    Returns:
        the minimum; a plane that goes back and forth between the same places is in the middle of them.
        `converged` is False where the solver or the association came neither to rest nor to such a cycle. A
        plane that passed another one is put back and not fitted (`unpassed`).
    """
    fit = _alternate(scan, frame, start, config, pixel_m)
    for _ in range(_MAX_REPAIRS):
        repaired = unpassed(start, fit.shape, fit.data.plane_points)
        if repaired is None:
            return fit
        fit = _alternate(scan, fit.frame, repaired, config, pixel_m)
    return replace(fit, converged=False)


_MAX_REPAIRS = 5
"""Fits with one or more planes less; each repair leaves fewer planes that can pass another."""


def _alternate(scan: Scan, frame: Frame, start: Shape, config: JointConfig, pixel_m: float) -> JointFit:
    """Rounds of association and least squares until neither moves."""
    local_m = scan.points_m - frame.origin_scan_m
    stride = max(1, len(local_m) // config.coarse_points)
    state = _State(start, frame.R_manhattan_scan)
    still, rounds, steps, trail = False, 0, 0, [start.offsets_m]
    limit_m = config.settle * config.association.reach_m
    # Coarse rounds until the association stands still, then rounds with all points.
    for step in ([stride] if stride > 1 else []) + [1]:
        still = False
        trail = trail[-1:] if rounds < config.max_rounds else trail
        # What came back twice goes on like that.
        while not still and _period(trail, limit_m, 2) is None and rounds < config.max_rounds:
            rounds += 1
            state, moved_m, steps = _round(local_m[::step], state, config, pixel_m)
            trail.append(state.shape.offsets_m)
            still = moved_m < limit_m
    middle_m, swing_m = _swing(trail, limit_m)
    assert state.data is not None, "at least one round was made"
    data = _moved_along(state.data, state.shape, middle_m)
    shape = state.shape.with_offsets(middle_m)
    return JointFit(
        shape=shape,
        frame=Frame(state.rotation, frame.origin_scan_m),
        data=data,
        cells=build_cells(data.patches, shape),
        cost=state.cost,
        steps=steps,
        rounds=rounds,
        converged=(still or _period(trail, limit_m, 1) is not None) and state.solved,
        restless=tuple(int(k) for k in np.argsort(-swing_m) if swing_m[k] > 0.0),
        swing_m=swing_m,
    )


def _period(trail_m: list[Float[np.ndarray, " planes"]], limit_m: float, times: int) -> int | None:
    """After how many rounds all planes are again where they are now, so many times; None if they are not.

    Planes that stand still are not asked about: a period has two rounds or more.
    """
    last_m = trail_m[-1]
    for period in range(2, (len(trail_m) - 1) // times + 1):
        before = [trail_m[-1 - k * period] for k in range(1, times + 1)]
        if all(np.all(np.abs(last_m - offsets_m) < limit_m) for offsets_m in before):
            return period
    return None


def _swing(
    trail_m: list[Float[np.ndarray, " planes"]], limit_m: float
) -> tuple[Float[np.ndarray, " planes"], Float[np.ndarray, " planes"]]:
    """Where planes are after the last round, and how far that is in doubt.

    Two layers of a wall may each hand the plane on to the other one, for as long as one looks. No round's
    place is better than another's, for each has its own points: the middle of the cycle has the least
    expected square error. A law with both places alike has half their distance as its standard deviation.

    Args:
        trail_m: offsets of the planes, the last round last.
        limit_m: movements below it are none.
    """
    last_m = trail_m[-1]
    restless = np.abs(last_m - trail_m[-2]) >= limit_m if len(trail_m) > 1 else np.zeros(len(last_m), bool)
    middle_m, swing_m = last_m.copy(), np.zeros(len(last_m))
    period = _period(trail_m, limit_m, 1)
    if period is not None:
        cycle_m = np.array(trail_m[-period:])
        low_m, high_m = cycle_m.min(axis=0), cycle_m.max(axis=0)
        restless = high_m - low_m >= limit_m
        middle_m[restless] = 0.5 * (low_m + high_m)[restless]
        swing_m[restless] = 0.5 * (high_m - low_m)[restless]
        return middle_m, swing_m
    swing_m[restless] = np.abs(last_m - trail_m[-2])[restless]
    return middle_m, swing_m


def _moved_along(data: PatchData, shape: Shape, offsets_m: Float[np.ndarray, " planes"]) -> PatchData:
    """The patches with their planes: residuals stay as they are."""
    patches = data.patches
    normals = np.array([plane.normal for plane in shape.planes])[patches.plane]
    means_m = patches.means_m + (offsets_m - shape.offsets_m)[patches.plane][:, None] * normals
    return replace(data, patches=replace(patches, means_m=means_m))


@dataclass(frozen=True)
class _State:
    """Where the alternation stands."""

    shape: Shape
    rotation: Float[np.ndarray, "3 3"]
    data: PatchData | None = None
    cost: float = 0.0
    solved: bool = False


def _round(
    local_m: Float[np.ndarray, "points 3"], state: _State, config: JointConfig, pixel_m: float
) -> tuple[_State, float, int]:
    """One association and one least squares solution; also the largest movement (m) and solver steps."""
    shape = state.shape
    data = associate(local_m @ state.rotation.T, shape, config.association, pixel_m)
    patches = data.patches
    if len(patches.plane) == 0:
        raise InputError(
            "fit: no points lie on the walls that were found. Fix: check --unit; lower segment.min_surfels."
        )
    weights = student_t_precisions(build_cells(patches, shape), config.student_dof)
    normals = np.array([plane.normal for plane in shape.planes])
    moments = plane_moments(patches.means_m, patches.plane, weights, len(normals))
    solution = solve(turning_freely(moments, shape), normals, shape.offsets_m)
    turn = Rotation.from_rotvec(solution.rotation_rad).as_matrix()
    # Planes without points stay where they are, to the bit: several may share one place.
    seen = np.bincount(patches.plane, minlength=len(normals)) > 0
    offsets_m = np.where(seen, solution.offsets_m, shape.offsets_m)
    # The planes' normals turned by `turn`, so in the new frame the points turn back.
    patches = replace(patches, means_m=patches.means_m @ turn)
    moved_m = float(np.max(np.abs(offsets_m - shape.offsets_m)))
    moved_m += float(np.max(np.abs(solution.rotation_rad)) * np.max(np.abs(patches.means_m)))
    shape, turned_m = turned_to(shape.with_offsets(offsets_m), patches, weights)
    moved_m += turned_m
    after = _State(
        shape=shape,
        rotation=turn.T @ state.rotation,
        data=replace(data, patches=patches),
        cost=solution.cost,
        solved=solution.converged,
    )
    return after, moved_m, solution.steps
