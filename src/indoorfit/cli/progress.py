"""One line on a terminal: how far the run is, what is at work, and for how long."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, runtime_checkable

from indoorfit.stages import STAGES

_WIDTH = 20
_TICK_S = 0.2
_CLEAR = "\r\x1b[2K"


@runtime_checkable
class Stream(Protocol):
    """What is asked of standard error, whatever has taken its place."""

    def write(self, text: str, /) -> int: ...

    def flush(self) -> None: ...

    def isatty(self) -> bool: ...


class ProgressLine:
    """Redraws itself while a stage works; without a stream it does nothing."""

    def __init__(self, stream: Stream | None) -> None:
        self._stream = stream
        self._lock = threading.RLock()
        self._stage: str | None = None
        self._share = 0.0
        self._start_s = time.perf_counter()
        self._stage_start_s: float | None = None
        self._stopped = threading.Event()
        self._ticker: threading.Thread | None = None

    def begin(self, stage: str) -> None:
        """A stage is at work from now on."""
        if self._stream is None:
            return
        with self._lock:
            self._stage, self._stage_start_s = stage, time.perf_counter()
            if stage in STAGES:
                # Stages that come back take nothing off the bar.
                self._share = max(self._share, STAGES.index(stage) / len(STAGES))
            self._show()

    def count(self, done: int, total: int) -> None:
        """So many fits of a batch are done; after the last one the line is gone."""
        if done >= total:
            self.clear()
        elif self._stream is not None:
            with self._lock:
                self._stage, self._stage_start_s = f"{done} of {total} fits", None
                self._share = done / total
                self._show()

    def end(self) -> None:
        """The stage is done; until the next one begins the line is empty, and after the last one gone."""
        if self._stage == STAGES[-1]:
            self.clear()
        elif self._stream is not None and self._stage is not None:
            # Not every command ends with the last stage, and its output goes to the same terminal.
            with self._lock:
                self._stage = None
                self._stream.write(_CLEAR)
                self._stream.flush()

    def clear(self) -> None:
        """Take the line away and stop."""
        if self._stream is None or self._ticker is None:
            return
        self._stopped.set()
        self._ticker.join()
        with self._lock:
            self._ticker, self._stage, self._share = None, None, 0.0
            self._stream.write(_CLEAR)
            self._stream.flush()

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Room for other lines, above this one."""
        with self._lock:
            if self._stream is not None and self._ticker is not None:
                self._stream.write(_CLEAR)
            yield
            if self._ticker is not None:
                self._draw()

    def _show(self) -> None:
        self._draw()
        if self._ticker is None:
            self._stopped.clear()
            self._ticker = threading.Thread(target=self._tick, daemon=True)
            self._ticker.start()

    def _tick(self) -> None:
        while not self._stopped.wait(_TICK_S):
            with self._lock:
                self._draw()

    def _draw(self) -> None:
        if self._stream is None or self._stage is None:
            return
        now_s = time.perf_counter()
        full = round(_WIDTH * self._share)
        bar = "#" * full + "." * (_WIDTH - full)
        spent = "" if self._stage_start_s is None else f" {now_s - self._stage_start_s:.1f} s"
        self._stream.write(f"{_CLEAR}[{bar}] {self._stage}{spent} ({now_s - self._start_s:.1f} s in all)")
        self._stream.flush()
