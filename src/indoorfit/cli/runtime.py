"""What every command sets up before it works."""

import logging
import os
import sys

from .progress import ProgressLine, Stream

_YELLOW, _RED, _RESET = "\x1b[33m", "\x1b[31m", "\x1b[0m"


def set_up_logging(quiet: bool, verbose: bool) -> None:
    """Messages and progress of indoorfit to standard error; of the libraries below only what is wrong.

    Progress is a line that changes in place, hence for terminals only; with `verbose` every stage's time
    stays, there and elsewhere.
    """
    logger = logging.getLogger("indoorfit")
    end_logging()
    level = logging.WARNING if quiet else logging.DEBUG if verbose else logging.INFO
    logger.handlers[:] = [TerminalHandler(sys.stderr, level, progress=not quiet and is_terminal(sys.stderr))]
    logger.propagate = False
    # The handler sorts out what is shown: it needs the stages even where nothing is said of them.
    logger.setLevel(logging.DEBUG)


def end_logging() -> None:
    """Take the line of progress off the terminal and leave the log as it was."""
    logger = logging.getLogger("indoorfit")
    for handler in list(logger.handlers):
        if isinstance(handler, TerminalHandler):
            handler.line.clear()
            logger.removeHandler(handler)
    logger.propagate = True
    logger.setLevel(logging.NOTSET)


def is_terminal(stream: Stream) -> bool:
    """Whether a person looks at it through something that can move its cursor."""
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def coloured(text: str, stream: Stream, colour: str = _RED) -> str:
    """The text in colour where the stream is a terminal and NO_COLOR (no-color.org) is not set."""
    return f"{colour}{text}{_RESET}" if is_terminal(stream) and not os.environ.get("NO_COLOR") else text


class TerminalHandler(logging.Handler):
    """Messages as lines, and the stage that is at work, or how far a batch is, as a line below them."""

    def __init__(self, stream: Stream, threshold: int, progress: bool) -> None:
        super().__init__(logging.DEBUG)
        self._stream = stream
        self._threshold = threshold
        self.line = ProgressLine(stream if progress else None)

    def emit(self, record: logging.LogRecord) -> None:
        """Show one message, or one step of the progress."""
        progress = getattr(record, "progress", None)
        if progress is not None:
            self.line.count(*progress)
            return
        stage = getattr(record, "stage", None)
        ended = hasattr(record, "seconds")
        # That a stage begins is the line's business alone.
        if record.levelno >= self._threshold and (stage is None or ended):
            text = record.getMessage()
            if record.levelno >= logging.WARNING:
                text = coloured(text, self._stream, _YELLOW)
            with self.line.aside():
                self._stream.write(text + "\n")
                self._stream.flush()
        if stage is not None:
            self.line.end() if ended else self.line.begin(stage)
