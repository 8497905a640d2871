"""What is written: all of it or nothing, the same every time, and in agreement with itself."""

import csv
import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
import trimesh

from indoorfit.config import RunConfig, config_to_dict
from indoorfit.errors import OutputError
from indoorfit.fitting import AssociationConfig
from indoorfit.io import SCHEMA_PATH, read_model_json
from indoorfit.model import IgnoredBox, OverrideConfig
from indoorfit.pipeline import fit_scan, outputs, write_outputs
from indoorfit.report import residuals_of
from synthetic import virtual

FILES = {
    "model.json", "model.glb", "model.wrl", "model.obj", "model.mtl", "dimensions.csv",
    "plan.svg", "plan.png", "view.png", "report.html",
}  # fmt: skip


@pytest.fixture(scope="module")
def fitted():
    scan = virtual(
        "L", 1, coloured=True, n_points=30_000, yaw_deg=10, tilt_deg=2, translation_m=(4e5, 5e6, 30.0)
    ).scan
    return scan, fit_scan(scan)


@pytest.fixture
def written(fitted, tmp_path):
    scan, result = fitted
    write_outputs(result, tmp_path / "out", scan, overwrite=False)
    return tmp_path / "out", result


def test_all_files_of_the_contract_are_written_and_no_others(written):
    out, _ = written
    assert {path.name for path in out.iterdir()} >= FILES
    assert [path.name for path in out.parent.iterdir()] == ["out"]
    assert all(path.stat().st_size > 0 for path in out.rglob("*") if path.is_file())


def test_model_json_keeps_to_its_schema_and_reads_back(written):
    out, result = written
    document = json.loads((out / "model.json").read_text(encoding="utf-8"))
    jsonschema.validate(document, json.loads(SCHEMA_PATH.read_text(encoding="utf-8")))
    again = read_model_json(out / "model.json")
    assert again.shape == result.shape
    assert [d.quantity for d in again.dimensions] == [d.quantity for d in result.dimensions]


def test_table_says_what_the_model_says(written):
    out, result = written
    rows = list(csv.DictReader((out / "dimensions.csv").read_text(encoding="utf-8").splitlines()))
    lengths = {row["id"]: row for row in rows}
    for dimension in result.dimensions:
        values = [float(value) for value in lengths[dimension.id].values() if _is_number(value)]
        # A tenth of a millimetre is the least that a table may round to.
        assert np.min(np.abs(np.array(values) - dimension.quantity.value)) < 1e-4


def _is_number(text: str) -> bool:
    try:
        float(text)
    except (TypeError, ValueError):
        return False
    return True


def test_glb_is_a_closed_mesh_of_the_rooms_volume(written):
    out, result = written
    scene = trimesh.load(out / "model.glb")
    merged = scene.to_geometry() if hasattr(scene, "to_geometry") else scene.dump(concatenate=True)
    merged.merge_vertices(merge_tex=True, merge_norm=True)
    assert merged.is_watertight
    # Inward, in single precision about a local origin: 1e-6 of 43 m3 and more.
    assert -merged.volume == pytest.approx(result.rooms[0].volume.value, abs=1e-3)


def test_writing_twice_gives_the_same_bytes(fitted, tmp_path):
    scan, result = fitted
    for name in ("a", "b"):
        write_outputs(result, tmp_path / name, scan, overwrite=False)
    for path in sorted((tmp_path / "a").rglob("*")):
        if path.is_file():
            assert path.read_bytes() == (tmp_path / "b" / path.relative_to(tmp_path / "a")).read_bytes(), (
                path.name
            )


def test_an_earlier_result_is_kept_without_overwrite_and_replaced_with_it(written, fitted):
    out, result = written
    before = files(out)
    with pytest.raises(OutputError, match="exists already"):
        write_outputs(result, out, fitted[0], overwrite=False)
    assert files(out) == before
    write_outputs(replace(result, level=0.5), out, fitted[0], overwrite=True)
    assert json.loads((out / "model.json").read_text(encoding="utf-8"))["level"] == 0.5
    assert [path.name for path in out.parent.iterdir()] == ["out"]


def files(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("broken", ["write_glb", "write_dimensions_csv", "plan_picture", "report_html"])
def test_a_writer_that_fails_leaves_nothing_behind(fitted, tmp_path, monkeypatch, broken):
    def fails(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(outputs, broken, fails)
    with pytest.raises(OutputError, match="No space left"):
        write_outputs(fitted[1], tmp_path / "deep" / "out", fitted[0], overwrite=False)
    assert list(tmp_path.iterdir()) == []


def test_without_a_scan_the_plan_is_drawn_all_the_same(fitted, tmp_path):
    write_outputs(fitted[1], tmp_path / "out", None, overwrite=False)
    assert (tmp_path / "out" / "plan.svg").read_text(encoding="utf-8").startswith(("<svg", "<?xml"))


def test_the_report_is_written_as_pdf_where_it_is_wanted(fitted, tmp_path):
    write_outputs(fitted[1], tmp_path / "out", fitted[0], overwrite=False, pdf=True)
    assert (tmp_path / "out" / "report.pdf").read_bytes().startswith(b"%PDF-")


def test_the_report_speaks_of_the_points_that_the_fit_used(tmp_path):
    scan = virtual("box", 1, n_points=8000).scan
    association = AssociationConfig(edge_m=0.4)
    config = RunConfig(joint=replace(RunConfig().joint, association=association))
    result = fit_scan(scan, config)
    used, more = (residuals_of(result, scan.points_m, a).n_points for a in (association, None))
    assert used < 0.9 * more
    write_outputs(result, tmp_path / "out", scan, overwrite=False)
    assert f"Distances of {used} points" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_what_was_ignored_is_in_no_picture(fitted):
    scan, result = fitted
    middle_m = scan.points_m.mean(axis=0)
    box = IgnoredBox(tuple(middle_m.tolist()), tuple(scan.points_m.max(axis=0).tolist()))
    config = RunConfig(overrides=OverrideConfig(ignore_box=(box,)))
    told = replace(result, provenance={**result.provenance, "config": config_to_dict(config)})
    kept_m = outputs.as_fitted(scan, told).points_m
    inside = np.all((scan.points_m >= box.low_m) & (scan.points_m <= box.high_m), axis=1)
    assert inside.any()
    np.testing.assert_array_equal(kept_m, scan.points_m[~inside])
    np.testing.assert_array_equal(outputs.as_fitted(scan, result).points_m, scan.points_m)
