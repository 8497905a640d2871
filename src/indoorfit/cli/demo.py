"""``indoorfit demo``: the whole way on a simulated scan of the thesis' room."""

from dataclasses import dataclass
from pathlib import Path

from .fit import run_pipeline
from .maybe import Quiet
from .runtime import set_up_logging


@dataclass(frozen=True)
class DemoCommand:
    """Simulate a scan of the thesis' L-shaped room (5.08 x 3.20 x 2.70 m) and fit it."""

    out: Path = Path("indoorfit-demo")
    """Directory to write; an earlier demo there is replaced, and nothing else."""
    seed: int = 0
    """Seed of the simulated scan."""
    quiet: Quiet = False
    """Only warnings and errors on standard error."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(self.quiet, verbose=False)
        import math

        import numpy as np

        from indoorfit.config import RunConfig
        from indoorfit.files import check_output_directory
        from indoorfit.simulate import SamplingSettings, room_shape, sample_surface

        overwrite = _holds_demo(self.out)
        check_output_directory(self.out, overwrite=overwrite)
        # Tilted and turned as a hand-held scan is, with a cupboard and a window.
        settings = SamplingSettings(
            yaw_rad=math.radians(23.0), tilt_rad=math.radians(4.0), n_furniture=1, n_windows=1
        )
        virtual = sample_surface(room_shape("L"), settings, np.random.default_rng(self.seed), name="demo")
        return run_pipeline(virtual.scan, RunConfig(), self.out, overwrite=overwrite, as_json=False)


def _holds_demo(directory: Path) -> bool:
    """Whether the directory is an earlier demo's and not a result that somebody wants to keep."""
    from indoorfit.errors import InputError
    from indoorfit.io import read_model_json

    try:
        earlier = read_model_json(directory / "model.json")
    except InputError:
        return False
    source = earlier.provenance.get("input")
    return isinstance(source, dict) and source.get("name") == "demo"
