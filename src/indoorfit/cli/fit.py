"""``indoorfit fit``: from a scan to a model on disk."""

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import tyro

from .runtime import set_up_logging


@dataclass(frozen=True)
class FitCommand:
    """Fit a room to a scan and write model.json, GLB, VRML, OBJ, dimensions.csv, plan and report."""

    scan: tyro.conf.Positional[Path]
    """The point cloud: .ply, .pcd, .xyz, .txt, .csv, .pts, .npy or .npz."""
    out: Path
    """Directory to write; it must not exist, or hold an earlier result and --overwrite be given."""
    method: Literal["joint", "greedy"] | None = None
    """joint (default): all surfaces fitted together; greedy: the procedure of the 2013 thesis."""
    level: float | None = None
    """Coverage of the intervals, 0.5 to 0.999; default 0.95."""
    config: Path | None = None
    """TOML file with settings; options given here win over it."""
    unit: Literal["m", "cm", "mm", "ft", "in"] = "m"
    """Unit of the file's coordinates."""
    up: Literal["auto", "x", "y", "z", "-x", "-y", "-z"] | None = None
    """Up direction in the file's axes; default: found by evidence. Write --up=-y for a negative axis."""
    seed: int | None = None
    """Seed of everything random; default 0."""
    overwrite: bool = False
    """Replace an earlier result in the same directory."""
    write_registered: Path | None = None
    """Also write the scan as PLY with the slip of every frame taken out; needs frame ids, and turns
    belief.use_frames on."""
    json: bool = False
    """Print the whole model as JSON instead of the table."""
    quiet: Annotated[bool, tyro.conf.arg(aliases=["-q"])] = False
    """Only warnings and errors on standard error."""
    verbose: Annotated[bool, tyro.conf.arg(aliases=["-v"])] = False
    """More on standard error, with the time of every stage."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(self.quiet, self.verbose)
        from indoorfit.config import RunConfig, load_config
        from indoorfit.io import check_output_directory, read_scan

        check_output_directory(self.out, overwrite=self.overwrite)
        config = load_config(self.config) if self.config else RunConfig()
        given = {"method": self.method, "level": self.level, "seed": self.seed}
        config = replace(config, **{name: value for name, value in given.items() if value is not None})
        if self.up is not None:
            config = replace(config, orient=replace(config.orient, up=self.up))
        scan = read_scan(self.scan, unit=self.unit)
        registered = self.write_registered
        if registered is not None:
            check_registrable(scan, config, registered, overwrite=self.overwrite)
            config = replace(config, belief=replace(config.belief, use_frames=True))
        return run_pipeline(
            scan, config, self.out, overwrite=self.overwrite, as_json=self.json, registered=registered
        )


def check_registrable(scan, config, path: Path, *, overwrite: bool) -> None:
    """Say before the fit what would keep the registered cloud from being written."""
    from indoorfit.errors import InputError, OutputError

    if scan.frame_ids is None:
        raise InputError(
            f"{scan.name}: no frame ids; --write-registered moves single frames and needs the frame of every "
            "point. Fix: export the scan with an integer property `frame`, or leave the option out."
        )
    if config.method != "joint":
        raise InputError(
            f"{scan.name}: --write-registered needs the slips of the frames, which only the joint method "
            "estimates. Fix: --method joint."
        )
    if path.suffix.lower() != ".ply":
        raise OutputError(f"{path}: need a name that ends in .ply. Fix: rename it.")
    if path.exists() and not overwrite:
        raise OutputError(f"{path}: exists already. Fix: choose another name or give --overwrite.")


def run_pipeline(
    scan, config, out: Path, *, overwrite: bool, as_json: bool, registered: Path | None = None
) -> int:
    """Fit, write and print; returns 0, or 3 where the model is not sound."""
    import logging

    from indoorfit.io import to_document
    from indoorfit.pipeline import fit_scan, write_outputs
    from indoorfit.report import dimension_table

    log = logging.getLogger("indoorfit")
    for note in scan.notes:
        # At once: the note on the unit is the likeliest reason for what goes wrong later.
        log.warning("%s: %s", note.code, note.message)
    result = fit_scan(scan, config)
    for stage, seconds in result.provenance["timings_s"].items():
        log.debug("%s took %.2f s", stage, seconds)
    if registered is not None:
        _write_registered(scan, result, registered, overwrite=overwrite)
    write_outputs(result, out, scan, overwrite=overwrite)
    if as_json:
        json.dump(to_document(result), sys.stdout, indent=1)
        sys.stdout.write("\n")
    else:
        sys.stdout.write(dimension_table(result))
    log.info("written to %s", out)
    return 0 if result.converged else 3


def _write_registered(scan, result, path: Path, *, overwrite: bool) -> None:
    from indoorfit.errors import InputError
    from indoorfit.fitting import register
    from indoorfit.io import write_ply

    if not result.registration:
        reason = next((n.message for n in result.notes if n.code == "FRAMES_UNUSED"), "no face has cells.")
        raise InputError(f"{scan.name}: no registered cloud: {reason} Fix: leave --write-registered out.")
    write_ply(path, register(scan, result.registration), overwrite=overwrite)
