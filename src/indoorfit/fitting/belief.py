"""What is believed of the planes after the fit: one geometry, and how far it may be off."""

from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from indoorfit.errors import ConfigError, SamplingError
from indoorfit.geometry import reverted, room_of_planes
from indoorfit.model import Frame, Note, Shape

from .displaced import DisplacedConfig, Displacements, doubt_covariance
from .residuals import with_inferred
from .uncertainty import (
    Cells,
    Contrasts,
    FrameSlips,
    FusionConfig,
    PoseFieldConfig,
    Predictive,
    SamplerConfig,
    WallFieldConfig,
    fuse,
    pose_field_predictive,
    pose_obstacle,
    sample_wall_field,
    wall_field_predictive,
)


@dataclass(frozen=True)
class BeliefConfig:
    """The noise models."""

    use_frames: bool = True
    """Take the slips of the frames out where the scan keeps frame ids: at 2 cm drift intervals are a fifth as
    wide, and lengths a third as far off. Needs 8 frames, and every face seen by two of them; takes some
    seconds for each hundred frames. False takes the cloud as one whole, as without ids."""
    wall_field: WallFieldConfig = field(default_factory=WallFieldConfig)
    """The Gaussian-process field of wall residuals: for any scan."""
    pose_field: PoseFieldConfig = field(default_factory=PoseFieldConfig)
    """Random slips of the frames: for scans that keep the frame of every point."""
    displaced: DisplacedConfig = field(default_factory=DisplacedConfig)
    """When frames count as registered somewhere else; they are put back before the plan is looked for."""
    fusion: FusionConfig = field(default_factory=FusionConfig)
    """When the two contradict each other."""
    inflation: float = 1.0
    """Factor on every standard uncertainty and on both sides of every interval, which is the same as one on
    all noise scales. 1 takes the noise model at its word; `indoorfit calibrate` learns it from a tape."""

    def __post_init__(self) -> None:
        if not self.inflation > 0.0:
            raise ConfigError(
                f"belief.inflation: got {self.inflation}; a positive number is needed. Fix: write 1.0."
            )


@dataclass(frozen=True)
class Belief:
    """A geometry and one or two distributions around it."""

    shape: Shape
    frame: Frame
    wall: Predictive
    """From the wall field."""
    pose: Predictive | None
    """From the pose field, where frames are known."""
    wall_share: float
    """Weight of the wall field, 0 to 1."""
    torn: bool
    """Whether the two contradict each other; intervals then reach over both."""
    noise: dict[str, Any]
    """The estimated noise model, with an `explanation` in plain words."""
    notes: tuple[Note, ...]
    slips: FrameSlips | None = None
    """How far each frame was off, where frames are known; Manhattan axes of the fit, before `frame`."""


_BLIND = (
    "Intervals assume that different faces were registered independently: without frame ids a whole face "
    "that slipped leaves no trace in the points."
)


def believe(
    cells: Cells,
    frame_cells: Cells | None,
    shape: Shape,
    frame: Frame,
    plane_rms_m: Float[np.ndarray, " planes"],
    inferred_std_m: float,
    config: BeliefConfig,
    rng: np.random.Generator,
    sampler: SamplerConfig | None = None,
    displacements: Displacements | None = None,
    swing_m: Float[np.ndarray, " planes"] | None = None,
) -> Belief:
    """Distribution of rotation and plane offsets.

    Without frame ids the wall field alone, at the fitted geometry. With them the conservative fusion with
    the pose field: weights by 1/u^2, full correlation. The weights are those of the model as a whole and
    not of each dimension, so that the reported lengths are those of one geometry. Where the two contradict
    each other the values are the wall field's and the intervals reach over both: a displaced block and a
    pose fit in a wrong mode look alike from here.

    Args:
        cells: residuals of the fit at `shape`, per patch.
        frame_cells: the same per frame and patch, or None.
        shape: fitted.
        frame: fitted.
        plane_rms_m: spread of the points about each plane.
        inferred_std_m: standard uncertainty of planes without points.
        config: see `BeliefConfig`.
        rng: for the draws of the noise scales.
        sampler: draw the wall field's noise scales by Markov chains; None takes the analytic approximation.
        displacements: of the frames that were put back before the fit; None where none was.
        swing_m: by how much each plane's place is in doubt because its points call it to others.

    Raises:
        SamplingError: the chains have not converged; nothing is reported from them.
    """
    theta = np.concatenate([np.zeros(3), shape.parameters])
    contrasts = Contrasts(_parallel_gaps(shape), theta)
    everything = with_inferred(cells, shape, inferred_std_m)
    extra = edge_exchange_covariance(shape, plane_rms_m)
    if displacements is not None and frame_cells is not None:
        extra = extra + doubt_covariance(frame_cells, displacements, len(shape.planes))
    if swing_m is not None:
        extra = extra + np.diag(swing_m**2)
    around = (3, len(shape.oblique))
    extra = np.pad(extra, (around, around))
    if sampler is None:
        wall = wall_field_predictive(everything, contrasts, config.wall_field, rng)
    else:
        wall = _sampled(everything, contrasts, config, sampler, rng)
    wall = replace(wall, covariances=wall.covariances + extra)
    obstacle = None if frame_cells is None else pose_obstacle(frame_cells, config.pose_field)
    fit = None
    if frame_cells is not None and obstacle is None:
        try:
            fit = pose_field_predictive(frame_cells, contrasts, config.pose_field, rng)
        except np.linalg.LinAlgError as e:
            obstacle = f"{e}."
    if fit is None:
        noise = dict(wall.noise)
        noise["explanation"] = f"{noise.pop('sentence')} {_BLIND}"
        notes = () if obstacle is None else (_unused_note(obstacle),)
        return Belief(shape, frame, wall, None, 1.0, False, noise, notes)
    pose, slips = fit
    pose = _completed(replace(pose, covariances=pose.covariances + extra), wall)
    return replace(_fused(wall, pose, shape, frame, config.fusion), slips=slips)


def _unused_note(obstacle: str) -> Note:
    return Note(
        "FRAMES_UNUSED",
        f"The scan keeps frame ids, but they could not be used: {obstacle} The intervals are those of a "
        "cloud without ids. Scan every face from several places.",
    )


def _sampled(
    cells: Cells,
    contrasts: Contrasts,
    config: BeliefConfig,
    sampler: SamplerConfig,
    rng: np.random.Generator,
) -> Predictive:
    """The wall field by Markov chains, or no answer at all."""
    answer = sample_wall_field(cells, contrasts, config.wall_field, sampler, rng)
    if answer.predictive is None:
        raise SamplingError(
            f"sample: after {answer.diagnostics.steps} steps the chains have not converged, so nothing is "
            f"reported from them: {answer.diagnostics.status} Or leave --sample out: the analytic intervals "
            "need no chain."
        )
    noise = dict(answer.predictive.noise)
    chain = noise["sampler"]
    told = (
        f"These figures are sampled by Markov chains of {chain['steps']} steps (split R-hat "
        f"{chain['rhat']:.3f}, {chain['effective']:.0f} effective draws)."
    )
    noise["sentence"] = f"{noise['sentence']} {told}"
    return replace(answer.predictive, noise=noise)


def _parallel_gaps(shape: Shape) -> Float[np.ndarray, "gaps params"]:
    """One row for every pair of parallel planes of a room: all lengths that it has."""
    rooms = room_of_planes(shape)
    rows = []
    straight = [k for k, plane in enumerate(shape.planes) if not plane.oblique]
    for i, j in combinations(straight, 2):
        if shape.planes[i].axis == shape.planes[j].axis and rooms[i] == rooms[j]:
            row = np.zeros(3 + len(shape.parameters))
            row[3 + i], row[3 + j] = -1.0, 1.0
            rows.append(row)
    return np.array(rows)


def _completed(pose: Predictive, wall: Predictive) -> Predictive:
    """Fill planes that the pose field did not see from the wall field."""
    missing = np.flatnonzero(~pose.seen)
    means, covariances = pose.means.copy(), pose.covariances.copy()
    average = np.einsum("k,kpq->pq", wall.weights, wall.covariances)
    means[:, missing] = (wall.weights @ wall.means)[missing]
    # In place of what is there: the wall field's variance holds the bias through the edges already. Offset
    # and yaw of an oblique plane err together.
    covariances[:, missing[:, None], missing] = average[np.ix_(missing, missing)]
    return replace(pose, means=means, covariances=covariances, seen=np.ones_like(pose.seen))


def _fused(wall: Predictive, pose: Predictive, shape: Shape, frame: Frame, config: FusionConfig) -> Belief:
    precise = (float(np.sum(1.0 / member.std**2)) for member in (wall, pose))
    wall_precision, pose_precision = precise
    share = wall_precision / (wall_precision + pose_precision)
    gap_m = np.abs(wall.mean - pose.mean)
    torn = fuse(wall, pose, config).inconsistent
    notes: tuple[Note, ...] = ()
    if torn.any():
        share = 1.0
        notes = (_inconsistent_note(int(torn.sum()), len(torn), float(gap_m[torn].max())),)
    theta = share * (wall.weights @ wall.means) + (1.0 - share) * (pose.weights @ pose.means)
    turn = Rotation.from_rotvec(theta[:3]).as_matrix()
    noise = {
        "model": "fusion",
        "wall_share": share,
        "wall_field": dict(wall.noise),
        "pose_field": dict(pose.noise),
        "explanation": pose.noise["sentence"],
    }
    # Where the average would turn a part of a room inside out, the fit's places stay; `MeasurandPrediction`
    # adds how far they are from the average.
    ordered, _ = reverted(shape, shape.with_parameters(theta[3:]))
    return Belief(
        shape=ordered,
        frame=replace(frame, R_manhattan_scan=turn.T @ frame.R_manhattan_scan),
        wall=wall,
        pose=pose,
        wall_share=share,
        torn=bool(torn.any()),
        noise=noise,
        notes=notes,
    )


def _inconsistent_note(n_torn: int, n_gaps: int, gap_m: float) -> Note:
    return Note(
        "REGISTRATION_INCONSISTENT",
        f"A block of frames may be displaced: with the frames' slips taken out, {n_torn} of {n_gaps} "
        f"distances between parallel faces move by up to {1e3 * gap_m:.0f} mm, more than their uncertainty. "
        "The values are those of the cloud as it is, the intervals reach over both; measure one by hand.",
    )


def edge_exchange_covariance(
    shape: Shape, plane_rms_m: Float[np.ndarray, " planes"]
) -> Float[np.ndarray, "planes planes"]:
    """How far noise along the line of sight may shift planes through the edges of their faces, m^2.

    Such noise moves a point across the wall and along it at once. At the edge of a face the points that
    come in and those that go out are therefore on different sides of the plane, which shifts its mean
    inwards by s^2 tan(a) / width per edge, s the spread across the plane and a the angle of incidence at
    the edge. From a place at the distance h the tangents at two opposite edges add up to width / h, so that
    the four edges of a face together shift it by 2 s^2 / h, whatever its size. h is half of the room's
    extent on average over opposite faces.

    This is no noise that averages out, but a bias of both faces of a length alike. The values are not
    corrected for it, since nobody knows where the sensor stood or whether its noise was along the line of
    sight at all; the matrix holds second moments about zero of a bias between nothing and twice that of the
    room's middle, evenly distributed (JCGM 100, 4.3.7 and F.2.4.5): its mean m is the same for all faces, its
    standard deviation m / sqrt(3) each face's own.

    Args:
        shape: fitted.
        plane_rms_m: spread of the points about each plane, metres.
    """
    room_of = room_of_planes(shape)
    rooms = np.array([room_of.get(k, "") for k in range(len(shape.planes))])
    # An oblique plane has none opposite to it, and so no length between two such biases.
    axes = np.array([-k if plane.oblique else plane.axis for k, plane in enumerate(shape.planes)])
    mean_m = np.zeros(len(axes))
    for k, rms_m in enumerate(plane_rms_m):
        extent_m = float(np.ptp(shape.offsets_m[(axes == axes[k]) & (rooms == rooms[k])]))
        if extent_m > 0.0:
            mean_m[k] = 4.0 * rms_m**2 / extent_m
    inward_m = mean_m * np.array([plane.outward for plane in shape.planes])
    return np.outer(inward_m, inward_m) + np.diag(mean_m**2 / 3.0)
