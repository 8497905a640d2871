"""The report page as a browser shows it."""

import io
from dataclasses import replace

import numpy as np
import pypdfium2
import pytest
from browser import Browser, find_chromium
from PIL import Image
from rooms import BOX, L_ROOM, Plan, make_result

from indoorfit.model import Note, TapeCheck, TapeVerdict
from indoorfit.report import plan_svg, report_html, residuals_of

EVIL = "<script>window.broken = 1</script><img src=x onerror='window.broken = 1'>\"'</script><!--"
NEXT = Plan([(2.2, -1.5), (5.0, -1.5), (5.0, 2.0), (2.2, 2.0)])


@pytest.fixture(scope="module")
def browser():
    executable = find_chromium()
    if executable is None:
        pytest.skip("no Chromium found; install it, or name one in INDOORFIT_CHROMIUM")
    browser = Browser(executable)
    browser.look(1200, 900)
    yield browser
    browser.close()


def with_tape(result):
    first, second = result.dimensions[:2]
    checks = tuple(
        TapeCheck(d.id, (2,), d.quantity.value + error, 0.001, -error, 1.0, True)
        for d, error in ((first, 0.001), (second, -0.002))
    )
    return replace(result, tape=TapeVerdict("tape.csv", "0", checks, (), 1.0, 0.5))


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    result = with_tape(make_result(BOX, NEXT))
    rng = np.random.default_rng(1)
    # Points on every face, 5 mm off it: enough for histogram and maps.
    points = [
        rng.dirichlet(np.ones(len(face.rings_m[0])), 400) @ face.rings_m[0]
        + 0.005 * rng.standard_normal((400, 1)) * face.normal
        for face in result.faces
    ]
    residuals = residuals_of(result, np.concatenate(points))
    assert residuals is not None
    (folder / "good.html").write_text(report_html(result, plan_svg(result), residuals), encoding="utf-8")
    evil = make_result(L_ROOM, input_name=EVIL)
    evil = replace(
        evil,
        notes=(Note(EVIL, EVIL),),
        noise={"explanation": EVIL, EVIL: EVIL},
        provenance={"input": {"name": EVIL}, EVIL: [EVIL]},
        faces=tuple(replace(f, id=EVIL + f.id, room=EVIL) for f in evil.faces),
        meshes=tuple(
            replace(m, room=EVIL, face_ids=tuple(EVIL + name for name in m.face_ids)) for m in evil.meshes
        ),
        dimensions=tuple(
            replace(d, id=EVIL + d.id, faces=(EVIL + d.faces[0], EVIL + d.faces[1]), wall=None, room=EVIL)
            for d in evil.dimensions
        ),
        rooms=tuple(replace(room, id=EVIL) for room in evil.rooms),
    )
    (folder / "evil.html").write_text(report_html(evil, plan_svg(evil)), encoding="utf-8")
    return folder, result


def pixels(png):
    with Image.open(io.BytesIO(png)) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def stage(browser):
    browser.run("document.getElementById('view').scrollIntoView()")
    browser.settle()
    box = browser.run("JSON.parse(JSON.stringify(document.querySelector('canvas').getBoundingClientRect()))")
    shot = pixels(browser.screenshot())
    return shot[int(box["top"]) : int(box["bottom"]), int(box["left"]) : int(box["right"])]


def test_the_page_loads_without_an_error_and_without_a_request(browser, pages):
    browser.open(pages[0] / "good.html")
    assert browser.complaints() == []
    outside = [url for url in browser.requests() if not url.startswith("data:")]
    assert outside == [(pages[0] / "good.html").resolve().as_uri()]


def test_the_room_is_drawn_and_its_dimensions_and_names_stand_in_it(browser, pages):
    browser.open(pages[0] / "good.html")
    # Floor and walls seen from above: a blank canvas has one colour and no change from point to point.
    edges = np.abs(np.diff(stage(browser), axis=1)).sum(axis=2) > 12
    assert edges.mean() > 0.002
    shown = browser.run(
        "[...document.querySelectorAll('.labels span')].filter(s => s.offsetParent).map(s => s.textContent)"
    )
    assert any(text.startswith("wall-") for text in shown)
    assert any("±" in text for text in shown)


def test_choosing_a_dimension_lights_its_faces_row_and_plan(browser, pages):
    folder, result = pages
    browser.open(folder / "good.html")
    dimension = result.dimensions[0]

    def orange():
        # Translucent over any wall, so only its direction is known: red over green over blue.
        red, green, blue = np.moveaxis(stage(browser), 2, 0)
        return float(((red - green > 30) & (green - blue > 30)).mean())

    before = orange()
    browser.run(f"document.querySelector('tr[data-pick=\"{dimension.id}\"] button').click()")
    # At least one of the two faces looks at the observer; half of 1 % is a tenth of a small wall.
    assert orange() > before + 0.005
    lit = browser.run("[...document.querySelectorAll('svg .lit')].flatMap(e => e.dataset.shows.split(' '))")
    assert {*dimension.faces, dimension.id} & set(lit)
    assert browser.run("document.querySelectorAll('tr.lit').length") >= 1
    assert dimension.faces[0] in browser.run("document.getElementById('says').textContent")
    browser.run("dispatchEvent(new KeyboardEvent('keydown', {key: 'Escape'}))")
    assert abs(orange() - before) < 0.002
    assert browser.run("document.querySelectorAll('.lit').length") == 0


def test_the_table_sorts_by_value_and_copies_as_columns(browser, pages):
    folder, result = pages
    browser.open(folder / "good.html")
    table = "document.querySelector('#dimensions table')"
    values = f"[...{table}.tBodies[0].rows].map(r => Number(r.cells[2].dataset.sort))"
    for order in (1, -1):
        browser.run(f"{table}.tHead.rows[0].cells[2].querySelector('button').click()")
        sorted_values = np.array(browser.run(values))
        assert (order * np.diff(sorted_values) >= 0.0).all()
    assert len(sorted_values) == len(result.dimensions)
    lines = browser.run(f"asText({table})").splitlines()
    cells = [line.split("\t") for line in lines]
    assert len({len(row) for row in cells}) == 1
    head = cells[0]
    assert {"Low at 95 %, m", "High at 95 %, m", "Tape, m", "Model minus tape, mm"} <= set(head)
    row = next(row for row in cells if row[0] == result.dimensions[1].id)
    assert float(row[head.index("Model minus tape, mm")]) == pytest.approx(2.0)
    low, high = (float(row[head.index(f"{end} at 95 %, m")]) for end in ("Low", "High"))
    assert low < result.dimensions[1].quantity.value < high


def test_names_of_files_and_faces_cannot_become_markup(browser, pages):
    browser.open(pages[0] / "evil.html")
    browser.run("document.querySelector('tr[data-pick] button').click()")
    browser.settle()
    assert browser.complaints() == []
    assert browser.run("window.broken") is None
    assert browser.run("document.querySelectorAll('img[onerror], main script').length") == 0
    assert EVIL in browser.run("document.querySelector('h1').textContent")


def test_walking_cutting_and_turning_work_by_keyboard(browser, pages):
    browser.open(pages[0] / "good.html")
    views = [stage(browser)]
    for script in (
        "document.querySelector('canvas').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}))",
        "cut.value = 50; cut.dispatchEvent(new Event('input'))",
        "document.getElementById('walk').click()",
        "document.querySelector('canvas').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}))",
    ):
        browser.run(f"(() => {{ const cut = document.getElementById('cut'); {script}; }})()")
        views.append(stage(browser))
        assert np.abs(views[-1] - views[-2]).mean() > 0.2, script
    assert browser.complaints() == []


def test_everything_to_press_has_a_name(browser, pages):
    browser.open(pages[0] / "good.html")
    # By the browser's own tree, as a screen reader gets it.
    nodes = browser.call("Accessibility.getFullAXTree")["nodes"]
    controls = [
        n for n in nodes if n.get("role", {}).get("value") in ("button", "checkbox", "slider", "link")
    ]
    assert len(controls) > 10
    assert all(node.get("name", {}).get("value") for node in controls)


def test_a_phone_need_not_scroll_sideways_and_dark_is_dark(browser, pages):
    browser.look(390, 844, dark=True, phone=True)
    try:
        browser.open(pages[0] / "good.html")
        assert browser.run("document.documentElement.scrollWidth") <= 390
        corner = pixels(browser.screenshot())[4, 4]
    finally:
        browser.look(1200, 900)
    assert corner.max() < 64


def test_it_prints_on_a4(browser, pages):
    browser.open(pages[0] / "good.html")
    printed = pypdfium2.PdfDocument(browser.printed())
    try:
        # 210 x 297 mm in points of 1/72 inch; Chromium rounds to its own pixels.
        assert printed[0].get_size() == pytest.approx((595.3, 841.9), abs=1.0)
        text = "".join(page.get_textpage().get_text_range() for page in printed)
    finally:
        printed.close()
    assert "Model minus tape" in text
    assert "Copy table" not in text
