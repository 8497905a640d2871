"""The survey, the fit and its uncertainty put together as the result that people read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from indoorfit.model import (
    Dimension,
    Face,
    FitResult,
    Frame,
    LoaClass,
    Method,
    Note,
    PlaneStatus,
    Prediction,
    Quantity,
    Room,
    RoomMesh,
    Shape,
)

from .evidence import FaceEvidence
from .levels import loa_classes, quantities
from .named import Measurand, NamedDimension, NamedFace, NamedRoom, Survey


@dataclass(frozen=True)
class Verdict:
    """What the run as a whole has to say."""

    method: Method
    level: float
    noise: Mapping[str, Any]
    notes: tuple[Note, ...]
    provenance: Mapping[str, Any]
    converged: bool


def measurands(found: Survey, shape: Shape) -> tuple[Measurand, ...]:
    """Everything that needs an interval: dimensions, room quantities, then every plane offset itself."""
    dimensions = [dimension.measurand for dimension in found.dimensions]
    rooms = [m for room in found.rooms for m in (room.floor_area, room.volume, room.perimeter)]
    offsets = [Measurand(0.0, row) for row in np.eye(len(shape.planes), len(shape.parameters))]
    return tuple(dimensions + rooms + offsets)


def assemble(
    shape: Shape,
    frame: Frame,
    found: Survey,
    evidence: FaceEvidence,
    prediction: Prediction,
    verdict: Verdict,
) -> FitResult:
    """Build the result.

    Args:
        shape: fitted grammar.
        frame: fitted pose.
        found: what there is to measure.
        evidence: per face.
        prediction: per measurand, in the order of `measurands`.
        verdict: method, noise, warnings, provenance.
    """
    values = np.array([measurand.value for measurand in measurands(found, shape)])
    known = quantities(values, prediction, verdict.level)
    n = len(found.dimensions)
    n_rooms = 3 * len(found.rooms)
    offsets = known[n + n_rooms :]
    classes = loa_classes(values[:n], prediction)
    unseen = {face.id for face in found.faces if face.status == "inferred"}
    return FitResult(
        method=verdict.method,
        level=verdict.level,
        frame=frame,
        shape=shape,
        rooms=tuple(_room(room, known[n + 3 * k : n + 3 * k + 3]) for k, room in enumerate(found.rooms)),
        faces=tuple(_face(k, face, shape, frame, evidence, offsets) for k, face in enumerate(found.faces)),
        dimensions=tuple(
            _dimension(dimension, _letters(k), known[k], classes[k], shape, frame, unseen)
            for k, dimension in enumerate(found.dimensions)
        ),
        meshes=tuple(_mesh(room, found, frame) for room in found.rooms),
        noise=verdict.noise,
        notes=verdict.notes,
        provenance=verdict.provenance,
        converged=verdict.converged,
        prediction=prediction,
    )


def _letters(k: int) -> str:
    """0, 1, ... as A, B, ..., Z, AA, AB, ..."""
    name = ""
    k += 1
    while k > 0:
        k, letter = divmod(k - 1, 26)
        name = chr(ord("A") + letter) + name
    return name


def _room(room: NamedRoom, known: Sequence[Quantity]) -> Room:
    floor_area, volume, perimeter = known
    return Room(room.id, room.cube, floor_area, volume, perimeter)


def _face(
    k: int,
    face: NamedFace,
    shape: Shape,
    frame: Frame,
    evidence: FaceEvidence,
    offsets: Sequence[Quantity],
) -> Face:
    plane = shape.planes[face.polygon.plane]
    inward = 0.0 - plane.outward * plane.normal
    return Face(
        id=face.id,
        kind=face.kind,
        face_class=plane.face_class,
        room=face.room,
        cube=face.cube,
        side=face.side,
        plane=face.polygon.plane,
        normal=frame.directions_to_scan(inward),
        rings_m=tuple(frame.to_scan(ring) for ring in face.polygon.rings_m),
        offset_std_m=offsets[face.polygon.plane].std,
        n_points=int(evidence.n_points[k]),
        coverage=float(evidence.coverage[k]),
        rms_m=float(evidence.rms_m[k]),
        status=face.status,
    )


def _dimension(
    dimension: NamedDimension,
    letters: str,
    quantity: Quantity,
    loa: LoaClass,
    shape: Shape,
    frame: Frame,
    unseen: set[str],
) -> Dimension:
    # An oblique wall's ends lie on itself, too.
    moved_by = np.flatnonzero(dimension.measurand.gradient[: len(shape.planes)])
    inferred = any(shape.planes[k].status == "inferred" for k in moved_by)
    # An extent ends at a plane, wherever that was seen; all else at these faces.
    inferred |= dimension.kind != "overall" and not unseen.isdisjoint(dimension.faces)
    status: PlaneStatus = "inferred" if inferred else "observed"
    return Dimension(
        id=letters,
        kind=dimension.kind,
        room=dimension.room,
        faces=dimension.faces,
        wall=dimension.wall,
        from_m=frame.to_scan(dimension.from_m),
        to_m=frame.to_scan(dimension.to_m),
        quantity=quantity,
        status=status,
        loa=loa,
    )


def _mesh(room: NamedRoom, found: Survey, frame: Frame) -> RoomMesh:
    """The solid turned inside out, in the scan frame, with the face of every triangle."""
    face_ids = [""] * len(room.solid.triangles)
    for face in found.faces:
        if face.room == room.id:
            for triangle in face.polygon.triangles:
                face_ids[int(triangle)] = face.id
    assert all(face_ids), "every triangle belongs to a face"
    return RoomMesh(
        room.id, frame.to_scan(room.solid.vertices_m), room.solid.triangles[:, ::-1].copy(), tuple(face_ids)
    )
