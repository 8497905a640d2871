"""A worker process: takes one job at a time from a pipe and sends its row back."""

import os
import threading
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path

from .task import run_task

EXIT_MEMORY = 77
"""Exit code of a worker that ended itself because it held more memory than it may."""

_POLL_S = 0.1


def serve(pipe: Connection, memory_bytes: int | None) -> None:
    """Work until the other end of the pipe closes.

    Args:
        pipe: jobs come in, (row, timing) go out.
        memory_bytes: most resident memory; None for no limit.
    """
    threading.Thread(target=_watch, args=(memory_bytes,), daemon=True).start()
    while True:
        try:
            job = pipe.recv()
        except EOFError:
            return
        pipe.send(run_task(job))


def _watch(memory_bytes: int | None) -> None:
    """End this process when its parent is gone, however that died, or when it holds too much memory.

    Resident memory and not the address space is limited: numerics map far more than they ever touch.
    """
    parent = parent_process()
    while parent is not None:
        if wait([parent.sentinel], timeout=_POLL_S if memory_bytes else None):
            os._exit(1)
        if memory_bytes and resident_bytes() > memory_bytes:
            os._exit(EXIT_MEMORY)


def resident_bytes() -> int:
    """Resident memory of this process; 0 where the system has no /proc and nothing can be said."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")
