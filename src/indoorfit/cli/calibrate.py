"""``indoorfit calibrate``: from a batch with references to settings with calibrated intervals."""

import sys
from dataclasses import dataclass
from pathlib import Path

import tyro

from .runtime import set_up_logging


@dataclass(frozen=True)
class CalibrateCommand:
    """Learn from a batch how much wider or narrower its intervals must be, and write that as settings.

    Prints the factor with its uncertainty, and how many references the intervals hold before and after, each
    room judged with the factor of the others.
    """

    batch: tyro.conf.Positional[Path]
    """Directory of `indoorfit evaluate`."""
    out: Path | None = None
    """TOML file for `indoorfit fit --config`; nothing is written without it."""
    config: str | None = None
    """Which configuration of the batch, if it has several."""
    conformal: bool = False
    """Write the conformal factor: guaranteed for exchangeable rooms, at 95 % from 19 rooms on."""
    seed: int = 0
    """Decides which length of each room stands for it in the conformal factor."""
    overwrite: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=False, verbose=False)
        from indoorfit.batch import calibrate, preset_toml, read_lengths
        from indoorfit.files import atomic_file

        lengths, settings = read_lengths(self.batch, self.config)
        found = calibrate(lengths, self.seed)
        preset = preset_toml(found, settings, self.conformal)
        if self.out is not None:
            with atomic_file(self.out, overwrite=self.overwrite) as file:
                file.write(preset.encode("utf-8"))
        too_few = f"not available: {found.n_rooms} rooms, {found.conformal_rooms} needed"
        conformal = too_few if found.conformal is None else f"{found.conformal:.3f}"
        sys.stdout.write(
            f"{found.n_lengths} lengths in {found.n_rooms} rooms, intervals at {100 * found.level:g} %\n"
            f"factor            {found.factor:.3f} ({found.factor_low:.3f} to {found.factor_high:.3f}); "
            f"t tails of {found.dof:g} degrees of freedom\n"
            f"conformal factor  {conformal}\n"
            f"held before       {100 * found.held_before:.1f} %\n"
            f"held after        {100 * found.held_after:.1f} % (each room with the factor of the others)\n"
            f"{found.says}\n"
        )
        return 0
