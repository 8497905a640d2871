"""``indoorfit simulate``: a room whose truth is known, as a scan."""

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from .runtime import set_up_logging


@dataclass(frozen=True)
class SimulateCommand:
    """Write a simulated scan (PLY) of a room and its exact model beside it (SCAN.truth.json)."""

    kind: tyro.conf.Positional[Literal["box", "L", "U", "X", "T", "Z", "stair"]]
    """Plan of the room."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The PLY file to write."""
    length: float | None = None
    """Extent along x, metres; default: the kind's own."""
    width: float | None = None
    """Extent along y, metres."""
    height: float = 2.70
    """Floor to ceiling, metres."""
    notch_length: float | None = None
    """Extent of the (largest) notch along x, metres."""
    notch_width: float | None = None
    """Extent of the (largest) notch along y, metres."""
    points: int = 150_000
    """Number of points."""
    noise: float = 0.005
    """Standard deviation of the noise, metres; 0.5 cm as in the thesis (5.1.1)."""
    noise_model: Literal["normal", "isotropic", "kinect"] = "normal"
    """normal: along the surface normal; isotropic; kinect: line of sight, 4 cm at 5 m, growing with d²."""
    outliers: float = 0.0
    """Share of points spread over the bounding box, 0 to 1."""
    furniture: int = 0
    """Number of furniture boxes."""
    windows: int = 0
    """Number of window holes."""
    tilt: float = 0.0
    """Tilt of the room's vertical, degrees."""
    yaw: float = 0.0
    """Turn about the vertical, degrees."""
    seed: int = 0
    """Same seed, same bytes."""
    overwrite: bool = False
    """Replace existing files."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=False, verbose=False)
        import numpy as np

        from indoorfit.io import write_model_json, write_ply
        from indoorfit.pipeline import truth_result
        from indoorfit.simulate import SamplingSettings, room_shape, sample_surface

        truth_path = self.output.with_suffix(".truth.json")
        _refuse_existing(self.output, truth_path, self.overwrite)
        shape = room_shape(
            self.kind,
            length_m=self.length,
            width_m=self.width,
            height_m=self.height,
            notch_length_m=self.notch_length,
            notch_width_m=self.notch_width,
        )
        settings = SamplingSettings(
            n_points=self.points,
            sigma_m=self.noise,
            noise=self.noise_model,
            outlier_share=self.outliers,
            n_furniture=self.furniture,
            n_windows=self.windows,
            tilt_rad=math.radians(self.tilt),
            yaw_rad=math.radians(self.yaw),
        )
        virtual = sample_surface(shape, settings, np.random.default_rng(self.seed), name=self.output.name)
        recorded = {"kind": self.kind, **dataclasses.asdict(settings)}
        write_model_json(truth_path, truth_result(virtual.shape, virtual.frame, recorded, self.seed))
        write_ply(self.output, virtual.scan)
        return 0


def _refuse_existing(output: Path, truth: Path, overwrite: bool) -> None:
    from indoorfit.errors import OutputError

    if output.suffix.lower() != ".ply":
        raise OutputError(
            f"{output}: the suffix is {output.suffix!r}; scans are written as PLY. Fix: name it .ply."
        )
    for path in (output, truth):
        if path.exists() and not overwrite:
            raise OutputError(f"{path}: exists already. Fix: choose another name, or give --overwrite.")
