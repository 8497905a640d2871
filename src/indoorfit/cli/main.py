"""The command ``indoorfit``."""

import io
import os
import sys
from typing import Annotated

from indoorfit.environment import prepare_numerics

prepare_numerics()

import tyro  # noqa: E402  (NumPy must not be loaded before the lines above)

from indoorfit.errors import IndoorfitError  # noqa: E402

from .calibrate import CalibrateCommand  # noqa: E402
from .compare import CompareCommand  # noqa: E402
from .convert import ConvertCommand  # noqa: E402
from .demo import DemoCommand  # noqa: E402
from .evaluate import EvaluateCommand  # noqa: E402
from .explain import ExplainCommand  # noqa: E402
from .fit import FitCommand  # noqa: E402
from .info import InfoCommand  # noqa: E402
from .simulate import SimulateCommand  # noqa: E402
from .tape_template import TapeTemplateCommand  # noqa: E402

Command = (
    Annotated[FitCommand, tyro.conf.subcommand("fit")]
    | Annotated[ConvertCommand, tyro.conf.subcommand("convert")]
    | Annotated[CompareCommand, tyro.conf.subcommand("compare")]
    | Annotated[ExplainCommand, tyro.conf.subcommand("explain")]
    | Annotated[SimulateCommand, tyro.conf.subcommand("simulate")]
    | Annotated[DemoCommand, tyro.conf.subcommand("demo")]
    | Annotated[InfoCommand, tyro.conf.subcommand("info")]
    | Annotated[TapeTemplateCommand, tyro.conf.subcommand("tape-template")]
    | Annotated[EvaluateCommand, tyro.conf.subcommand("evaluate")]
    | Annotated[CalibrateCommand, tyro.conf.subcommand("calibrate")]
)


def main() -> None:
    """Parse, run, and map errors to exit codes: 0 done, 1 user error, 2 usage, 3 model not sound."""
    command = tyro.cli(
        Command,
        prog="indoorfit",
        description="From a raw indoor point cloud to a watertight, measured room.",
        config=(tyro.conf.FlagCreatePairsOff,),
    )
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A terminal without the sign for plus-minus is no reason to fail after the work is done.
            stream.reconfigure(errors="replace")
    try:
        code = command.run()
    except IndoorfitError as error:
        sys.stderr.write(f"indoorfit: {error}\n")
        code = 1
    except BrokenPipeError:
        # Whoever read the table has seen enough; the files are written before it is printed.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    except KeyboardInterrupt:
        sys.stderr.write("indoorfit: interrupted; nothing is half written.\n")
        code = 130
    sys.exit(code)


if __name__ == "__main__":
    main()
