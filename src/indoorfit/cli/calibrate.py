"""``indoorfit calibrate``: from a batch with references to settings with calibrated intervals."""

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from .maybe import Flag, Maybe
from .runtime import set_up_logging

if TYPE_CHECKING:
    # Loading the batch costs a second that --help should not.
    from indoorfit.batch import Calibration, JudgedLength, NoiseScales


@dataclass(frozen=True)
class CalibrateCommand:
    """Learn from a batch how much wider or narrower its intervals must be, and write that as settings.

    Prints the factor with its uncertainty, for all lengths and by sensor and kind, and how many references
    the intervals hold before and after, each room judged with the factor of the others.
    """

    batch: tyro.conf.Positional[Path]
    """Directory of `indoorfit evaluate`."""
    out: Maybe[Path] = None
    """TOML file for `indoorfit fit --config`; nothing is written without it."""
    config: Maybe[str] = None
    """Which configuration of the batch, if it has several."""
    sensor: Maybe[str] = None
    """Only scans of this sensor, by the manifest's word for it: one preset for each."""
    scales: Flag = False
    """Learn three noise scales in place of one factor: what the residuals show, the sensor's scale error, and
    where the wall is."""
    conformal: Flag = False
    """Write the conformal factor: guaranteed for exchangeable rooms, at 95 % from 19 rooms on."""
    seed: int = 0
    """Decides which length of each room stands for it in the conformal factor."""
    overwrite: Flag = False
    """Replace an existing file."""
    json: Flag = False
    """Print JSON."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=False, verbose=False)
        from indoorfit.batch import calibrate, learn_scales, preset_toml, read_lengths, scales_toml
        from indoorfit.errors import ConfigError
        from indoorfit.files import atomic_file

        if self.scales and self.conformal:
            raise ConfigError(
                "calibrate: --scales and --conformal are two presets. Fix: run it once for each."
            )
        lengths, settings = read_lengths(self.batch, self.config, self.sensor)
        found = calibrate(lengths, self.seed)
        text = _factors(found, lengths, self.seed)
        scales = learn_scales(lengths) if self.scales else None
        if scales is not None:
            preset = scales_toml(scales, settings, found.level)
            text += _scales(scales)
        else:
            preset = preset_toml(found, settings, self.conformal)
        if self.out is not None:
            with atomic_file(self.out, overwrite=self.overwrite) as file:
                file.write(preset.encode("utf-8"))
        if self.json:
            document = {**asdict(found), "says": found.says}
            if scales is not None:
                document["scales"] = asdict(scales)
            text = json.dumps(document, indent=1) + "\n"
        sys.stdout.write(text)
        return 0


def _factors(found: "Calibration", lengths: "list[JudgedLength]", seed: int) -> str:
    from indoorfit.batch import calibrate_groups

    too_few = f"not available: {found.n_rooms} rooms, {found.conformal_rooms} needed"
    conformal = too_few if found.conformal is None else f"{found.conformal:.3f}"
    groups = ""
    for by in ("sensor", "kind"):
        parts = calibrate_groups(lengths, by, seed)
        if len(parts) > 1:
            groups += "".join(
                f"  {name:<16}{part.factor:.3f} ({part.factor_low:.3f} to {part.factor_high:.3f}) in "
                f"{part.n_rooms} rooms\n"
                for name, part in parts.items()
            )
    return (
        f"{found.n_lengths} lengths in {found.n_rooms} rooms, intervals at {100 * found.level:g} %\n"
        f"factor            {found.factor:.3f} ({found.factor_low:.3f} to {found.factor_high:.3f}); "
        f"t tails of {found.dof:g} degrees of freedom\n"
        f"{groups}"
        f"conformal factor  {conformal}\n"
        f"held before       {100 * found.held_before:.1f} %\n"
        f"held after        {100 * found.held_after:.1f} % (each room with the factor of the others)\n"
        f"{found.says}\n"
    )


def _scales(found: "NoiseScales") -> str:
    rows = (
        ("residuals, times", found.factor, 1.0, ""),
        ("sensor's scale", found.scale_std, 100.0, " %"),
        ("the wall", found.definition_std_m, 1e3, " mm"),
    )
    lines = [
        f"  {name:<18}{unit * x.value:.3g}{sign} ({unit * x.low:.3g} to {unit * x.high:.3g}{sign})\n"
        for name, x, unit, sign in rows
    ]
    before, factor, scales = (1e3 * x for x in (found.score_before_m, found.score_factor_m, found.score_m))
    return (
        "noise scales\n" + "".join(lines) + f"held              {100 * found.held:.1f} % (each room with the "
        "scales of the others)\n"
        f"interval score    {before:.2f} mm before, {factor:.2f} mm with the factor, {scales:.2f} mm with "
        "the scales (smaller is better)\n"
    )
