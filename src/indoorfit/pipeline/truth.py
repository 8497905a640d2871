"""The exact model of a simulated scan, in the same contract as a fitted one."""

from typing import Any

import numpy as np

from indoorfit.measure import PlaneEvidence, Spread, Verdict, assemble, measurands, survey
from indoorfit.model import FitResult, Frame, Shape
from indoorfit.solid import face_polygons, subtract_cubes

from .provenance import package_version


def truth_result(shape: Shape, frame: Frame, settings: dict[str, Any], seed: int) -> FitResult:
    """Faces and dimensions of a shape that is known exactly; every interval has no width.

    Args:
        shape: the generating grammar.
        frame: its exact pose in the scan.
        settings: how the scan was simulated, for the provenance.
        seed: of the simulation.
    """
    solids = [subtract_cubes(shape, room) for room in shape.rooms]
    found = survey(shape, solids, [face_polygons(solid) for solid in solids])
    wanted = measurands(found, len(shape.planes))
    values = np.array([measurand.value for measurand in wanted])
    n = len(shape.planes)
    return assemble(
        shape,
        frame,
        found,
        PlaneEvidence(np.zeros(n, int), np.ones(n), np.zeros(n)),
        Spread(np.zeros(len(values)), values, values),
        Verdict(
            method="truth",
            level=1.0,
            noise={"explanation": "This is the exact geometry that the scan was simulated from."},
            notes=(),
            provenance={"version": package_version(), "simulation": settings, "seed": seed},
            converged=True,
        ),
    )
