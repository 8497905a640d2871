"""``indoorfit explain``: why each candidate became a wall or not."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import tyro

from indoorfit.files import staged
from indoorfit.stages import announced

from .maybe import Flag, Maybe, Quiet
from .runtime import set_up_logging
from .settings import Unit, Up, run_config


@dataclass(frozen=True)
class ExplainCommand:
    """Say of every candidate wall whether it was accepted, and why, with the numbers that decided."""

    scan: tyro.conf.Positional[Path]
    """The point cloud: .ply, .pcd, .xyz, .txt, .csv, .pts, .npy or .npz."""
    out: Maybe[Path] = None
    """Directory for explain.json, explain.txt, explain.svg and explain.png; without it only the text is
    printed."""
    config: Maybe[Path] = None
    """TOML file with settings; options given here win over it."""
    overrides: Maybe[Path] = None
    """TOML file with a table [overrides]: walls forced or forbidden, boxes ignored, yaw, up axis."""
    unit: Unit = "m"
    """Unit of the file's coordinates."""
    up: Maybe[Up] = None
    """Up direction in the file's axes; default: found by evidence. Write --up=-y for a negative axis."""
    seed: Maybe[int] = None
    """Seed of everything random; default 0."""
    overwrite: Flag = False
    """Replace an earlier explanation in the same directory."""
    json: Flag = False
    """Print JSON instead of the text."""
    quiet: Quiet = False
    """Only warnings and errors on standard error."""

    def run(self) -> int:
        """Carry the command out; returns 0."""
        set_up_logging(self.quiet, verbose=False)
        if self.out is None:
            self._tell(self._explained())
            return 0
        with staged([self.out], overwrite=self.overwrite, marks=("explain.json",), folders=True) as (place,):
            found = self._explained()
            place.mkdir()
            _write(place, found)
        self._tell(found)
        return 0

    def _explained(self):
        from indoorfit.io import read_scan
        from indoorfit.pipeline import explain_scan

        config = run_config(self.config, self.up, None, self.overrides, seed=self.seed)
        with announced("read"):
            scan = read_scan(self.scan, unit=self.unit)
        return explain_scan(scan, config)

    def _tell(self, found) -> None:
        from indoorfit.report import explain_document, explain_table

        if self.json:
            json.dump(explain_document(found.explanation, found.frame), sys.stdout, indent=1, allow_nan=False)
            sys.stdout.write("\n")
        else:
            sys.stdout.write(explain_table(found.explanation, found.frame))


def _write(place: Path, found) -> None:
    from indoorfit.report import (
        explain_document,
        explain_picture,
        explain_table,
        to_svg,
        write_picture_png,
    )

    parts = (found.explanation, found.frame)
    document = json.dumps(explain_document(*parts), indent=1, allow_nan=False)
    (place / "explain.json").write_text(document + "\n", encoding="utf-8")
    (place / "explain.txt").write_text(explain_table(*parts), encoding="utf-8")
    picture = explain_picture(*parts, found.scan.points_m)
    (place / "explain.svg").write_text(to_svg(picture), encoding="utf-8")
    write_picture_png(place / "explain.png", picture)
