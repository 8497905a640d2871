"""The exact model of a simulated scan, in the same contract as a fitted one."""

from dataclasses import replace
from typing import Any

import numpy as np

from indoorfit.geometry import SeenPiece, exposures, pieces
from indoorfit.measure import ExactPrediction, Survey, Verdict, assemble, measurands
from indoorfit.model import FitResult, Frame, Note, Shape
from indoorfit.simulate import VirtualScan, seen_of_planes

from .provenance import package_version
from .surveying import surveyed
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
    if seen is None:
        whole = [part for exposure in exposures(shape) for part in pieces(exposure)]
        evidence, rms_m = tuple(SeenPiece(part, 0, 1.0) for part in whole), np.zeros(len(shape.planes))
    else:
        evidence, rms_m = seen_of_planes(seen)
        with_points = {piece.part.plane for piece in evidence if piece.n_points}
        planes = tuple(
            replace(plane, status="observed" if k in with_points else "inferred")
            for k, plane in enumerate(shape.planes)
        )
        shape = replace(shape, planes=planes)
    found, of_faces = surveyed(shape, evidence, rms_m)
    values = np.array([measurand.value for measurand in measurands(found, shape)])
    result = assemble(
        shape,
        frame,
        found,
        of_faces,
        ExactPrediction(values),
        Verdict(
            method="truth",
            level=_LEVEL,
            noise={"explanation": "This is the exact geometry that the scan was simulated from."},
            notes=(*_unseen(found), *_beyond_the_model(found, seen)),
            provenance={"version": package_version(), "simulation": settings, "seed": seed},
            converged=True,
        ),
    )
    if seen is None or seen.scene is None:
        return result
    return replace(result, adjacency=true_doors(seen.scene, shape, frame, found))


def _unseen(found: Survey) -> tuple[Note, ...]:
    names = [face.id for face in found.faces if face.status == "inferred"]
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
