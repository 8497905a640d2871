"""The command ``indoorfit``."""

import errno
import io
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from importlib.metadata import version
from typing import Annotated, get_args

from indoorfit.environment import prepare_numerics

prepare_numerics()
if os.environ.get("NO_COLOR"):
    # https://no-color.org; tyro asks only whether there is a terminal.
    os.environ.setdefault("PYTHON_TYRO_ANSI_CODES", "False")

import tyro  # noqa: E402  (NumPy must not be loaded before the lines above)

from indoorfit.errors import IndoorfitError  # noqa: E402

from .calibrate import CalibrateCommand  # noqa: E402
from .compare import CompareCommand  # noqa: E402
from .completion import CompletionCommand  # noqa: E402
from .convert import ConvertCommand  # noqa: E402
from .demo import DemoCommand  # noqa: E402
from .doctor import DoctorCommand  # noqa: E402
from .evaluate import EvaluateCommand  # noqa: E402
from .explain import ExplainCommand  # noqa: E402
from .figures import FiguresCommand  # noqa: E402
from .fit import FitCommand  # noqa: E402
from .info import InfoCommand  # noqa: E402
from .runtime import coloured, end_logging  # noqa: E402
from .simulate import SimulateCommand  # noqa: E402
from .tape_template import TapeTemplateCommand  # noqa: E402

Command = (
    Annotated[FitCommand, tyro.conf.subcommand("fit")]
    | Annotated[ConvertCommand, tyro.conf.subcommand("convert")]
    | Annotated[CompareCommand, tyro.conf.subcommand("compare")]
    | Annotated[ExplainCommand, tyro.conf.subcommand("explain")]
    | Annotated[FiguresCommand, tyro.conf.subcommand("figures")]
    | Annotated[SimulateCommand, tyro.conf.subcommand("simulate")]
    | Annotated[DemoCommand, tyro.conf.subcommand("demo")]
    | Annotated[InfoCommand, tyro.conf.subcommand("info")]
    | Annotated[TapeTemplateCommand, tyro.conf.subcommand("tape-template")]
    | Annotated[EvaluateCommand, tyro.conf.subcommand("evaluate")]
    | Annotated[CalibrateCommand, tyro.conf.subcommand("calibrate")]
    | Annotated[DoctorCommand, tyro.conf.subcommand("doctor")]
    | Annotated[CompletionCommand, tyro.conf.subcommand("completion")]
)


USAGE = 2
BROKEN_PIPE = 128 + 13
"""What a shell reports of a program that SIGPIPE ended."""


def parse(arguments: list[str] | None = None) -> Command:
    """The command that the arguments (default: the process' own) stand for.

    Raises:
        SystemExit: help or a completion script was asked for, or the arguments make no command.
    """
    return tyro.cli(
        Command,
        prog="indoorfit",
        description="From a raw indoor point cloud to a watertight, measured room.",
        config=(tyro.conf.FlagCreatePairsOff,),
        args=arguments,
    )


def main() -> None:
    """Parse, run, and map errors to exit codes: 0 done, 1 user error, 2 usage, 3 model not sound."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            # The caller has closed it (`>&-`): nobody wants to read it.
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A terminal without the sign for plus-minus is no reason to fail after the work is done.
            stream.reconfigure(errors="replace")
    try:
        sys.exit(_run())
    except BrokenPipeError:
        # Whoever read the output has seen enough; the files are written before it is printed.
        _drop_output()
        sys.exit(BROKEN_PIPE)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise
        # Files say themselves what keeps them from being written: it is the output that has no room.
        _drop_output()
        sys.stderr.write(
            f"indoorfit: standard output: {error.strerror}. Fix: make room, or send it elsewhere.\n"
        )
        sys.exit(1)


class _Ended(BaseException):
    """A signal asks the program to end: raised like KeyboardInterrupt, so that what is half written goes."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextmanager
def _signals_raised() -> Iterator[None]:
    """SIGTERM (kill, a time limit) and SIGHUP (a closed terminal) leave the block by way of `finally`."""
    known = [number for name in ("SIGTERM", "SIGHUP") if (number := getattr(signal, name, None)) is not None]
    # What the caller has switched off (nohup) or handles himself stays so.
    taken = [number for number in known if signal.getsignal(number) == signal.SIG_DFL]
    for number in taken:
        signal.signal(number, _raise_ended)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def _raise_ended(number: int, _frame: object) -> None:
    # Once is enough: a second signal must not stop the tidying up.
    signal.signal(number, signal.SIG_IGN)
    raise _Ended(number)


def _drop_output() -> None:
    """Let the interpreter's end find nothing that it would fail to write."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _run() -> int:
    try:
        if sys.argv[1:] == ["--version"]:
            sys.stdout.write(f"indoorfit {version('indoorfit')}\n")
            return 0
        if meant := _meant(sys.argv[1:]):
            sys.stderr.write(f"indoorfit: there is no command {sys.argv[1]!r}; did you mean {meant}?\n")
            return USAGE
        with _signals_raised():
            return parse().run()
    except IndoorfitError as error:
        end_logging()
        sys.stderr.write(f"{coloured('indoorfit:', sys.stderr)} {error}\n")
        return 1
    except KeyboardInterrupt:
        end_logging()
        sys.stderr.write("indoorfit: interrupted; nothing is half written.\n")
        return 130
    except _Ended as end:
        end_logging()
        sys.stderr.write("indoorfit: terminated; nothing is half written.\n")
        return 128 + end.number
    finally:
        end_logging()
        # Now and not at the interpreter's end, where a closed pipe could only be complained of.
        sys.stdout.flush()


def _meant(arguments: list[str]) -> str | None:
    """The command that was misspelt; None where there is none, or it is like no command."""
    names = [get_args(command)[1].name for command in get_args(Command)]
    if not arguments or arguments[0].startswith("-") or arguments[0] in names:
        return None
    return next(iter(get_close_matches(arguments[0].lower(), names, n=1)), None)


if __name__ == "__main__":
    main()
