"""Stages of a run as they begin and end, and the state of a batch, told to the log. Imports nothing heavy."""

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager

STAGES = (
    "read",
    "thin",
    "orient",
    "segment",
    "discover",
    "fit",
    "frames",
    "intervals",
    "solid",
    "honesty",
    "texture",
    "write",
)
"""In their order; a run may leave some out, and comes back to the intervals once."""

log = logging.getLogger("indoorfit")


@contextmanager
def announced(name: str) -> Iterator[None]:
    """Log at debug level that a stage begins and how long it took.

    The records carry `stage` and, at the end, `seconds` as attributes, for a display of progress.
    """
    log.debug("%s ...", name, extra={"stage": name})
    start = time.perf_counter()
    yield
    seconds = time.perf_counter() - start
    log.debug("%s took %.2f s", name, seconds, extra={"stage": name, "seconds": seconds})


def counted(done: int, total: int) -> None:
    """Log at debug level that so many fits of a batch are done.

    The record carries both numbers as `progress`, for a display of it.
    """
    log.debug("%d of %d fits", done, total, extra={"progress": (done, total)})
