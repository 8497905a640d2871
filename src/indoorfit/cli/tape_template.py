"""``indoorfit tape-template``: a table to fill in on site, and the plan that shows where each length is."""

import sys
from dataclasses import dataclass
from pathlib import Path

import tyro

from .maybe import Flag
from .runtime import set_up_logging


@dataclass(frozen=True)
class TapeTemplateCommand:
    """Print a CSV table with the ids of a fitted room's lengths, ready for the readings of a tape.

    The plan with the same ids is written beside it. Fill in value, unit and instrument (tape or laser); rows
    without a value are passed over. Then: indoorfit fit SCAN --out DIR --tape TABLE.
    """

    model: tyro.conf.Positional[Path]
    """The model.json of the room."""
    plan: Path = Path("tape-plan.svg")
    """Where the plan goes (SVG)."""
    overwrite: Flag = False
    """Replace an existing plan."""

    def run(self) -> int:
        """Carry the command out; returns the exit code."""
        set_up_logging(quiet=False, verbose=False)
        import logging

        from indoorfit.files import atomic_file
        from indoorfit.io import read_model_json
        from indoorfit.report import plan_svg, tape_template

        result = read_model_json(self.model)
        drawing = plan_svg(result).encode("utf-8")
        with atomic_file(self.plan, overwrite=self.overwrite) as file:
            file.write(drawing)
        sys.stdout.write(tape_template(result))
        logging.getLogger("indoorfit").info("the plan is in %s", self.plan)
        return 0
