"""What one task of a batch is: plain values that travel to any process or machine."""

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal

from indoorfit.config import RunConfig, config_to_dict
from indoorfit.model import TapeTable
from indoorfit.pipeline import package_version

Plan = Literal["box", "L", "U", "X", "T", "Z", "stair", "random"]


_ROW = 2
"""Counts up when rows get other columns, so that a batch begun before is not gone on with."""


@dataclass(frozen=True)
class ScanFile:
    """A scan on disk. On a cluster its path must mean the same file on every worker."""

    path: str
    sha256: str
    """Digest of its bytes when the batch was planned; a file that has changed since is refused."""
    frames_sha256: str | None
    """Of the sidecar with sensor poses, where there is one."""
    unit: str
    truth: str | None = None
    """A model.json to compare with, such as the truth of a simulated scan."""
    truth_sha256: str | None = None


@dataclass(frozen=True)
class Simulation:
    """A room that is made where it is fitted, with exact truth: hundreds of them take no disk."""

    seed: int
    plan: Plan = "random"
    """A preset's plan, each extent up to 20 % off, or a random one."""
    walls: int = 6
    """Of a random plan."""
    sensor: str | None = None
    """A virtual scanner (kinect_v1, ...); none draws points evenly from the surfaces."""
    registration: str = "5mm"
    """Drift of a virtual scanner: 0, 5mm, 2cm, 5cm."""
    frames: int = 60
    """Frames of a virtual scanner, or stations of one on a tripod."""
    pixel_step: int = 8
    """Every so many pixels of a virtual scanner."""
    points: int = 60_000
    """Without a sensor."""
    sigma_m: float = 0.005
    """Noise without a sensor."""
    furniture: int = 0
    windows: int = 0


@dataclass(frozen=True)
class Job:
    """One scan with one configuration."""

    name: str
    """Of the scan; with `config_name` it is unique in the batch."""
    room: str
    """The physical room: scans of one room are no independent witnesses."""
    sensor: str
    config_name: str
    config: RunConfig
    source: ScanFile | Simulation
    tape: TapeTable | None = None
    """The readings of this scan; rows that the table's reader refused are told once for the whole batch."""
    model_dir: str | None = None
    """Where the whole model is written, where it is to be kept."""

    @cached_property
    def key(self) -> str:
        """Digest of all that the result depends on: a change of any part makes it a new task."""
        parts = {
            "version": package_version(),
            "row": _ROW,
            "config": config_to_dict(self.config),
            "source": self._content(),
            "tape": None if self.tape is None else asdict(self.tape),
            "model": self.model_dir,
        }
        text = json.dumps(parts, sort_keys=True, ensure_ascii=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]

    def _content(self) -> dict[str, Any]:
        """The source without where it lies."""
        content = asdict(self.source)
        return {k: v for k, v in content.items() if k not in ("path", "truth")}


Row = dict[str, Any]
"""The result of one job, ready for JSON, without any time in it: the same job gives the same row."""

Timing = dict[str, Any]
"""How long the job took, kept apart from the row."""


def failed_row(job: Job, reason: str, *, lost: bool = False) -> Row:
    """The row of a job without a result.

    Args:
        job: which.
        reason: one sentence.
        lost: the task was ended from outside (killed, out of memory or time), so that another run may do
            better; without it the failure is the scan's own and is kept.
    """
    return {"key": job.key, "state": "lost" if lost else "failed", "reason": reason, "lengths": []}
