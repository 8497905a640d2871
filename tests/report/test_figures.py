"""Figures for papers: all there, not blank, the same every time, and told in figures.json."""

import io
import json

import numpy as np
import pytest
from PIL import Image

import indoorfit
from indoorfit.errors import ConfigError, OutputError
from indoorfit.export import extras
from indoorfit.model import Scan
from indoorfit.pipeline import fit_scan, trace_greedy, write_figures
from indoorfit.report import figure_bytes, residual_histogram, residuals_of, step_figures
from indoorfit.report.figures.normals import angles_deg
from synthetic import virtual

pytest.importorskip("matplotlib")

CONFIG = indoorfit.RunConfig()
STEPS = {
    "step-1-points", "step-2-segments", "step-3-largest-cube", "step-4-remaining-segments",
    "step-5-notch-cubes", "step-6-result",
}  # fmt: skip


@pytest.fixture(scope="module")
def u_room() -> Scan:
    return virtual("U", 1, n_points=20_000).scan


@pytest.fixture(scope="module")
def trace(u_room):
    return trace_greedy(u_room, CONFIG)


@pytest.fixture(scope="module")
def figures(trace):
    return step_figures(trace)


def test_every_step_of_the_grammar_has_a_figure(figures):
    assert set(figures) == STEPS | {"normals", "normals-remaining"}


def test_a_box_leaves_nothing_for_a_notch():
    drawn = step_figures(trace_greedy(virtual("box", 1, n_points=10_000).scan, CONFIG))
    notches = {"step-4-remaining-segments", "step-5-notch-cubes"}
    assert set(drawn) == (STEPS | {"normals"}) - notches


@pytest.mark.parametrize("name", sorted(STEPS | {"normals", "normals-remaining"}))
def test_no_figure_is_blank(figures, name):
    image = np.asarray(Image.open(io.BytesIO(figure_bytes(figures[name], "png"))).convert("RGB"))
    inked = np.mean(np.any(image < 250, axis=2))
    # A wire box alone covers more than a thousandth, and nothing may cover the paper.
    assert 0.001 < inked < 0.9
    border = [image[:3], image[-3:], image[:, :3], image[:, -3:]]
    assert min(part.min() for part in border) > 200, "nothing is cut off at the border"


@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_equal_figures_have_equal_bytes(trace, kind):
    first, second = (figure_bytes(step_figures(trace)["step-6-result"], kind) for _ in range(2))
    assert first == second


def test_the_notch_of_a_u_lies_between_its_intersection_points(trace):
    made = [step for step in trace.steps if step.action == "cube"]
    assert len(made) == 1
    # Two intersection points, each on floor and ceiling (thesis 5.1.1.2).
    assert made[0].corners_m.shape == (2, 2, 3)


def test_the_trace_is_in_the_frame_of_the_largest_cube(trace):
    low, high = trace.shape.bounds_m()[trace.shape.rooms[0].id]
    inside = np.all((trace.surfels_m > low - 0.05) & (trace.surfels_m < high + 0.05), axis=1)
    assert inside.mean() > 0.98
    for name, group in trace.selected().items():
        axis, sign = {"left": (0, -1), "right": (0, 1), "back": (1, -1), "front": (1, 1),
                      "floor": (2, -1), "ceiling": (2, 1)}[name]  # fmt: skip
        # The cosine of 15 degrees: the constraint of table 3-1.
        assert np.all(sign * trace.normals[list(group), axis] > 0.96)


def test_azimuths_and_elevations_are_those_of_the_axes():
    axes = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0], [0, 0, -1.0]])
    azimuth, elevation = angles_deg(axes)
    np.testing.assert_allclose(azimuth[:4], [0.0, 90.0, 180.0, -90.0], atol=1e-9)
    np.testing.assert_allclose(elevation, [0, 0, 0, 0, 90.0, -90.0], atol=1e-9)


def test_the_histogram_counts_what_the_residuals_count(u_room):
    result = fit_scan(u_room, CONFIG)
    residuals = residuals_of(result, u_room.points_m)
    assert residuals is not None
    # The scan's noise: 5 mm along the normal; 20 000 points know it to 1 %, the association to some more.
    assert residuals.std_m == pytest.approx(0.005, rel=0.05)
    axes = residual_histogram(residuals).axes[0]
    assert sum(bar.get_height() for bar in axes.patches) == residuals.counts.sum()


def test_files_and_captions_agree(u_room, tmp_path):
    model = indoorfit.fit(u_room)
    names = model.write_figures(tmp_path / "figures", formats=("png",))
    index = json.loads((tmp_path / "figures" / "figures.json").read_text(encoding="utf-8"))
    assert tuple(index) == names
    listed = {file for entry in index.values() for file in entry["files"]}
    assert listed | {"figures.json"} == {path.name for path in (tmp_path / "figures").iterdir()}
    assert set(names) == STEPS | {"plan", "residuals", "normals", "normals-remaining"}
    assert all(entry["caption"] for entry in index.values())
    with pytest.raises(OutputError, match="exists"):
        model.write_figures(tmp_path / "figures")
    model.write_figures(tmp_path / "figures", formats=("pdf", "svg"), overwrite=True)
    assert not list((tmp_path / "figures").glob("*.png"))
    assert len(list((tmp_path / "figures").iterdir())) == 2 * len(names) + 1


def test_a_scan_that_greedy_cannot_model_still_has_plan_and_histogram(u_room, tmp_path, monkeypatch):
    def refuses(*_):
        raise indoorfit.InputError("no room here. Fix: none.")

    monkeypatch.setattr("indoorfit.pipeline.figures.trace_greedy", refuses)
    names = write_figures(fit_scan(u_room, CONFIG), u_room, CONFIG, tmp_path / "figures")
    assert names == ("plan", "residuals")


def test_no_format_and_a_missing_library_are_told_and_leave_nothing(u_room, tmp_path, monkeypatch):
    result = fit_scan(u_room, CONFIG)
    with pytest.raises(ConfigError, match="needed some of svg, pdf, png"):
        write_figures(result, u_room, CONFIG, tmp_path / "figures", formats=())

    def missing(name):
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(extras, "import_module", missing)
    with pytest.raises(OutputError, match=r"indoorfit\[figures\]"):
        write_figures(result, u_room, CONFIG, tmp_path / "figures")
    assert list(tmp_path.iterdir()) == []
