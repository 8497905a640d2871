"""Where a result came from and how long each stage took."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any

from indoorfit.config import RunConfig, config_to_dict
from indoorfit.model import Scan


class Stopwatch:
    """Wall-clock seconds per stage."""

    def __init__(self) -> None:
        self.timings_s: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside the block."""
        start = time.perf_counter()
        yield
        self.timings_s[name] = self.timings_s.get(name, 0.0) + time.perf_counter() - start


def package_version() -> str:
    """The installed version."""
    return version("indoorfit")


def provenance(scan: Scan, config: RunConfig, watch: Stopwatch) -> dict[str, Any]:
    """The contract's provenance block; timings are the only part that differs between equal runs."""
    return {
        "version": package_version(),
        "input": {
            "name": scan.name,
            "sha256": scan.sha256,
            "points": scan.n_points,
            "unit": scan.unit,
        },
        "config": config_to_dict(config),
        "seed": config.seed,
        "timings_s": timings_s(watch),
    }


def timings_s(watch: Stopwatch) -> dict[str, float]:
    """Seconds of every stage so far, to a tenth of a millisecond."""
    return {name: round(seconds, 4) for name, seconds in watch.timings_s.items()}
