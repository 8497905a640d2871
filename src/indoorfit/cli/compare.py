"""``indoorfit compare``: the joint and the greedy fit of one scan side by side."""

import json
import logging
import sys
from dataclasses import dataclass
from pathlib import Path

import tyro

from indoorfit.files import staged
from indoorfit.stages import announced

from .maybe import Flag, Maybe, Quiet
from .runtime import set_up_logging
from .settings import Sensor, Unit, Up, run_config


@dataclass(frozen=True)
class CompareCommand:
    """Fit a scan jointly and greedily: lengths, intervals, residuals and time side by side."""

    scan: tyro.conf.Positional[Path]
    """The point cloud: .ply, .pcd, .xyz, .txt, .csv, .pts, .npy or .npz."""
    out: Maybe[Path] = None
    """Directory for compare.json, compare.txt, compare.svg and compare.png; without it only the table is
    printed."""
    level: Maybe[float] = None
    """Coverage of the intervals, 0.5 to 0.999; default 0.95."""
    config: Maybe[Path] = None
    """TOML file with settings; options given here win over it."""
    unit: Unit = "m"
    """Unit of the file's coordinates."""
    up: Maybe[Up] = None
    """Up direction in the file's axes; default: found by evidence. Write --up=-y for a negative axis."""
    sensor: Maybe[Sensor] = None
    """What took the scan; see `indoorfit fit --help`."""
    seed: Maybe[int] = None
    """Seed of everything random; default 0."""
    overwrite: Flag = False
    """Replace an earlier comparison in the same directory."""
    json: Flag = False
    """Print JSON instead of the table."""
    quiet: Quiet = False
    """Only warnings and errors on standard error."""

    def run(self) -> int:
        """Carry the command out; returns 0, or 3 where one of the two is missing or not sound."""
        set_up_logging(self.quiet, verbose=False)
        config = run_config(self.config, self.up, self.sensor, level=self.level, seed=self.seed)
        if self.out is None:
            return self._told(self._fitted(config)[0])
        with staged([self.out], overwrite=self.overwrite, marks=("compare.json",), folders=True) as (place,):
            both, scan = self._fitted(config)
            place.mkdir()
            self._write(place, both, scan)
        return self._told(both)

    def _fitted(self, config):
        from indoorfit.io import read_scan
        from indoorfit.pipeline import fit_both, sensor_from_data

        with announced("read"):
            scan = read_scan(self.scan, unit=self.unit)
        if self.sensor is None:
            scan, config = sensor_from_data(scan, config)
        return fit_both(scan, config), scan

    def _write(self, place: Path, both, scan) -> None:
        from indoorfit.report import to_svg, versus_document, versus_picture, versus_table, write_picture_png

        parts = (both.joint, both.greedy, both.matched)
        document = json.dumps(versus_document(*parts, both.refusals), indent=1, allow_nan=False)
        (place / "compare.json").write_text(document + "\n", encoding="utf-8")
        (place / "compare.txt").write_text(versus_table(*parts, both.refusals), encoding="utf-8")
        if both.matched is None:
            logging.getLogger("indoorfit").warning("no picture: there is one model only")
            return
        picture = versus_picture(*parts, scan.points_m)
        (place / "compare.svg").write_text(to_svg(picture), encoding="utf-8")
        write_picture_png(place / "compare.png", picture)

    def _told(self, both) -> int:
        from indoorfit.report import versus_document, versus_table

        parts = (both.joint, both.greedy, both.matched, both.refusals)
        if self.json:
            json.dump(versus_document(*parts), sys.stdout, indent=1, allow_nan=False)
            sys.stdout.write("\n")
        else:
            sys.stdout.write(versus_table(*parts))
        sound = all(result is not None and result.converged for result in (both.joint, both.greedy))
        return 0 if sound else 3
