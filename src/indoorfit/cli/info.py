"""``indoorfit info``: what is in a scan file."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from .maybe import Flag
from .runtime import set_up_logging


@dataclass(frozen=True)
class InfoCommand:
    """Say what a scan file holds: points, extent, colours, frames, and what looks wrong."""

    scan: tyro.conf.Positional[Path]
    """The point cloud."""
    unit: Literal["m", "cm", "mm", "ft", "in"] = "m"
    """Unit of the file's coordinates."""
    json: Flag = False
    """Print JSON."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=True, verbose=False)
        import numpy as np

        from indoorfit.io import read_scan

        scan = read_scan(self.scan, unit=self.unit)
        low_m, high_m = scan.points_m.min(axis=0), scan.points_m.max(axis=0)
        facts = {
            "name": scan.name,
            "sha256": scan.sha256,
            "points": scan.n_points,
            "low_m": low_m.tolist(),
            "high_m": high_m.tolist(),
            "extent_m": (high_m - low_m).tolist(),
            "colours": scan.colours is not None,
            "frames": 0 if scan.frame_ids is None else len(np.unique(scan.frame_ids)),
            "sensor_positions": len(scan.frames),
            "warnings": [{"code": note.code, "message": note.message} for note in scan.notes],
        }
        if self.json:
            json.dump(facts, sys.stdout, indent=1)
            sys.stdout.write("\n")
            return 0
        extent = " x ".join(f"{side:.3f}" for side in high_m - low_m)
        sys.stdout.write(
            f"{scan.name}: {scan.n_points} points, {extent} m, "
            f"{'with' if scan.colours is not None else 'no'} colours, "
            f"{facts['frames']} frames, {facts['sensor_positions']} sensor positions\n"
        )
        for note in scan.notes:
            sys.stdout.write(f"{note.code}: {note.message}\n")
        return 0
