"""A preset plan with points drawn evenly from its surfaces."""

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from .simulate_options import Contents, Plan, Sampling

if TYPE_CHECKING:
    import numpy as np

    from indoorfit.simulate import VirtualScan

DEFAULT_HEIGHT_M = 2.70


def sample_room(
    kind: str,
    plan: Plan,
    sampling: Sampling,
    contents: Contents,
    angles_deg: tuple[float, float],
    rng: "np.random.Generator",
    name: str,
) -> "tuple[VirtualScan, dict[str, Any]]":
    """The scan, and what it was made with.

    Args:
        kind: of the plan.
        plan: sizes.
        sampling: count and noise.
        contents: only furniture and windows are used.
        angles_deg: tilt and yaw of the scan.
        rng: decides all noise.
        name: of the scan.

    Raises:
        ConfigError: a value is out of range.
    """
    from indoorfit.simulate import SamplingSettings, room_shape, sample_surface

    shape = room_shape(kind, **plan_sizes_m(plan))  # type: ignore[arg-type]
    given = {
        "n_points": sampling.points,
        "sigma_m": sampling.noise,
        "noise": sampling.noise_model,
        "outlier_share": sampling.outliers,
        "n_furniture": contents.furniture,
        "n_windows": contents.windows,
    }
    tilt_deg, yaw_deg = angles_deg
    settings = SamplingSettings(
        tilt_rad=math.radians(tilt_deg),
        yaw_rad=math.radians(yaw_deg),
        **{name: value for name, value in given.items() if value is not None},  # type: ignore[arg-type]
    )
    virtual = sample_surface(shape, settings, rng, name=name)
    return virtual, {"kind": kind, **dataclasses.asdict(settings)}


def plan_sizes_m(plan: Plan) -> dict[str, float | None]:
    """The arguments of `room_shape`."""
    return {
        "length_m": plan.length,
        "width_m": plan.width,
        "height_m": DEFAULT_HEIGHT_M if plan.height is None else plan.height,
        "notch_length_m": plan.notch_length,
        "notch_width_m": plan.notch_width,
    }
