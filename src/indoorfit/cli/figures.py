"""``indoorfit figures``: plots of a scan and its model as files for papers."""

import logging
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from indoorfit.stages import announced

from .maybe import Flag, Maybe, Quiet
from .runtime import set_up_logging
from .settings import Sensor, Unit, Up, run_config


@dataclass(frozen=True)
class FiguresCommand:
    """Draw plan, residual histogram, normal vectors and every step of the grammar, as SVG, PDF or PNG.

    The steps are those of the thesis' procedure (largest cube, remaining segments, notch cubes, result);
    figures.json has a caption for each figure. Needs `pip install 'indoorfit[figures]'`.
    """

    scan: tyro.conf.Positional[Path]
    """The point cloud: .ply, .pcd, .xyz, .txt, .csv, .pts, .npy or .npz."""
    out: Path
    """Directory to write; it must not exist, or hold earlier figures and --overwrite be given."""
    format: tuple[Literal["svg", "pdf", "png"], ...] = ("svg",)
    """File formats, e.g. `--format svg pdf`."""
    batch: Maybe[Path] = None
    """Directory of `indoorfit evaluate`: adds the reliability of its intervals."""
    method: Maybe[Literal["joint", "greedy"]] = None
    """Of the model in plan and histogram; default joint."""
    level: Maybe[float] = None
    """Coverage of the intervals, 0.5 to 0.999; default 0.95."""
    config: Maybe[Path] = None
    """TOML file with settings; options given here win over it."""
    overrides: Maybe[Path] = None
    """TOML file with a table [overrides]."""
    unit: Unit = "m"
    """Unit of the file's coordinates."""
    up: Maybe[Up] = None
    """Up direction in the file's axes; default: found by evidence. Write --up=-y for a negative axis."""
    sensor: Maybe[Sensor] = None
    """What took the scan; see `indoorfit fit --help`."""
    seed: Maybe[int] = None
    """Seed of everything random; default 0."""
    overwrite: Flag = False
    """Replace earlier figures in the same directory."""
    json: Flag = False
    """Print the list of figures as JSON, with captions."""
    quiet: Quiet = False
    """Only warnings and errors on standard error."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(self.quiet, verbose=False)
        from dataclasses import replace

        from indoorfit.io import read_scan
        from indoorfit.pipeline import check_figures, fit_scan, sensor_from_data, write_figures

        check_figures(self.out, self.format, overwrite=self.overwrite)
        given = {"method": self.method, "level": self.level, "seed": self.seed}
        config = run_config(self.config, self.up, self.sensor, self.overrides, **given)
        config = replace(config, texture=replace(config.texture, enabled=False))
        pictures = {}
        if self.batch is not None:
            from indoorfit.batch import reliability_of

            pictures["reliability"] = reliability_of(self.batch)
        with announced("read"):
            scan = read_scan(self.scan, unit=self.unit)
        if self.sensor is None:
            scan, config = sensor_from_data(scan, config)
        result = fit_scan(scan, config)
        names = write_figures(
            result, scan, config, self.out,
            formats=self.format, overwrite=self.overwrite, pictures=pictures,
        )  # fmt: skip
        if self.json:
            sys.stdout.write((self.out / "figures.json").read_text(encoding="utf-8"))
        else:
            sys.stdout.write("".join(f"{self.out / name}.{kind}\n" for name in names for kind in self.format))
        logging.getLogger("indoorfit").info("captions are in %s", self.out / "figures.json")
        return 0 if result.converged else 3
