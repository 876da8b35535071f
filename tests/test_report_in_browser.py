"""The pages in headless Chromium, without network: no error, nothing missing, no text out of its box."""

import pytest

from chromium import browser, measured, run
from made_fit import made_fit
from test_cohort_report import folder, page, trees  # noqa: F401  fixtures
from vasowave.report import write_report


@pytest.mark.parametrize("width", [400, 1200, 1920])
def test_the_page_of_a_cohort_fits_into_every_width(page, width, tmp_path):  # noqa: F811
    assert_fits(page, width, tmp_path, at_least=20)


@pytest.mark.parametrize("width", [400, 1200])
def test_the_page_of_an_animal_fits_into_every_width(width, tmp_path):
    path = write_report([made_fit("linear"), made_fit("tangent")], tmp_path / "animal")
    assert_fits(path.read_text(encoding="utf-8"), width, tmp_path, at_least=5)


def assert_fits(text, width, folder, at_least):  # noqa: F811
    browser()
    found, console = measured(text, width, folder)
    assert found["drawings"] >= at_least
    assert found["pageWidth"] <= found["frameWidth"] == width
    for what in ("errors", "wide", "cut", "loaded"):
        assert found[what] == [], what
    assert (found["empty"], found["missing"], found["unresolved"]) == (0, 0, 0)
    assert console == []


def test_a_text_out_of_its_box_would_be_found(page, tmp_path):  # noqa: F811
    browser()
    broken = page.replace("<main>", '<main><p style="width: 60px; white-space: nowrap">a line that runs on</p>')
    broken = broken.replace("</main>", '<img src="missing.png"><a href="#nowhere">x</a></main>')
    found, _ = measured(broken, 1200, tmp_path)
    assert any("a line that runs on" in text for text in found["wide"])
    assert (found["missing"], found["unresolved"]) == (1, 1)
    assert len(found["loaded"]) + len(found["errors"]) > 0


def test_the_page_prints(folder, tmp_path):  # noqa: F811
    browser()
    target = tmp_path / "printed.pdf"
    run([f"--print-to-pdf={target}", (folder / "report.html").as_uri()], tmp_path)
    assert target.read_bytes().startswith(b"%PDF")
    assert target.read_bytes().count(b"/Type /Page\n") + target.read_bytes().count(b"/Type /Page ") > 5
