"""The exact model of a simulated scan, in the same contract as a fitted one."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from indoorfit.measure import ExactPrediction, PlaneEvidence, Survey, Verdict, assemble, measurands, survey
from indoorfit.measure.survey import NamedFace
from indoorfit.model import Cube, FitResult, Frame, Note, Polygon, Shape, Side
from indoorfit.simulate import VirtualScan, cut_planes, seen_of_planes
from indoorfit.solid import face_polygons, subtract_cubes

from .provenance import package_version

_LEVEL = 0.95
"""Intervals without width hold the truth at every level; the contract asks for one below 1."""


def truth_result(
    shape: Shape, frame: Frame, settings: dict[str, Any], seed: int, seen: VirtualScan | None = None
) -> FitResult:
    """Faces and dimensions of a shape that is known exactly; every interval has no width.

    Args:
        shape: the generating grammar.
        frame: its exact pose in the scan.
        settings: how the scan was simulated, for the provenance.
        seed: of the simulation.
        seen: the scan that was taken of the shape. Planes that no point was taken on become `inferred`, and
            counts, coverage and RMS are those of its points. Without it every plane counts as fully seen.
    """
    n = len(shape.planes)
    evidence = PlaneEvidence(np.zeros(n, int), np.ones(n), np.zeros(n))
    if seen is not None:
        evidence = PlaneEvidence(*seen_of_planes(seen))
        planes = tuple(
            replace(plane, status="observed" if count else "inferred")
            for plane, count in zip(shape.planes, evidence.n_points, strict=True)
        )
        shape = replace(shape, planes=planes)
    solids = [subtract_cubes(shape, room) for room in shape.rooms]
    polygons = [face_polygons(solid) for solid in solids]
    found = _every_face_once(survey(shape, solids, polygons), shape, polygons)
    values = np.array([measurand.value for measurand in measurands(found, n)])
    return assemble(
        shape,
        frame,
        found,
        evidence,
        ExactPrediction(values),
        Verdict(
            method="truth",
            level=_LEVEL,
            noise={"explanation": "This is the exact geometry that the scan was simulated from."},
            notes=(*_unseen(shape, found), *_beyond_the_model(found, seen)),
            provenance={"version": package_version(), "simulation": settings, "seed": seed},
            converged=True,
        ),
    )


def _every_face_once(found: Survey, shape: Shape, polygons: Sequence[Sequence[Polygon]]) -> Survey:
    """Name the faces that stand on no floor (beams, edges of lowered ceilings), and none of them twice.

    A survey goes around each floor. With steps there are several floors in a room, which share walls.
    """
    first: dict[int, NamedFace] = {}
    same: dict[str, str] = {}
    for face in found.faces:
        same[face.id] = first.setdefault(id(face.polygon), face).id
    faces = list(first.values())
    owners: dict[int, tuple[Cube, Side]] = {}
    for cube in shape.cubes:
        owners.update({plane: (cube, side) for side, plane in cube.sides.items() if plane is not None})
    n_walls = sum(face.kind == "wall" for face in found.faces)
    for room, pieces in zip(found.rooms, polygons, strict=True):
        for piece in pieces:
            if id(piece) not in first:
                n_walls += 1
                cube, side = owners[piece.plane]
                faces.append(NamedFace(f"wall-{n_walls}", "wall", room.id, cube.id, side, piece))
    dimensions = tuple(
        replace(
            dimension,
            faces=(same[dimension.faces[0]], same[dimension.faces[1]]),
            wall=None if dimension.wall is None else same[dimension.wall],
        )
        for dimension in found.dimensions
    )
    return replace(found, faces=tuple(faces), dimensions=dimensions)


def _unseen(shape: Shape, found: Survey) -> tuple[Note, ...]:
    names = [face.id for face in found.faces if shape.planes[face.polygon.plane].status == "inferred"]
    if not names:
        return ()
    message = f"No point of the scan lies on {', '.join(names)}; the model is exact there all the same."
    return (Note("FACE_INFERRED", message),)


def _beyond_the_model(found: Survey, seen: VirtualScan | None) -> tuple[Note, ...]:
    """What holds for the scan and cannot be said by cubes."""
    notes = []
    if seen is not None and seen.scene is not None and not seen.manhattan:
        cut = cut_planes(seen.scene, seen.shape)
        wrong = [face.id for face in found.faces if face.polygon.plane in cut]
        exact = [face.id for face in found.faces if face.polygon.plane not in cut]
        notes.append(
            Note(
                "OBLIQUE_WALLS",
                f"The scene has {len(seen.scene.oblique_walls)} oblique wall(s); this model is the room "
                f"without them. Exact: {', '.join(exact) or 'no face'}. Exact only as planes, for an oblique "
                f"wall cuts a part off: {', '.join(wrong) or 'no face'}; areas, volumes and clear lengths of "
                "walls that rest on these are not those of the scene.",
            )
        )
    if seen is not None and seen.scale_error != 0.0:
        notes.append(
            Note(
                "SCALE_ERROR",
                f"The scan is larger than this model by a factor of {1.0 + seen.scale_error:g}: the model "
                "holds the true lengths, in the coordinates of the scan without that error.",
            )
        )
    return tuple(notes)
