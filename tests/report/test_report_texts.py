"""Table, page and picture."""

from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image
from rooms import BOX, FLAT, L_ROOM, RAGGED, make_result

from indoorfit.export import face_colour
from indoorfit.model import Note
from indoorfit.report import View, dimension_table, plan_svg, render_png, report_html


def test_table_columns_line_up_and_hold_every_dimension():
    result = make_result(*FLAT)
    lines = dimension_table(result).split("\n\n")[0].splitlines()
    starts = [0] + [k + 2 for k in range(len(lines[1])) if lines[1][k : k + 2] == "  "]
    for line in lines[2:]:
        # A gap of two blanks stands before every column, in every row.
        assert all(line[start - 2 : start] == "  " for start in starts[1:])
    assert [line.split()[0] for line in lines[2:]] == [d.id for d in result.dimensions]
    points = {line.index(".", starts[2]) for line in lines[2:]}
    assert len(points) == 1


def test_table_names_rooms_warnings_and_failure():
    result = replace(make_result(*FLAT), converged=False)
    table = dimension_table(result)
    for text in ("floor area", "volume", "perimeter", "room-3", "warning WALL_INFERRED", "did not converge"):
        assert text in table


def test_table_of_an_empty_result_is_no_error():
    empty = replace(make_result(BOX), dimensions=(), rooms=(), notes=())
    assert dimension_table(empty) == "\n"


class _Tags(HTMLParser):
    """Counts tags and checks that they nest."""

    VOID = frozenset({"meta", "br", "rect", "path", "input", "img"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []
        self.text = ""

    def handle_starttag(self, tag, attrs):
        self.seen.append(tag)
        assert not any(name.startswith("on") for name, _ in attrs)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def parse(page: str) -> _Tags:
    tags = _Tags()
    tags.feed(page)
    assert tags.open == []
    return tags


def test_page_nests_and_says_everything():
    result = make_result(*FLAT)
    tags = parse(report_html(result, plan_svg(result)))
    for d in result.dimensions:
        assert d.wall is None or d.wall in tags.text
    for text in ("LOA40", "WALL_INFERRED", "scatter by 5 mm", "input.name", "Floor area", "inferred"):
        assert text in tags.text
    assert tags.seen.count("svg") == 1


def test_page_escapes_every_text_of_the_result():
    evil = "<script>alert('x')</script>&amp;\""
    result = make_result(L_ROOM, input_name=evil)
    result = replace(
        result,
        notes=(Note(evil, evil),),
        noise={"explanation": evil, evil: evil},
        provenance={"input": {"name": evil}, evil: [evil], "nested": {evil: {evil: 1}}},
        dimensions=tuple(replace(d, id=evil, faces=(evil, evil), wall=evil) for d in result.dimensions),
        rooms=tuple(replace(room, id=evil) for room in result.rooms),
    )
    page = report_html(result, "<svg></svg>")
    tags = parse(page)
    # The data and the page's own three scripts; a policy by hashes keeps any other from running.
    assert tags.seen.count("script") == 4
    assert evil in tags.text
    assert evil not in page


def read_pixels(path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def test_render_shows_floor_and_far_walls_but_no_near_ones(tmp_path):
    result = make_result(BOX)
    # Level with the horizon from the left, only the right wall faces the observer.
    render_png(tmp_path / "side.png", result, View(np.pi, 0.0, 240, 160))
    pixels = read_pixels(tmp_path / "side.png").reshape(-1, 3)
    colours, counts = np.unique(pixels, axis=0, return_counts=True)
    main = [tuple(c) for c in colours[np.argsort(counts)[-2:]].tolist()]
    assert (255, 255, 255) in main
    red, green, blue = next(c for c in main if c != (255, 255, 255))
    right = face_colour(next(face for face in result.faces if face.face_class == "right"))
    # Shading scales all channels alike; rounding to bytes leaves half a unit each.
    np.testing.assert_allclose(np.array([red, green, blue]) / red, np.array(right) / right[0], atol=0.02)


@pytest.mark.parametrize("plans", [(L_ROOM,), (RAGGED,), FLAT], ids=["l", "ragged", "flat"])
def test_render_area_of_the_floor_is_the_plan_seen_from_above(plans, tmp_path):
    result = make_result(*plans)
    render_png(tmp_path / "top.png", result, View(-0.5 * np.pi, 0.5 * np.pi, 900, 700))
    inked = (read_pixels(tmp_path / "top.png") < 250).any(axis=2)
    corners = np.concatenate([np.concatenate(face.rings_m) for face in result.faces])
    extent_m = np.ptp(result.frame.to_manhattan(corners)[:, :2], axis=0)
    scale = min(900 * 0.88 / extent_m[0], 700 * 0.88 / extent_m[1])
    area_m2 = sum(room.floor_area.value for room in result.rooms)
    outline_m = sum(room.perimeter.value for room in result.rooms)
    # Edge lines are up to 1.5 pixels wide and count as ink outside the floor.
    assert abs(inked.sum() / scale**2 - area_m2) < 2.0 * outline_m / scale
