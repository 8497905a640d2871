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
from .order import as_started, unpassed
from .patches import PatchData
from .residuals import build_cells
from .rest import called, search_from
from .uncertainty import Cells
from .uncertainty.location import student_t_precisions
from .yaws import turned_to, turning_freely


@dataclass(frozen=True)
class JointConfig:
    """Settings of the joint fit."""

    association: AssociationConfig = field(default_factory=AssociationConfig)
    """Which points belong to a plane."""
    max_rounds: int = 40
    """Rounds of association and least squares; three to six are usual. Walls of few points are found patch by
    patch, which took up to 28; halving the reach down to a tenth of a millimetre takes ten."""
    settle: float = 0.01
    """Planes rest where their points call them no farther than this share of the reach: points at its edge
    have no weight, and the location within a patch does not depend on the plane."""
    coarse_points: int = 150_000
    """The first rounds, half of all at most, use this many points, every k-th; the last ones use all."""
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
    swing_m: Float[np.ndarray, " planes"]
    """How far the points of each plane call it away from where it is (`Search`): 0 where it is their fixed
    point, else to both sides, or to one if the rounds ran out before it was at rest."""
    put_back: tuple[int, ...] = ()
    """Planes that passed others: they stand where these let them, and are not fitted."""


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
        the minimum; `converged` is False where the solver or the association did not come to rest. A plane
        that passed another one is put back and not fitted (`unpassed`); the shape is always in order.
    """
    fit, repairs = _alternate(scan, frame, start, config, pixel_m), 0
    while (repaired := unpassed(start, fit.shape, fit.data.plane_points)) is not None:
        # Each time fewer planes move, or in the end fewer directions of rooms have planes that do.
        repairs += 1
        if repairs > _MAX_REPAIRS:
            repaired = as_started(start, fit.shape)
        fit = _alternate(scan, fit.frame, repaired, config, pixel_m)
    pairs = zip(start.planes, fit.shape.planes, strict=True)
    back = [k for k, (old, new) in enumerate(pairs) if (old.status, new.status) == ("observed", "inferred")]
    return replace(fit, put_back=tuple(back))


_MAX_REPAIRS = 5
"""Fits with single planes less; then whole directions of a room go back to where they began."""


def _alternate(scan: Scan, frame: Frame, start: Shape, config: JointConfig, pixel_m: float) -> JointFit:
    """Rounds of association and least squares until every plane is where it can stay."""
    local_m = scan.points_m - frame.origin_scan_m
    stride = max(1, len(local_m) // config.coarse_points)
    state, search = _State(start, frame.R_manhattan_scan), search_from(start.offsets_m)
    still, rounds, steps = False, 0, 0
    limit_m = config.settle * config.association.reach_m
    # Coarse rounds until the planes rest, but half of all at most; then rounds with all points.
    stages = [(1, config.max_rounds)]
    if stride > 1:
        stages.insert(0, (stride, config.max_rounds // 2))
    for step, last in stages:
        still = False
        search = search_from(search.place_m) if rounds < last else search
        while not still and rounds < last:
            rounds += 1
            tried = replace(state, shape=state.shape.with_offsets(search.place_m))
            state, turned_m, steps = _round(local_m[::step], tried, config, pixel_m)
            search = called(search, state.shape.offsets_m, limit_m)
            still = turned_m < limit_m and bool(np.all(search.rests))
    assert state.data is not None, "at least one round was made"
    data = _moved_along(state.data, state.shape, search.stay_m)
    shape = state.shape.with_offsets(search.stay_m)
    return JointFit(
        shape=shape,
        frame=Frame(state.rotation, frame.origin_scan_m),
        data=data,
        cells=build_cells(data.patches, shape),
        cost=state.cost,
        steps=steps,
        rounds=rounds,
        converged=still and state.solved,
        swing_m=search.swing_m,
    )


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
    """One association and one least squares solution; also how far its turns move (m) and solver steps."""
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
    turned_m = float(np.max(np.abs(solution.rotation_rad)) * np.max(np.abs(patches.means_m)))
    shape, yawed_m = turned_to(shape.with_offsets(offsets_m), patches, weights)
    after = _State(
        shape=shape,
        rotation=turn.T @ state.rotation,
        data=replace(data, patches=patches),
        cost=solution.cost,
        solved=solution.converged,
    )
    return after, turned_m + yawed_m, solution.steps
