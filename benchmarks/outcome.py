"""What is kept of one room: plain values, so that it travels between processes and into JSON."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from indoorfit.evaluate import Comparison, LengthCheck


@dataclass(frozen=True)
class Job:
    """One room of one suite; everything about it follows from these."""

    suite: str
    seed: int
    method: str
    frame_ids: bool
    levels: tuple[float, ...]
    """Nominal coverages; the first is the one that is scored; all come from one fit."""

    @property
    def run(self) -> str:
        """The way of fitting, as rows and baselines name it."""
        return f"{self.method}+frames" if self.frame_ids else self.method


@dataclass(frozen=True)
class PlanPicture:
    """The room from above, in the truth's Manhattan frame."""

    dots_m: Float[np.ndarray, "dots 2"]
    """Some points between floor and ceiling."""
    true_lines_m: tuple[tuple[float, float, float, float, bool], ...]
    """x, y, x, y of every true wall, and whether it was found."""
    model_lines_m: tuple[tuple[float, float, float, float, str], ...]
    """The model's walls, each `observed`, `inferred` or `wrong`."""


@dataclass(frozen=True)
class Outcome:
    """What became of one room."""

    job: Job
    right: bool
    faults: tuple[str, ...]
    """Why not, in words; also where the room was refused or the program failed."""
    comparison: Comparison | None
    """None where there is no model."""
    isprs: tuple[float, float, float]
    """Completeness, correctness and accuracy (m) at 10 cm; NaN without a model."""
    other_levels: dict[float, tuple[LengthCheck, ...]]
    """The lengths again at the further levels."""
    notes: tuple[str, ...]
    """Codes of the warnings."""
    crashed: bool
    """Whether the program failed in a way that is no error of the user's."""
    cpu_s: float
    wall_s: float
    peak_mb: float
    """Most memory that the process held during the fit, scan and libraries included."""
    picture: PlanPicture | None = field(repr=False, default=None)
