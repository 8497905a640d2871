"""The plan: nothing overlaps, nothing is missing, no name gets out of its text."""

import itertools
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from rooms import BOX, FLAT, L_ROOM, PILLAR, RAGGED, U_ROOM, X_ROOM, Plan, make_result

from indoorfit.model import Interval, Note
from indoorfit.report import plan_picture, plan_svg, write_plan_png
from indoorfit.report.arrows import WARNED
from indoorfit.report.display import Dots, Label, Stroke

HOUSES = {
    "box": (BOX,),
    "l": (L_ROOM,),
    "u": (U_ROOM,),
    "x": (X_ROOM,),
    "ragged": (RAGGED,),
    "pillar": (PILLAR,),
    "flat": FLAT,
}


@pytest.fixture(params=HOUSES, scope="module")
def result(request):
    return make_result(*HOUSES[request.param])


@pytest.fixture(scope="module")
def picture(result):
    return plan_picture(result)


def overlap(a, b) -> bool:
    # Boxes that share an edge do not overlap; 1e-9 absorbs the shift to the sheet.
    return all(a[k] < b[k + 2] - 1e-9 and b[k] < a[k + 2] - 1e-9 for k in (0, 1))


def test_no_two_texts_overlap(picture):
    labels = [item for item in picture.items if isinstance(item, Label)]
    for a, b in itertools.combinations(labels, 2):
        assert not overlap(a.box(), b.box()), (a.text, b.text)


def test_no_text_lies_on_a_wall(picture):
    walls = [item for item in picture.items if isinstance(item, Stroke) and item.width >= 2.0]
    for label in (item for item in picture.items if isinstance(item, Label)):
        for wall in walls:
            assert not overlap(label.box(), wall.box()), label.text


def test_everything_is_on_the_sheet(picture):
    for item in picture.items:
        left, top, right, bottom = item.box()
        assert min(left, top) >= 0.0
        assert right <= picture.width
        assert bottom <= picture.height


def test_a_narrow_room_does_not_crop_its_caption():
    corridor = Plan([(0, 0), (0.9, 0), (0.9, 24.0), (0, 24.0)])
    picture = plan_picture(make_result(corridor, input_name="a scan with quite a long name " * 4))
    assert max(item.box()[2] for item in picture.items) <= picture.width


def test_every_wall_and_dimension_is_named(result, picture):
    texts = [item.text for item in picture.items if isinstance(item, Label)]
    names = {name.strip() for text in texts for name in text.replace(" inferred", "").split(",")}
    assert {face.id for face in result.faces if face.kind == "wall"} <= names
    assert {d.id for d in result.dimensions if d.kind != "height"} <= names
    heights = [d.id for d in result.dimensions if d.kind == "height"]
    assert all(any(f"height ({name})" in text for text in texts) for name in heights)


def test_walls_of_a_warning_are_marked_and_the_mark_is_explained(result):
    walls = [face for face in result.faces if face.kind == "wall"]
    floor = next(face for face in result.faces if face.kind == "floor")
    warned = replace(result, notes=(Note("OCCLUDED", "Hidden.", (floor.id, *(f.id for f in walls[::2]))),))
    marked = plan_picture(warned)
    marks = [item for item in marked.items if isinstance(item, Stroke) and item.colour == WARNED]
    # The last one is the legend's. Inferred walls are drawn as such already, and floors are not seen.
    assert [m.shows for m in marks[:-1]] == [(f.id,) for f in walls[::2] if f.status == "observed"]
    assert sum("warning" in item.text for item in marked.items if isinstance(item, Label)) == 1
    plain = plan_picture(replace(result, notes=(Note("PRIOR_DOMINATED", "Little was learnt."),)))
    assert not any(isinstance(item, Stroke) and item.colour == WARNED for item in plain.items)


def test_every_value_is_written(result, picture):
    texts = " ".join(item.text for item in picture.items if isinstance(item, Label))
    for d in result.dimensions:
        assert f"{d.quantity.value:.3f}" in texts


def test_dimension_lines_are_as_long_as_their_dimension():
    """Arrow tips are at the two faces: the line of a box's width spans its walls."""
    result = make_result(BOX)
    strokes = [item for item in plan_picture(result).items if isinstance(item, Stroke)]
    walls = [stroke.box() for stroke in strokes if stroke.width == 2.0]
    left, right = min(box[0] for box in walls), max(box[2] for box in walls)
    level = [stroke.box() for stroke in strokes if stroke.width == 0.9 and np.ptp(stroke.points[:, 1]) == 0.0]
    # The drawn wall reaches one unit beyond its corner, so that corners close.
    assert any(abs(box[0] - left - 1.0) < 1e-6 and abs(box[2] - right + 1.0) < 1e-6 for box in level)


def test_inferred_walls_are_dashed_and_labelled():
    items = plan_picture(make_result(L_ROOM)).items
    assert any(isinstance(item, Label) and item.text == "wall-4 inferred" for item in items)
    # One in the drawing, one in the legend.
    assert sum(isinstance(item, Stroke) and item.dash is not None for item in items) == 2
    box = plan_picture(make_result(BOX)).items
    assert not any(isinstance(item, Stroke) and item.dash is not None for item in box)


def test_points_of_floor_and_ceiling_are_left_out():
    result = make_result(BOX)
    heights = np.linspace(-1.28, 1.37, 28)
    points = np.column_stack([np.linspace(-1.5, 1.5, 28), np.zeros(28), heights])
    dots = [
        item for item in plan_picture(result, result.frame.to_scan(points)).items if isinstance(item, Dots)
    ]
    shown = sum(len(item.centres) for item in dots)
    assert shown == np.sum((heights > -1.3 + 0.3) & (heights < 1.4 - 0.3))


@pytest.mark.parametrize("n_points", [0, 1, 3])
def test_few_points_are_no_problem(n_points):
    result = make_result(BOX)
    points = result.frame.to_scan(np.zeros((n_points, 3)))
    assert plan_svg(result, points).startswith("<svg")


def test_svg_is_well_formed_and_names_stay_text():
    evil = "</text><script>alert(1)</script>&\x07\"'"
    result = make_result(L_ROOM, input_name=evil)
    root = ElementTree.fromstring(plan_svg(result))
    names = {element.tag.rpartition("}")[2] for element in root.iter()}
    assert names == {"svg", "title", "desc", "rect", "path", "text"}
    assert any("<script>" in (element.text or "") for element in root.iter())


def test_svg_is_the_same_every_time(result):
    points = result.frame.to_scan(np.random.default_rng(1).uniform(-1.0, 5.0, (5000, 3)))
    assert plan_svg(result, points) == plan_svg(result, points)


def test_png_shows_what_the_svg_says(tmp_path):
    result = make_result(L_ROOM, input_name="naïve 模型.ply")
    write_plan_png(tmp_path / "plan.png", result)
    picture = plan_picture(result)
    with Image.open(tmp_path / "plan.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    scale = pixels.shape[1] / picture.width
    for stroke in (item for item in picture.items if isinstance(item, Stroke)):
        if stroke.width != 2.0 or stroke.dash is not None:
            continue
        x, y = stroke.points.mean(axis=0) * scale
        # A wall of 2 units is 3 pixels wide; its middle is dark.
        assert pixels[int(y), int(x)].max() < 110


def test_crowded_dimensions_go_to_the_caption_instead_of_overlapping():
    steps = [(0.02 * k, 0.02 * (k % 2)) for k in range(17)]
    comb = [(x, y) for (x0, y0), (x1, _) in itertools.pairwise(steps) for x, y in ((x0, y0), (x1, y0))]
    plan = Plan([*comb, (0.32, 5.0), (0.0, 5.0)])
    picture = plan_picture(make_result(plan))
    labels = [item for item in picture.items if isinstance(item, Label)]
    assert any(label.text.startswith("Not written in the plan") for label in labels)
    for a, b in itertools.combinations(labels, 2):
        assert not overlap(a.box(), b.box()), (a.text, b.text)


def test_unknown_intervals_and_failed_fits_are_drawn():
    result = make_result(L_ROOM)
    lost = tuple(
        replace(d, quantity=replace(d.quantity, interval=Interval(0.95, -np.inf, np.inf)))
        for d in result.dimensions
    )
    texts = [
        item.text
        for item in plan_picture(replace(result, dimensions=lost, converged=False)).items
        if isinstance(item, Label)
    ]
    assert any("unknown" in text for text in texts)
    assert any("did not converge" in text for text in texts)
