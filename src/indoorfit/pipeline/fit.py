"""The only place that knows the order of the stages: from a scan to a measured model."""

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float
from threadpoolctl import threadpool_limits

from indoorfit.config import RunConfig
from indoorfit.discover import discover
from indoorfit.fitting import (
    Belief,
    Cells,
    Displacements,
    Evidence,
    MeasurandPrediction,
    PatchData,
    TypeB,
    associate,
    believe,
    build_cells,
    cells_by_frame,
    fit_greedy,
    fit_joint,
    frame_motions,
    honesty_notes,
    plane_covariance,
    type_b_of,
)
from indoorfit.measure import (
    Survey,
    Verdict,
    assemble,
    face_notes,
    find_doors,
    measurands,
)
from indoorfit.model import (
    FitResult,
    Frame,
    Note,
    Pictures,
    Scan,
    Shape,
)
from indoorfit.texture import paint

from .doubts import fit_doubts, put_back_notes
from .front import FrontEnd
from .overriding import overridden, plan_overrides
from .provenance import Stopwatch, provenance, timings_s
from .put_back import righted_front, with_moves
from .rays import rays_of
from .surveying import surveyed

log = logging.getLogger("indoorfit")


_NO_PICTURES = Pictures()


def fit_scan(scan: Scan, config: RunConfig | None = None, pictures: Pictures = _NO_PICTURES) -> FitResult:
    """Turn a scan into a watertight model with dimensions and intervals.

    read -> **thin -> orient -> segment -> classify -> discover -> fit -> uncertainty -> solid -> measure
    -> texture**

    Args:
        scan: metres, any pose.
        config: settings; the defaults fit rooms scanned by hand-held depth cameras and by lasers.
        pictures: camera images and photos for the faces; without them the points' colours are used.

    Raises:
        InputError: the cloud cannot be a room, or a picture cannot be used; the message says why and what
            to do.
    """
    # The matrices are small: with more than one BLAS thread waking them takes most of the time.
    with threadpool_limits(1, "blas"):
        scan, config = overridden(scan, config or RunConfig())
        watch = Stopwatch()
        result, scan = _run(scan, config, watch)
        return _textured(result, scan, pictures, config, watch)


def _textured(
    result: FitResult, scan: Scan, pictures: Pictures, config: RunConfig, watch: Stopwatch
) -> FitResult:
    if not config.texture.enabled:
        return result
    with watch.stage("texture"):
        textures = paint(result, scan, pictures, config.texture)
    if textures is not None:
        log.info("texture: %d of %d faces", len(textures.placements), len(result.faces))
    return replace(result, textures=textures, provenance={**result.provenance, "timings_s": timings_s(watch)})


def _run(scan: Scan, config: RunConfig, watch: Stopwatch) -> tuple[FitResult, Scan]:
    """The result, and the scan that it is of: frames that were displaced have been put back."""
    rng = np.random.default_rng(config.seed)
    front, righted = righted_front(scan, config, rng, watch)
    scan = righted.scan
    fitted = replace(_fit(scan, front, config, rng, watch), displacements=righted.found)
    notes = (*scan.notes, *front.notes, *righted.notes)
    return with_moves(_measure(scan, fitted, notes, config, rng, watch), righted.moves), scan


@dataclass(frozen=True)
class _Fitted:
    """What either way of fitting hands on."""

    shape: Shape
    frame: Frame
    data: PatchData
    cells: Cells
    frame_cells: Cells | None
    pixel_m: float
    notes: tuple[Note, ...]
    converged: bool
    swing_m: Float[np.ndarray, " planes"]
    """By how much each plane's place is in doubt because its points call it to others."""
    put_back: tuple[int, ...] = ()
    """Planes that passed others in the fit."""
    displacements: Displacements | None = None
    """Of the frames that were put back before the fit."""


def _fit(
    scan: Scan, front: FrontEnd, config: RunConfig, rng: np.random.Generator, watch: Stopwatch
) -> _Fitted:
    frame, local, segments, classes = front.frame, front.surfels, front.segments, front.classes
    # Four surfels a square on average: the finest raster in which a full surface has no holes.
    pixel_m = 2.0 * float(np.sqrt(local.area_m2))
    if config.method == "greedy":
        with watch.stage("fit"):
            point_surfel = front.point_surfel
            greedy = fit_greedy(scan, frame, local, segments, classes, point_surfel, config.greedy, rng)
            shape, frame, notes = greedy.shape, greedy.frame, greedy.notes
            data = associate(frame.to_manhattan(scan.points_m), shape, config.joint.association, pixel_m)
            cells, converged = build_cells(data.patches, shape), greedy.converged
            put_back: tuple[int, ...] = ()
        swing_m = np.zeros(len(shape.planes))
    else:
        with watch.stage("discover"):
            said = plan_overrides(config.overrides, frame)
            rays = rays_of(scan, frame)
            start, notes = discover(local, segments, classes, config.discover, said, rays)
        log.info("discover: %d room(s), %d planes", len(start.rooms), len(start.planes))
        with watch.stage("fit"):
            joint = fit_joint(scan, frame, start, config.joint, pixel_m)
        log.info("fit: %d round(s), %d patches", joint.rounds, len(joint.cells.plane))
        shape, frame, data = joint.shape, joint.frame, joint.data
        cells, converged = joint.cells, joint.converged
        swing_m, put_back = joint.swing_m, joint.put_back
    frame_cells = None
    if config.belief.use_frames and scan.frame_ids is not None and config.method == "joint":
        with watch.stage("frames"):
            frame_cells = cells_by_frame(
                scan, frame, shape, config.joint.association, pixel_m, config.belief.pose_field
            )
    return _Fitted(shape, frame, data, cells, frame_cells, pixel_m, notes, converged, swing_m, put_back)


def _measure(
    scan: Scan,
    fitted: _Fitted,
    notes: tuple[Note, ...],
    config: RunConfig,
    rng: np.random.Generator,
    watch: Stopwatch,
) -> FitResult:
    with watch.stage("intervals"):
        belief = believe(
            fitted.cells,
            fitted.frame_cells,
            fitted.shape,
            fitted.frame,
            fitted.data.plane_rms_m,
            fitted.pixel_m,
            config.belief,
            rng,
            config.sampler if config.sample else None,
            fitted.displacements,
            fitted.swing_m,
        )
    type_b = type_b_of(config.type_b)
    shape = _unseen_told(belief.shape, fitted.data)
    with watch.stage("solid"):
        data = fitted.data
        found, of_faces = surveyed(shape, data.pieces, data.plane_rms_m)
        in_manhattan_m = belief.frame.to_manhattan(scan.points_m)
        doors = find_doors(shape, belief.frame, found, in_manhattan_m, fitted.pixel_m)
    with watch.stage("intervals"):
        wanted = measurands(found, shape)
        values = np.array([measurand.value for measurand in wanted])
        gradients = np.stack([measurand.gradient for measurand in wanted])
        prediction = MeasurandPrediction(belief, values, gradients, type_b, config.belief.inflation)
        covariance_m2 = plane_covariance(belief, config.belief.inflation)
        own_m = np.sqrt(np.diag(covariance_m2)) / config.belief.inflation
    with watch.stage("honesty"):
        doubts = _honest(scan, fitted, belief, found, config)
    closed = all(room.solid.is_closed for room in found.rooms)
    result = assemble(
        shape,
        belief.frame,
        found,
        of_faces,
        prediction,
        Verdict(
            method=config.method,
            level=config.level,
            noise=_noise(belief, type_b),
            notes=(
                *notes,
                *fitted.notes,
                *belief.notes,
                *face_notes(shape, found, fitted.put_back),
                *doubts,
                *fit_doubts(closed, fitted.converged, fitted.swing_m, own_m, found),
                *put_back_notes(fitted.put_back, found),
            ),
            provenance=provenance(scan, config, watch),
            converged=closed and fitted.converged,
        ),
    )
    result = replace(result, adjacency=doors, plane_covariance_m2=covariance_m2)
    if belief.slips is None or scan.frame_ids is None:
        return result
    motions = frame_motions(belief.slips, np.unique(scan.frame_ids), fitted.frame)
    return replace(result, registration=motions)


def _honest(
    scan: Scan, fitted: _Fitted, belief: Belief, found: Survey, config: RunConfig
) -> tuple[Note, ...]:
    """Whether the assumptions of the intervals hold, at the fit that the residuals belong to."""
    faces: dict[int, tuple[str, ...]] = {}
    for face in found.faces:
        faces[face.polygon.plane] = (*faces.get(face.polygon.plane, ()), face.id)
    shape = _unseen_told(fitted.shape, fitted.data)
    evidence = Evidence(shape, fitted.cells, belief.wall, fitted.data, faces)
    return honesty_notes(
        scan, fitted.frame, evidence, config.joint.association, config.belief.wall_field, config.honesty
    )


def _noise(belief: Belief, type_b: TypeB) -> dict[str, Any]:
    """The estimated noise model and what was added to it, with one explanation."""
    noise = {**belief.noise, "type_b": type_b.as_noise()}
    return {**noise, "explanation": f"{noise['explanation']} {type_b.sentence}"}


def _unseen_told(shape: Shape, data: PatchData) -> Shape:
    """Planes that the fit found no points for are inferred, whatever discovery thought of them."""
    fitted = set(data.patches.plane.tolist())
    planes = [
        plane if k in fitted else replace(plane, status="inferred") for k, plane in enumerate(shape.planes)
    ]
    return replace(shape, planes=tuple(planes))
