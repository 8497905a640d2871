"""The thesis' procedure with everything that its figures show."""

import numpy as np
from threadpoolctl import threadpool_limits

from indoorfit.config import RunConfig
from indoorfit.fitting import fit_greedy
from indoorfit.model import Scan
from indoorfit.report import GreedyTrace
from indoorfit.solid import face_polygons, subtract_cubes

from .front import front_end
from .overriding import overridden
from .provenance import Stopwatch


def trace_greedy(scan: Scan, config: RunConfig | None = None) -> GreedyTrace:
    """Run the greedy method and keep what each of its steps saw and made.

    Args:
        scan: metres, any pose.
        config: settings; `method` is not used.

    Raises:
        InputError: the procedure finds no room.
    """
    scan, config = overridden(scan, config or RunConfig())
    rng = np.random.default_rng(config.seed)
    with threadpool_limits(1, "blas"):
        front = front_end(scan, config, rng, Stopwatch())
        local, segments, classes = front.surfels, front.segments, front.classes
        greedy = fit_greedy(
            scan, front.frame, local, segments, classes, front.point_surfel, config.greedy, rng
        )
        solid = subtract_cubes(greedy.shape, greedy.shape.rooms[0])
    # Both frames have the same origin.
    R_new_old = greedy.frame.R_manhattan_scan @ front.frame.R_manhattan_scan.T
    return GreedyTrace(
        points_m=greedy.frame.to_manhattan(scan.points_m),
        surfels_m=local.positions_m @ R_new_old.T,
        labels=segments.labels,
        normals=segments.normals @ R_new_old.T,
        areas_m2=segments.areas_m2,
        classes=classes,
        steps=greedy.steps,
        shape=greedy.shape,
        polygons=tuple(face_polygons(solid)),
    )
