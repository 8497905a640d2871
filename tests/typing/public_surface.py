"""Every public name as a caller writes it; checked by pyright in strict mode, never run."""

# pyright: strict

from pathlib import Path

import numpy as np

import indoorfit


def use_everything(path: Path) -> float:
    """A program that uses the whole public surface."""
    scan: indoorfit.Scan = indoorfit.read(path, unit="m")
    config: indoorfit.RunConfig = indoorfit.load_config("settings.toml")
    try:
        model: indoorfit.RoomModel = indoorfit.fit(scan, config)
    except (indoorfit.InputError, indoorfit.ConfigError, indoorfit.SamplingError) as error:
        raise RuntimeError(str(error)) from error
    model = indoorfit.fit(np.zeros((100, 3)), indoorfit.RunConfig(level=0.9, method="greedy"))
    model = indoorfit.fit([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    total = 0.0
    for dimension in model.at_level(0.8).dimensions:
        quantity = dimension.quantity
        interval = model.interval(dimension.id, 0.99)
        total += quantity.value + quantity.std + quantity.interval.low + interval.high
        total += float(dimension.from_m[0]) + len(dimension.faces)
        total += 0.0 if quantity.budget is None else quantity.budget.data_std
    for room in model.rooms:
        total += room.floor_area.value + room.volume.std + room.perimeter.interval.high
    for face in model.faces:
        total += face.coverage + float(face.normal @ face.rings_m[0][0]) + face.n_points
    words: list[str] = [f"{note.code}: {note.message}" for note in model.warnings]
    checked = model.check("tape.csv")
    if checked.result.tape is not None:
        total += sum(check.e_n or 0.0 for check in checked.result.tape.checks)
    try:
        checked.write("out", overwrite=True, formats=("ifc", "dxf"))
        names: tuple[str, ...] = checked.write_figures("figures", formats=("svg", "pdf"))
    except indoorfit.OutputError as error:
        raise SystemExit(str(error)) from error
    except indoorfit.IndoorfitError:
        raise
    return total + len(words) + len(names) + len(repr(model))
