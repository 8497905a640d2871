"""What `indoorfit doctor` looks at."""

import math
import os
import re
import time
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

_REQUIREMENT = re.compile(
    r"(?P<name>[\w.-]+)(?:\[[^]]*\])?\s*(?P<range>[^;]*?)\s*(?:;.*extra == ['\"](?P<extra>[\w-]+)['\"])?$"
)
_FOR_DEVELOPERS = "dev"


@dataclass(frozen=True)
class Library:
    """One thing that indoorfit needs or can use."""

    name: str
    version: str | None
    """None where it is not installed."""
    needed: str
    """Version range that the package asks for."""
    extra: str
    """The extra that it belongs to; empty for what is always needed."""
    problem: str
    """Empty where all is well; a missing extra is no problem."""


@dataclass(frozen=True)
class CacheFacts:
    """A folder that fills up."""

    name: str
    place: str
    files: int
    bytes: int


@dataclass(frozen=True)
class SelfTest:
    """Whether a small room came out as it was built."""

    ok: bool
    message: str
    seconds: float


def libraries() -> list[Library]:
    """indoorfit itself and everything that its metadata names but what only developers need."""
    found = [Library("indoorfit", version("indoorfit"), "", "", "")]
    for line in requires("indoorfit") or ():
        matched = _REQUIREMENT.match(line)
        if matched is None or matched["extra"] == _FOR_DEVELOPERS:
            continue
        found.append(_library(matched["name"], matched["range"], matched["extra"] or ""))
    return found


def _library(name: str, needed: str, extra: str) -> Library:
    try:
        installed = version(name)
    except PackageNotFoundError:
        return Library(name, None, needed, extra, "" if extra else f"is needed; pip install '{name}{needed}'")
    problem = f"is too old, {needed} is needed; pip install -U {name}" if _is_older(installed, needed) else ""
    return Library(name, installed, needed, extra, problem)


def _is_older(installed: str, needed: str) -> bool:
    """Whether a version is below the bound of a range of the form ``>=1.2.3``."""
    bound = re.match(r">=([\d.]+)", needed)
    return bound is not None and _numbers(installed) < _numbers(bound[1])


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text)[:3])


def cache_facts() -> list[CacheFacts]:
    """The caches that a run fills, with their sizes."""
    place = Path(os.environ["JAX_COMPILATION_CACHE_DIR"])
    files = [path for path in place.rglob("*") if path.is_file()] if place.is_dir() else []
    return [
        CacheFacts("compiled programs (jax)", str(place), len(files), sum(f.stat().st_size for f in files))
    ]


def self_test() -> SelfTest:
    """Simulate a scan of the thesis' room, fit it and compare every length with the truth."""
    start = time.perf_counter()
    try:
        message, ok = _fit_known_room()
    except Exception as error:
        # Whatever goes wrong here is the finding, not a reason to stop.
        message, ok = f"{type(error).__name__}: {error}", False
    return SelfTest(ok, message, round(time.perf_counter() - start, 2))


def _fit_known_room() -> tuple[str, bool]:
    import numpy as np

    from indoorfit.pipeline import fit_scan
    from indoorfit.simulate import SamplingSettings, room_shape, sample_surface

    # Points of 5 mm noise on faces of 0.9 m² and more: each plane is good to half a millimetre.
    settings = SamplingSettings(n_points=12_000, sigma_m=0.005, yaw_rad=0.4, tilt_rad=0.05)
    truth_m = np.sort([5.08, 3.20, 2.70, 5.08, 4.75, 3.20, 1.70, 1.50, 0.33])
    virtual = sample_surface(room_shape("L"), settings, np.random.default_rng(0), name="self-test")
    found_m = np.sort([dimension.quantity.value for dimension in fit_scan(virtual.scan).dimensions])
    if len(found_m) != len(truth_m):
        return f"{len(found_m)} lengths instead of {len(truth_m)} in a simulated room", False
    worst_mm = 1e3 * float(np.abs(found_m - truth_m).max())
    ok = math.isfinite(worst_mm) and worst_mm < 3.0
    return f"{len(truth_m)} lengths of a simulated room, the worst {worst_mm:.2f} mm off (limit 3 mm)", ok
