"""The benchmarks' judge tells right models from wrong ones."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from indoorfit.model import Frame, Shape
from indoorfit.pipeline import truth_result
from indoorfit.simulate import room_shape, scan_frame

SHIFT_M = 0.004


@pytest.fixture(scope="module")
def matching():
    path = Path(__file__).resolve().parents[1] / "benchmarks" / "matching.py"
    spec = importlib.util.spec_from_file_location("matching", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look their module up by name.
    sys.modules["matching"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["matching"]


def exact(shape: Shape, frame: Frame | None = None):
    return truth_result(
        shape, scan_frame(0.4, 0.05, 1.0, (10.0, 20.0, 0.0)) if frame is None else frame, {}, 0
    )


@pytest.mark.parametrize("kind", ["box", "L", "U", "X", "T", "Z", "stair"])
def test_a_model_agrees_with_itself(matching, kind):
    truth = exact(room_shape(kind))
    comparison = matching.compare(truth, truth)
    assert comparison.right
    assert comparison.watertight
    assert comparison.hits.all()
    # Rounding only.
    np.testing.assert_allclose(comparison.errors_m, 0.0, atol=1e-12)


def test_a_moved_wall_shows_in_its_lengths_alone(matching):
    shape = room_shape("L")
    moved = shape.offsets_m.copy()
    wall = next(k for k, plane in enumerate(shape.planes) if plane.face_class == "right")
    moved[wall] += SHIFT_M
    comparison = matching.compare(exact(shape), exact(shape.with_offsets(moved)))
    assert comparison.right
    changed = np.abs(comparison.errors_m) > 0.5 * SHIFT_M
    assert 1 <= changed.sum() < len(changed)
    # A length is a difference of two offsets; the rest is rounding.
    np.testing.assert_allclose(np.abs(comparison.errors_m[changed]), SHIFT_M, atol=1e-12)
    assert not comparison.hits[changed].any()


@pytest.mark.parametrize(
    ("true", "found"), [("L", "box"), ("box", "L")], ids=["missing-notch", "extra-notch"]
)
def test_a_wrong_structure_is_told(matching, true, found):
    shapes = {
        kind: room_shape(kind, length_m=5.0, width_m=4.0, notch_length_m=n)
        for kind, n in (("L", 1.0), ("box", None))
    }
    comparison = matching.compare(exact(shapes[true]), exact(shapes[found]))
    assert not comparison.right
    assert comparison.missing or comparison.extra


def test_a_model_turned_by_a_right_angle_is_the_same_model(matching):
    truth = exact(room_shape("U"))
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    frame = Frame(quarter @ truth.frame.R_manhattan_scan, truth.frame.origin_scan_m)
    comparison = matching.compare(truth, replace(truth, frame=frame))
    assert comparison.right
    np.testing.assert_allclose(comparison.errors_m, 0.0, atol=1e-12)
