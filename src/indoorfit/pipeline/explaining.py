"""The decision on the plan, explained: the stages up to discovery, and what became of every candidate."""

from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from indoorfit.config import RunConfig
from indoorfit.discover import Explanation, explain
from indoorfit.model import Frame, Scan

from .overriding import overridden, plan_overrides
from .provenance import Stopwatch
from .put_back import righted_front
from .rays import rays_of


@dataclass(frozen=True)
class Explained:
    """An explanation and where it stands."""

    scan: Scan
    """Without the points that an override ignores, displaced frames put back."""
    frame: Frame
    explanation: Explanation


def explain_scan(scan: Scan, config: RunConfig | None = None) -> Explained:
    """Say of every candidate wall whether it was accepted, and why.

    Args:
        scan: metres, any pose.
        config: settings; those of the fit itself are not used.

    Raises:
        InputError: the cloud cannot be a room.
        ConfigError: an override that cannot be meant.
    """
    scan, config = overridden(scan, config or RunConfig())
    with threadpool_limits(1, "blas"):
        front, righted = righted_front(scan, config, np.random.default_rng(config.seed), Stopwatch())
        scan = righted.scan
        said = plan_overrides(config.overrides, front.frame)
        rays = rays_of(scan, front.frame)
        found = explain(front.surfels, front.segments, front.classes, config.discover, said, rays)
    notes = (*scan.notes, *front.notes, *righted.notes, *found.notes)
    return Explained(scan, front.frame, replace(found, notes=notes))
