"""``indoorfit fit``: from a scan to a model on disk."""

import json
import sys
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Literal

import tyro

from indoorfit.files import FormatName, check_output_directory, check_staged, staged
from indoorfit.stages import announced

from .maybe import Flag, Maybe, Quiet, Verbose
from .runtime import set_up_logging
from .settings import Sensor, Unit, Up, run_config
from .texture_options import Textures


@dataclass(frozen=True)
class FitCommand:
    """Fit a room to a scan and write model.json, GLB, VRML, OBJ, textures, dimensions, plan and report."""

    scan: tyro.conf.Positional[Path]
    """The point cloud: .ply, .pcd, .xyz, .txt, .csv, .pts, .npy or .npz."""
    out: Maybe[Path] = None
    """Directory to write. It must not exist yet, unless it holds an earlier result and --overwrite is given.
    Default: in the current directory, the scan's name with -room."""
    method: Maybe[Literal["joint", "greedy"]] = None
    """joint (default): all surfaces fitted together; greedy: the procedure of the 2013 thesis."""
    level: Maybe[float] = None
    """Coverage of the intervals, 0.5 to 0.999; default 0.95."""
    config: Maybe[Path] = None
    """TOML file with settings; options given here win over it."""
    tape: Maybe[Path] = None
    """Readings of a tape or laser meter (CSV, TOML; see tape-template): adds deviation and E_n."""
    overrides: Maybe[Path] = None
    """TOML file with a table [overrides]: walls forced or forbidden, boxes ignored, yaw, up axis."""
    unit: Unit = "m"
    """Unit of the file's coordinates."""
    up: Maybe[Up] = None
    """Up direction in the file's axes; default: found by evidence. Write --up=-y for a negative axis."""
    sensor: Maybe[Sensor] = None
    """What took the scan; adds the uncertainty of its scale, and about 2 mm for plaster and skirting.
    Default: chosen by the data where frame ids and sensor poses decide it, which is said; else unknown:
    nothing is added, and the output says so."""
    sample: Flag = False
    """Sample the noise model of the walls by Markov chains (emcee) instead of the analytic approximation;
    refuses to report from chains that have not converged. That of the frames' slips stays analytic."""
    format: Annotated[tuple[FormatName, ...], tyro.conf.arg(help_behavior_hint="")] = ()
    """Further formats to write, e.g. `--format ifc dxf pdf`; `indoorfit convert` makes them later too."""
    pdf: Flag = False
    """Also write report.pdf: plan, tables, warnings and provenance on A4; needs `indoorfit[plan]`."""
    seed: Maybe[int] = None
    """Seed of everything random; default 0."""
    textures: tyro.conf.OmitArgPrefixes[Textures] = field(default_factory=Textures)
    overwrite: Flag = False
    """Replace an earlier result in the same directory, and the file of --write-registered."""
    write_registered: Maybe[Path] = None
    """Also write the scan as PLY with the slip of every frame taken out; needs frame ids, and turns
    belief.use_frames on."""
    json: Flag = False
    """Print the whole model as JSON instead of the table."""
    quiet: Quiet = False
    """Only warnings and errors on standard error."""
    verbose: Verbose = False
    """More on standard error, with the time of every stage."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(self.quiet, self.verbose)
        from indoorfit.io import read_scan, read_tape

        out = Path(f"{self.scan.stem}-room") if self.out is None else self.out
        check_output_directory(out, overwrite=self.overwrite)
        if self.format or self.pdf:
            from indoorfit.pipeline import check_formats

            check_formats(self.format, self.pdf)
        given = {"method": self.method, "level": self.level, "seed": self.seed}
        given["sample"] = self.sample or None
        config = run_config(self.config, self.up, self.sensor, self.overrides, **given)
        config = replace(config, texture=self.textures.settings(config.texture))
        # Before the scan: a wrong table is told at once, not after the fit.
        tape = None if self.tape is None else read_tape(self.tape)
        pictures = self.textures.pictures()
        with announced("read"):
            scan = read_scan(self.scan, unit=self.unit)
        if self.sensor is None:
            from indoorfit.pipeline import sensor_from_data

            scan, config = sensor_from_data(scan, config)
        registered = self.write_registered
        if registered is not None:
            check_registrable(scan, config, registered, out)
            check_staged(registered, overwrite=self.overwrite)
            config = replace(config, belief=replace(config.belief, use_frames=True))
        return run_pipeline(
            scan,
            config,
            out,
            pictures,
            tape,
            overwrite=self.overwrite,
            as_json=self.json,
            formats=self.format,
            pdf=self.pdf,
            registered=registered,
        )


def check_registrable(scan, config, path: Path, out: Path) -> None:
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
    if path.resolve().is_relative_to(out.resolve()):
        raise OutputError(f"{path}: lies in {out}, which is written as a whole. Fix: choose another folder.")


def run_pipeline(
    scan,
    config,
    out: Path,
    pictures=None,
    tape=None,
    *,
    overwrite: bool,
    as_json: bool,
    formats: tuple[FormatName, ...] = (),
    pdf: bool = False,
    registered: Path | None = None,
) -> int:
    """Fit, write and print; returns 0, or 3 where the model is not sound."""
    import logging

    from indoorfit.io import to_document
    from indoorfit.model import Pictures
    from indoorfit.pipeline import fit_scan, with_tape, write_outputs
    from indoorfit.report import dimension_table

    log = logging.getLogger("indoorfit")
    for note in scan.notes:
        # At once: the note on the unit is the likeliest reason for what goes wrong later.
        log.warning("%s: %s", note.code, note.message)
    result = fit_scan(scan, config, pictures or Pictures())
    if tape is not None:
        result = with_tape(result, tape)
        for row in result.tape.refused if result.tape else ():
            log.warning("%s, line %d: %s", tape.name, row.line, row.reason)
    with announced("write"), ExitStack() as together:
        if registered is not None:
            # Its place is taken last: nothing is left of it where the model cannot be written.
            (place,) = together.enter_context(staged([registered], overwrite=overwrite))
            _write_registered(scan, result, place)
        write_outputs(result, out, scan, overwrite=overwrite, formats=formats, pdf=pdf)
    if as_json:
        json.dump(to_document(result), sys.stdout, indent=1)
        sys.stdout.write("\n")
    else:
        sys.stdout.write(dimension_table(result))
    log.info("written to %s", out)
    return 0 if result.converged else 3


def _write_registered(scan, result, path: Path) -> None:
    from indoorfit.errors import InputError
    from indoorfit.fitting import register
    from indoorfit.io import write_ply

    if not result.registration:
        reason = next((n.message for n in result.notes if n.code == "FRAMES_UNUSED"), "no face has cells.")
        raise InputError(f"{scan.name}: no registered cloud: {reason} Fix: leave --write-registered out.")
    write_ply(path, register(scan, result.registration))
