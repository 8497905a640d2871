"""The report on paper."""

from dataclasses import replace

import pypdfium2
import pytest
from rooms import FLAT, L_ROOM, make_result

from indoorfit.model import Note
from indoorfit.report import plan_picture, report_pdf


def read(content):
    document = pypdfium2.PdfDocument(content)
    try:
        sizes = [page.get_size() for page in document]
        text = "\n".join(page.get_textpage().get_text_range() for page in document)
    finally:
        document.close()
    return sizes, text


def test_report_pdf_is_a4_and_says_what_the_result_says():
    result = make_result(*FLAT)
    content = report_pdf(result, plan_picture(result))
    sizes, text = read(content)
    # 210 x 297 mm in points.
    assert all(size == pytest.approx((595.28, 841.89), abs=0.01) for size in sizes)
    for wanted in ("hand-made.ply", "Dimensions", "Interval, 95 %", "WALL_INFERRED", "scatter by 5 mm", "±"):
        assert wanted in text
    # Every length stands in the table and most on the plan, too.
    assert all(f"{d.quantity.value:.2f}" in text for d in result.dimensions)
    assert content == report_pdf(result, plan_picture(result))


def test_report_pdf_shows_markup_in_names_as_it_is():
    evil = "<b>x</b><img src='http://example.org/x.png'/>&amp;"
    result = make_result(L_ROOM, input_name=evil)
    result = replace(result, notes=(Note(evil, "<para>"),), noise={"explanation": "<font color='red'>"})
    _, text = read(report_pdf(result, plan_picture(result)))
    assert "<img src=" in text
    assert "<para>" in text
