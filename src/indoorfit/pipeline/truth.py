"""The exact model of a simulated scan, in the same contract as a fitted one."""

from dataclasses import replace
from typing import Any

import numpy as np

from indoorfit.measure import (
    ExactPrediction,
    PlaneEvidence,
    Survey,
    Verdict,
    assemble,
    measurands,
    survey,
    with_thicknesses,
)
from indoorfit.model import FitResult, Frame, Note, Shape
from indoorfit.simulate import VirtualScan, seen_of_planes
from indoorfit.solid import face_polygons, subtract_cubes

from .provenance import package_version
from .true_doors import true_doors

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
    found = survey(shape, solids, [face_polygons(solid) for solid in solids])
    found = with_thicknesses(shape, found)
    values = np.array([measurand.value for measurand in measurands(found, shape)])
    result = assemble(
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
    if seen is None or seen.scene is None:
        return result
    return replace(result, adjacency=true_doors(seen.scene, shape, frame, found))


def _unseen(shape: Shape, found: Survey) -> tuple[Note, ...]:
    names = [face.id for face in found.faces if shape.planes[face.polygon.plane].status == "inferred"]
    if not names:
        return ()
    message = f"No point of the scan lies on {', '.join(names)}; the model is exact there all the same."
    return (Note("FACE_INFERRED", message),)


def _beyond_the_model(found: Survey, seen: VirtualScan | None) -> tuple[Note, ...]:
    """What holds for the scan and cannot be said by cubes."""
    notes = []
    if seen is not None and seen.scale_error != 0.0:
        notes.append(
            Note(
                "SCALE_ERROR",
                f"The scan is larger than this model by a factor of {1.0 + seen.scale_error:g}: the model "
                "holds the true lengths, in the coordinates of the scan without that error.",
            )
        )
    return tuple(notes)
