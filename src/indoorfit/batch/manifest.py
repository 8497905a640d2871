"""The manifest of a batch: which scans, which configurations, which readings."""

import csv
import dataclasses
import hashlib
import io
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from indoorfit.config import RunConfig, config_from_dict, structured
from indoorfit.errors import ConfigError, InputError
from indoorfit.io import Unit, frames_path, printable_name, read_tape
from indoorfit.model import RefusedRow, TapeTable

from .jobs import Job, ScanFile, Simulation
from .published import PublishedLength, read_published

_HINT = "see docs/batch.md."


@dataclass(frozen=True)
class ScanEntry:
    """One scan of a manifest; paths are relative to the manifest."""

    file: str
    name: str | None = None
    """By default the file's name without its suffix."""
    unit: Unit = "m"
    sensor: str = "unknown"
    """Any word; tables are split by it."""
    room: str | None = None
    """The physical room, where several scans show the same; by default the name."""
    tape: str | None = None
    truth: str | None = None
    configs: list[str] | None = None
    """Names of the configurations to run; by default all."""


@dataclass(frozen=True)
class SimulateEntry:
    """Simulated rooms of one kind."""

    name: str
    rooms: int
    simulation: Simulation
    configs: list[str] | None = None


@dataclass(frozen=True)
class PublishedEntry:
    """Lengths that someone published with their references; nothing is fitted."""

    name: str
    file: str
    config: str = "published"
    sensor: str = "unknown"


@dataclass(frozen=True)
class Study:
    """A manifest, read and checked: all that a run needs."""

    name: str
    sha256: str
    jobs: tuple[Job, ...]
    """In the order of the manifest; tables follow it."""
    published: tuple[PublishedLength, ...] = ()
    refused: tuple[tuple[str, RefusedRow], ...] = ()
    """Rows of tape tables that are wrong or name no scan of the manifest, with the table's name."""


@dataclass
class _Reader:
    folder: Path
    name: str
    configs: dict[str, RunConfig]
    models: Path | None
    common: TapeTable | None = None
    jobs: list[Job] = field(default_factory=list)
    refused: dict[tuple[str, int], RefusedRow] = field(default_factory=dict)
    claimed: set[int] = field(default_factory=set)


def read_manifest(path: str | Path, models: Path | None = None) -> Study:
    """Read a manifest (TOML, or CSV with one scan per row) and look at every file that it names.

    Args:
        path: relative paths in it start at its folder.
        models: directory for the whole model of every scan; None keeps the numbers only.

    Raises:
        InputError: the manifest or a file of it cannot be read.
        ConfigError: an unknown key, a wrong value, a name twice, or no scan at all.
    """
    path = Path(path)
    name = printable_name(path.name)
    try:
        content = path.read_bytes()
        text = content.decode("utf-8-sig")
        document = tomllib.loads(text) if path.suffix.lower() == ".toml" else _csv_document(text, name)
    except OSError as e:
        raise InputError(f"{name}: cannot be read: {e.strerror}. Fix: check the path.") from e
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError, csv.Error) as e:
        raise InputError(f"{name}: is no manifest: {e}. Fix: {_HINT}") from e
    unknown = [k for k in document if k not in ("tape", "config", "scan", "simulate", "published")]
    if unknown:
        raise ConfigError(
            f"{name}: found the key {unknown[0][:40]!r}; needed are tape, [config.NAME], [[scan]], "
            f"[[simulate]] and [[published]]. Fix: {_HINT}"
        )
    reader = _Reader(path.parent, name, _configs(document, path.parent, name), models)
    if document.get("tape") is not None:
        reader.common = read_tape(path.parent / _text(document["tape"], f"{name}: tape"))
        _refuse(reader, reader.common)
    for where, entry in _entries(document, "scan", name):
        _add_scan(reader, structured(entry, ScanEntry, where, _HINT))
    for where, entry in _entries(document, "simulate", name):
        _add_simulated(reader, _simulate_entry(entry, where))
    published: list[PublishedLength] = []
    for where, entry in _entries(document, "published", name):
        item = structured(entry, PublishedEntry, where, _HINT)
        published += read_published(path.parent / item.file, item.name, item.config, item.sensor)
    _check(reader, published)
    _refuse_unclaimed(reader)
    refused = tuple((key[0], row) for key, row in sorted(reader.refused.items()))
    return Study(name, hashlib.sha256(content).hexdigest(), tuple(reader.jobs), tuple(published), refused)


def _csv_document(text: str, name: str) -> dict[str, Any]:
    """One scan per row; columns are the keys of [[scan]], configurations separated by blanks."""
    first = text.partition("\n")[0]
    delimiter = next((mark for mark in ";\t" if mark in first), ",")
    rows = csv.DictReader(io.StringIO(text), delimiter=delimiter, strict=True)
    scans: list[dict[str, Any]] = []
    for row in rows:
        if None in row or None in row.values():
            raise InputError(
                f"{name}, line {rows.line_num}: the row and the header have different numbers of values. "
                "Fix: repair the line."
            )
        entry: dict[str, Any] = {k.strip(): v.strip() for k, v in row.items() if v.strip()}
        if "configs" in entry:
            entry["configs"] = entry["configs"].split()
        if entry:
            scans.append(entry)
    return {"scan": scans}


def _entries(document: dict[str, Any], key: str, name: str) -> Iterable[tuple[str, dict[str, Any]]]:
    entries = document.get(key, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ConfigError(f"{name}: {key} must be written as tables [[{key}]]. Fix: {_HINT}")
    return [(f"{name}: {key} {k}", entry) for k, entry in enumerate(entries, start=1)]


def _configs(document: dict[str, Any], folder: Path, name: str) -> dict[str, RunConfig]:
    """Named settings: those of a file, if one is named, and over them those written here."""
    tables = document.get("config", {"joint": {}})
    if not isinstance(tables, dict) or not all(isinstance(table, dict) for table in tables.values()):
        raise ConfigError(f"{name}: config must be written as tables [config.NAME]. Fix: {_HINT}")
    found = {}
    for key, table in tables.items():
        settings = {k: v for k, v in table.items() if k != "file"}
        if "file" in table:
            settings = _merged(
                _toml_of(folder / _text(table["file"], f"{name}: config.{key}.file")), settings
            )
        found[key] = config_from_dict(settings, f"{name}: config.{key}")
    if not found:
        raise ConfigError(f"{name}: has no configuration. Fix: leave [config] out, or add [config.joint].")
    return found


def _toml_of(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as e:
        raise ConfigError(f"{printable_name(path.name)}: cannot be read as TOML ({e}). Fix: check it.") from e


def _merged(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in over.items():
        below = merged.get(key)
        if isinstance(value, dict) and isinstance(below, dict):
            value = _merged(below, value)
        merged[key] = value
    return merged


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise ConfigError(f"{where}: got {str(value)[:40]!r}; the name of a file is needed. Fix: {_HINT}")
    return value


def _add_scan(reader: _Reader, entry: ScanEntry) -> None:
    path = (reader.folder / entry.file).resolve()
    name = entry.name or printable_name(path.stem)
    sidecar = frames_path(path)
    source = ScanFile(
        path=str(path),
        sha256=_digest(path),
        frames_sha256=_digest(sidecar) if sidecar.is_file() else None,
        unit=entry.unit,
        truth=None if entry.truth is None else str((reader.folder / entry.truth).resolve()),
        truth_sha256=None if entry.truth is None else _digest(reader.folder / entry.truth),
    )
    tape = _tape_of(reader, entry, name, printable_name(path.name))
    room = entry.room or name
    for key in _wanted(reader, entry.configs, name):
        model = (
            None if reader.models is None else str(reader.models / f"{_file_name(name)}.{_file_name(key)}")
        )
        config = reader.configs[key]
        reader.jobs.append(Job(name, room, entry.sensor, key, config, source, tape, model))


def _tape_of(reader: _Reader, entry: ScanEntry, name: str, file_name: str) -> TapeTable | None:
    """The scan's own table, and its rows of the common one; refused rows are kept for the batch."""
    tables = []
    if entry.tape is not None:
        own = read_tape(reader.folder / entry.tape)
        _refuse(reader, own)
        tables.append(own)
    if reader.common is not None:
        names = {name, file_name, file_name.rpartition(".")[0] or file_name}
        rows = tuple(r for r in reader.common.readings if r.scan in names)
        reader.claimed |= {row.line for row in rows}
        if rows:
            # The names by which tables know a scan differ; here they all mean this one.
            rows = tuple(dataclasses.replace(row, scan=None) for row in rows)
            tables.append(dataclasses.replace(reader.common, readings=rows, refused=()))
    if not tables:
        return None
    if len(tables) > 1:
        raise ConfigError(
            f"{reader.name}: the scan {name!r} has readings in {tables[0].name} and in {tables[1].name}. "
            "Fix: put them into one table."
        )
    return dataclasses.replace(tables[0], refused=())


def _refuse(reader: _Reader, table: TapeTable) -> None:
    reader.refused.update({(table.name, row.line): row for row in table.refused})


def _refuse_unclaimed(reader: _Reader) -> None:
    for reading in reader.common.readings if reader.common is not None else ():
        if reading.line not in reader.claimed:
            said = "no scan" if reading.scan is None else f"the scan {reading.scan[:80]!r}"
            row = RefusedRow(reading.line, f"names {said}; the manifest has none of that name")
            assert reader.common is not None
            reader.refused[reader.common.name, reading.line] = row


def _simulate_entry(entry: dict[str, Any], where: str) -> SimulateEntry:
    own = {"name": entry.get("name"), "rooms": entry.get("rooms"), "configs": entry.get("configs")}
    rest = {k: v for k, v in entry.items() if k not in own}
    own = {k: v for k, v in own.items() if v is not None}
    return structured({**own, "simulation": {"seed": 0, **rest}}, SimulateEntry, where, _HINT)


def _add_simulated(reader: _Reader, entry: SimulateEntry) -> None:
    if entry.rooms < 1:
        raise ConfigError(f"{reader.name}: simulate {entry.name}: rooms must be 1 or more. Fix: {_HINT}")
    for k in range(entry.rooms):
        simulation = dataclasses.replace(entry.simulation, seed=entry.simulation.seed + k)
        name = f"{entry.name}-{simulation.seed}"
        sensor = simulation.sensor or "even"
        for key in _wanted(reader, entry.configs, name):
            folder = reader.models
            model = None if folder is None else str(folder / f"{_file_name(name)}.{_file_name(key)}")
            reader.jobs.append(Job(name, name, sensor, key, reader.configs[key], simulation, None, model))


def _wanted(reader: _Reader, configs: list[str] | None, name: str) -> list[str]:
    for key in configs or ():
        if key not in reader.configs:
            raise ConfigError(
                f"{reader.name}: {name} asks for the configuration {key[:40]!r}; there are "
                f"{', '.join(reader.configs)}. Fix: add [config.{key[:40]}]."
            )
    return list(reader.configs) if configs is None else configs


def _file_name(name: str) -> str:
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name)


def _digest(path: Path) -> str:
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as e:
        raise InputError(
            f"{printable_name(str(path))}: cannot be read: {e.strerror}. Fix: correct the path in the "
            "manifest; relative paths start at its folder."
        ) from e


def _check(reader: _Reader, published: list[PublishedLength]) -> None:
    if not reader.jobs and not published:
        raise ConfigError(
            f"{reader.name}: names no scan. Fix: add [[scan]] with a file. {_HINT.capitalize()}"
        )
    seen: set[tuple[str, str]] = set()
    folders: dict[str, tuple[str, str]] = {}
    for job in reader.jobs:
        both = (job.name, job.config_name)
        if both in seen:
            raise ConfigError(
                f"{reader.name}: the scan {job.name!r} comes twice with the configuration "
                f"{job.config_name!r}. Fix: give each scan a name of its own."
            )
        seen.add(both)
        other = folders.setdefault(job.model_dir, both) if job.model_dir is not None else both
        if other != both:
            raise ConfigError(
                f"{reader.name}: the models of {' with '.join(other)} and of {' with '.join(both)} would lie "
                f"in one folder, {Path(str(job.model_dir)).name}. Fix: give one of them another name."
            )
