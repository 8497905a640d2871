"""The Python API is the command line in a few lines."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import indoorfit
from indoorfit.io import write_ply
from synthetic import virtual


@pytest.fixture(scope="module")
def virtual_box():
    return virtual("box", 1, n_points=20_000)


def test_read_fit_dimensions_write(virtual_box, tmp_path):
    write_ply(tmp_path / "room.ply", virtual_box.scan)
    scan = indoorfit.read(tmp_path / "room.ply")
    result = indoorfit.fit(scan)
    values = sorted(d.quantity.value for d in result.dimensions[:3])
    # 20 000 points of 5 mm on six faces: far below a millimetre.
    assert values == pytest.approx([2.7, 4.0, 5.0], abs=0.001)
    result.write(tmp_path / "out")
    document = json.loads((tmp_path / "out" / "model.json").read_text(encoding="utf-8"))
    assert [d["value"] for d in document["dimensions"]] == [d.quantity.value for d in result.dimensions]
    with pytest.raises(indoorfit.OutputError):
        result.write(tmp_path / "out")
    result.write(tmp_path / "out", overwrite=True)


def test_an_array_is_a_scan(virtual_box):
    from_array = indoorfit.fit(virtual_box.scan.points_m)
    from_scan = indoorfit.fit(virtual_box.scan)
    assert [d.quantity.value for d in from_array.dimensions] == [
        d.quantity.value for d in from_scan.dimensions
    ]


def test_a_cloud_of_another_library_is_a_scan(virtual_box):
    """trimesh keeps its points as `vertices`, colours with alpha; Open3D's are 0.0 to 1.0."""
    import trimesh

    from indoorfit.io import as_scan

    points_m, grey = virtual_box.scan.points_m, np.full((virtual_box.scan.n_points, 4), 51, np.uint8)
    scan = as_scan(trimesh.PointCloud(points_m, colors=grey))
    np.testing.assert_array_equal(scan.points_m, points_m)
    np.testing.assert_array_equal(scan.colours, grey[:, :3])
    assert as_scan(trimesh.PointCloud(points_m)).colours is None
    assert as_scan(virtual_box.scan) is virtual_box.scan
    expected = indoorfit.fit(points_m).dimensions[0].quantity
    assert indoorfit.fit(trimesh.PointCloud(points_m)).dimensions[0].quantity == expected


class LikeOpen3D:
    """The attributes of open3d.geometry.PointCloud that are asked for."""

    def __init__(self, points, colors=()):
        self.points, self.colors = list(map(tuple, points)), np.asarray(colors).reshape(-1, 3)


@pytest.mark.parametrize("colours", [False, True], ids=["bare", "coloured"])
def test_a_cloud_with_points_and_colors_is_a_scan(virtual_box, colours):
    from indoorfit.io import as_scan

    points_m = virtual_box.scan.points_m[:500]
    scan = as_scan(LikeOpen3D(points_m, np.full((500, 3), 0.2) if colours else ()))
    np.testing.assert_array_equal(scan.points_m, points_m)
    assert (scan.colours is None) != colours
    if scan.colours is not None:
        assert np.all(scan.colours == 51)


def test_clouds_of_open3d_are_scans(virtual_box):
    open3d = pytest.importorskip("open3d", reason="Open3D is not installed")
    from indoorfit.io import as_scan

    points_m, half = virtual_box.scan.points_m, np.full((virtual_box.scan.n_points, 3), 0.2)
    old = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points_m))
    new = open3d.t.geometry.PointCloud(open3d.core.Tensor(points_m))
    for cloud in (old, new):
        scan = as_scan(cloud)
        np.testing.assert_array_equal(scan.points_m, points_m)
        assert scan.colours is None
    old.colors = open3d.utility.Vector3dVector(half)
    new.point.colors = open3d.core.Tensor(half)
    for cloud in (old, new):
        colours = as_scan(cloud).colours
        assert colours is not None
        assert np.all(colours == 51)


def test_a_file_name_is_no_cloud():
    with pytest.raises(indoorfit.InputError, match="Fix: pass an array"):
        indoorfit.fit("room.ply")


def test_a_model_cannot_be_changed(virtual_box):
    import dataclasses

    model = indoorfit.fit(virtual_box.scan)
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.result = None  # pyright: ignore
    for array in (model.faces[0].rings_m[0], model.dimensions[0].from_m, model.result.meshes[0].vertices_m):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_arrays_are_frozen_in_any_kind_of_mapping():
    from types import MappingProxyType

    from indoorfit.model import frozen

    inner = np.zeros(3)
    frozen(MappingProxyType({"a": [inner]}))
    assert not inner.flags.writeable


def test_input_is_not_changed(virtual_box):
    before = virtual_box.scan.points_m.copy()
    indoorfit.fit(virtual_box.scan)
    indoorfit.fit(virtual_box.scan.points_m)
    np.testing.assert_array_equal(virtual_box.scan.points_m, before)


def test_the_model_shows_itself(virtual_box):
    model = indoorfit.fit(virtual_box.scan)
    assert "overall" in repr(model)
    html = model._repr_html_()
    assert "<svg" in html
    assert html.count("<tr>") == 1 + len(model.dimensions)
    assert len(model.rooms) == 1
    assert len(model.faces) == 6
    assert model.warnings == ()


def test_any_level_without_another_fit(virtual_box):
    model = indoorfit.fit(virtual_box.scan)
    stated = model.dimensions[0].quantity.interval
    assert model.interval("A", 0.95) == stated
    wide, narrow = model.interval("A", 0.999), model.interval("A", 0.3)
    assert wide.low < stated.low < narrow.low < narrow.high < stated.high < wide.high
    assert model.interval("room-1.volume", 0.95) == model.rooms[0].volume.interval
    assert model.at_level(0.3).dimensions[0].quantity.interval == narrow
    with pytest.raises(indoorfit.ConfigError, match=r"'Q'.*room-1\.floor_area"):
        model.interval("Q", 0.9)
    with pytest.raises(indoorfit.ConfigError, match="between 0 and 1"):
        model.interval("A", 95.0)


@pytest.mark.parametrize(
    "points",
    [np.zeros((3, 3)), np.zeros((100, 2)), np.full((100, 3), np.nan), np.zeros((0, 3))],
    ids=["three", "flat", "nan", "none"],
)
def test_bad_arrays_are_input_errors(points):
    with pytest.raises(indoorfit.InputError, match="Fix:"):
        indoorfit.fit(points)


def test_settings_are_taken(virtual_box):
    model = indoorfit.fit(virtual_box.scan, indoorfit.RunConfig(level=0.8))
    assert {d.quantity.interval.level for d in model.dimensions} == {0.8}


def test_all_public_names_exist_and_others_do_not():
    for name in indoorfit.__all__:
        assert getattr(indoorfit, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = indoorfit.no_such_name
    assert dir(indoorfit) == sorted(indoorfit.__all__)
    assert (Path(indoorfit.__file__).parent / "py.typed").is_file()


def in_fresh_process(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_the_package_loads_no_numerics():
    heavy = ("jax", "numpy", "scipy", "optimistix")
    code = f"import sys, indoorfit; print([m for m in {heavy} if m in sys.modules])"
    assert in_fresh_process(code).strip() == "[]"


def test_the_hosts_jax_settings_are_left_alone():
    code = (
        "import numpy as np, jax, indoorfit\n"
        "from indoorfit.simulate import *\n"
        "v = sample_surface(room_shape('box'), SamplingSettings(n_points=5000), np.random.default_rng(0))\n"
        "indoorfit.fit(v.scan)\n"
        "print(jax.config.jax_enable_x64, jax.numpy.zeros(1).dtype)"
    )
    assert in_fresh_process(code).split() == ["False", "float32"]


def test_the_name_fit_is_the_function_whatever_was_imported_before():
    code = "import indoorfit.fitting, indoorfit; from indoorfit import fit; print(callable(fit))"
    assert in_fresh_process(code).strip() == "True"
