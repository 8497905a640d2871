"""Plans to scale: what a ruler reads on paper and a drawing program measures is the model's length."""

import io
import re
import xml.etree.ElementTree as ET

import ezdxf
import numpy as np
import pypdfium2
import pytest
from rooms import FLAT, L_ROOM, PILLAR, RAGGED, Plan, make_result

from indoorfit.errors import OutputError
from indoorfit.export import quantity_text
from indoorfit.report import UNIT_MM, plan_layout, plan_sheet, to_dxf, to_pdf, to_svg

HOUSES = {"l": (L_ROOM,), "ragged": (RAGGED,), "pillar": (PILLAR,), "flat": FLAT}
HALL = Plan([(0, 0), (21.0, 0), (21.0, 12.0), (0, 12.0)])


@pytest.fixture(params=HOUSES, scope="module")
def house(request):
    return make_result(*HOUSES[request.param])


def drawing_of(result, denominator=None):
    content = to_dxf(result, plan_layout(result, denominator))
    return ezdxf.read(io.StringIO(content.decode("utf-8")))


def facts_of(entity) -> list[dict]:
    """The extended data: one dict per face or dimension."""
    values = [tag.value for tag in entity.get_xdata("INDOORFIT")]
    found: list[dict] = []
    while values:
        word = values.pop(0)
        if word in ("face", "dimension") and (not values or values[0] == "id"):
            found.append({"what": word})
        else:
            found[-1][word] = values.pop(0)
    return found


def test_dxf_passes_the_audit_in_metres(house):
    drawing = drawing_of(house)
    auditor = drawing.audit()
    assert (auditor.errors, auditor.fixes) == ([], [])
    assert drawing.header["$INSUNITS"] == 6


def test_dxf_has_every_face_on_its_layer(house):
    drawing = drawing_of(house)
    layers = {}
    for entity in drawing.modelspace().query("LINE LWPOLYLINE"):
        (facts,) = facts_of(entity)
        layers[facts["id"]] = entity.dxf.layer
    wall = {"observed": "WALLS", "inferred": "WALLS_INFERRED"}
    others = {"floor": "FLOORS", "ceiling": "CEILINGS"}
    assert layers == {f.id: others.get(f.kind) or wall[f.status] for f in house.faces}


def test_dxf_floors_have_the_rooms_area(house):
    areas = []
    for line in drawing_of(house).modelspace().query('LWPOLYLINE[layer=="FLOORS"]'):
        x, y = np.array(line.get_points("xy")).T
        areas.append(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    # Holes run clockwise; 1e-9 m of rounding at map distance.
    expected = sum(room.floor_area.value for room in house.rooms)
    assert sum(areas) == pytest.approx(expected, rel=1e-8)


def test_dxf_dimensions_measure_what_the_model_says(house):
    found = set()
    for entity in drawing_of(house).modelspace().query("DIMENSION"):
        every = facts_of(entity)
        first = next(d for d in house.dimensions if d.id == every[0]["id"])
        if "<>" in entity.dxf.text:
            assert quantity_text(first.quantity).spread in entity.dxf.text
        for facts in every:
            d = next(d for d in house.dimensions if d.id == facts["id"])
            assert entity.get_measurement() == pytest.approx(d.quantity.value, abs=1e-8)
            assert (facts["low_m"], facts["high_m"]) == (d.quantity.interval.low, d.quantity.interval.high)
            block = entity.get_geometry_block()
            text = " ".join(t.plain_text() for t in block.query("MTEXT"))
            assert "<>" not in text
            assert d.id in text
            found.add(d.id)
    assert found == {d.id for d in house.dimensions if d.kind != "height"}


def test_dxf_says_where_it_lies_in_the_scan(house):
    variables = dict(drawing_of(house).header.custom_vars.properties)
    assert "5000000.0" in variables["indoorfit.origin_scan_m"]
    assert variables["indoorfit.scale"] == "1:50"


def test_sheets_use_the_first_scale_that_fits():
    assert [
        (sheet.layout.denominator, sheet.paper)
        for sheet in (plan_sheet(make_result(L_ROOM)), plan_sheet(make_result(HALL)))
    ] == [(50, "A4"), (100, "A4")]
    assert plan_sheet(make_result(L_ROOM), 20).paper == "A3"
    with pytest.raises(OutputError, match="--scale"):
        plan_sheet(make_result(HALL), 5)


def longest_line_mm(points_mm: list[np.ndarray]) -> float:
    return max(float(np.linalg.norm(line[-1] - line[0])) for line in points_mm)


@pytest.mark.parametrize("denominator", [20, 50, 100])
def test_svg_is_true_to_scale_on_paper(denominator):
    sheet = plan_sheet(make_result(L_ROOM), denominator)
    root = ET.fromstring(to_svg(sheet.picture, UNIT_MM))
    assert (root.get("width"), root.get("height")) == tuple(f"{side:.3f}mm" for side in sheet.size_mm)
    unit_mm = sheet.size_mm[0] / float(root.get("viewBox").split()[2])
    walls = [
        np.array(re.findall(r"-?[\d.]+", path.get("d")), float).reshape(-1, 2) * unit_mm
        for path in root.iter("{http://www.w3.org/2000/svg}path")
        if path.get("stroke") == "#2a2d30" and path.get("stroke-width") == "2"
    ]
    # The long wall, 5.08 m, with square ends of a page unit each; coordinates are rounded to 0.01 units.
    expected_mm = 5080.0 / denominator + 2.0 * UNIT_MM
    assert longest_line_mm(walls) == pytest.approx(expected_mm, abs=0.02 * UNIT_MM)


def test_pdf_is_one_page_of_paper_with_all_texts(house):
    sheet = plan_sheet(house)
    document = pypdfium2.PdfDocument(to_pdf(sheet.picture, UNIT_MM))
    assert len(document) == 1
    size_mm = [side / 72.0 * 25.4 for side in document[0].get_size()]
    assert size_mm == pytest.approx(sheet.size_mm, abs=0.01)
    text = document[0].get_textpage().get_text_range()
    assert f"Scale 1:{sheet.layout.denominator}" in text
    for face in house.faces:
        if face.kind == "wall":
            assert face.id in text
    for d in house.dimensions:
        if d.kind == "wall":
            assert quantity_text(d.quantity).value in text
    document.close()


def test_pdf_is_drawn_to_scale():
    result = make_result(Plan([(0, 0), (4.0, 0), (4.0, 3.0), (0, 3.0)]))
    sheet = plan_sheet(result, 50)
    document = pypdfium2.PdfDocument(to_pdf(sheet.picture, UNIT_MM))
    dots_per_mm = 10.0
    image = np.asarray(document[0].render(scale=dots_per_mm * 25.4 / 72.0).to_pil().convert("L"), float)
    document.close()
    # The walls are the long dark lines: columns and rows that are dark along most of the room.
    dark = image < 80.0
    columns = np.flatnonzero(dark.sum(axis=0) > 0.8 * 3000.0 / 50.0 * dots_per_mm)
    rows = np.flatnonzero(dark.sum(axis=1) > 0.8 * 4000.0 / 50.0 * dots_per_mm)
    # Between the lines' middles; a line is 2 page units = 5.3 dots wide.
    width_mm = (columns.max() - columns.min()) / dots_per_mm - 2.0 * UNIT_MM
    height_mm = (rows.max() - rows.min()) / dots_per_mm - 2.0 * UNIT_MM
    assert (width_mm, height_mm) == pytest.approx((80.0, 60.0), abs=0.2)
