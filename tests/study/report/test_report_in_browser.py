"""The pages in headless Chromium, without network: no error, nothing missing, no text out of its box."""

import json

import numpy as np
import pytest
from matplotlib import colormaps

from chromium import browser, measured, run
from vasowave.base import provenance
from vasowave.study.figures import SCALE, new_figure, style
from vasowave.study.report import Drawing, Report, Section, page

WIDTHS = (400, 1200, 1920)


@pytest.mark.validation
def test_the_supplement_of_a_cohort_fits_into_every_width(cohort_page, tmp_path):
    assert_fits(cohort_page, tmp_path, at_least=20)


def test_the_first_page_of_a_cohort_fits_into_every_width(cohort_answer, tmp_path):
    assert_fits(cohort_answer, tmp_path, at_least=3)


def test_the_forest_plot_scrolls_at_no_width_and_is_shown_once(cohort_answer, tmp_path):
    browser()
    found, _ = measured(cohort_answer, (360, 400, 700, 1200), tmp_path)
    assert [one["sideways"] for one in found] == [[]] * 4
    assert {one["shown"] for one in found} == {4}


def test_the_page_of_an_animal_fits_into_every_width(lone_report, tmp_path):
    assert_fits((lone_report / "report.html").read_text(encoding="utf-8"), tmp_path, at_least=3)
    assert_fits((lone_report / "supplement.html").read_text(encoding="utf-8"), tmp_path, at_least=10)


@pytest.mark.parametrize("scale", [-1e-3, *(pytest.param(one, marks=pytest.mark.validation) for one in (1e-5, 1.0))])
def test_numbers_beside_the_waveforms_in_space_are_whole(scale, lone_report, tmp_path):
    text = (lone_report / "supplement.html").read_text(encoding="utf-8")
    before, begin, rest = text.partition('class="space"')
    head, script, data = rest.partition('<script type="application/json">')
    data, end, after = data.partition("</script>")
    content = json.loads(data)
    for one in content["networks"]:
        one["flow"] = [[scale * (value + 0.0123456) for value in row] for row in one["flow"]]
    (found,), _ = measured("".join([before, begin, head, script, json.dumps(content), end, after]), [1200], tmp_path)
    assert found["cut"] == found["errors"] == []


def assert_fits(text, folder, at_least):
    browser()
    found, console = measured(text, WIDTHS, folder)
    assert [one["width"] for one in found] == list(WIDTHS)
    for one in found:
        assert one["drawings"] >= at_least
        assert one["pageWidth"] <= one["width"]
        for what in ("errors", "wide", "cut", "loaded"):
            assert one[what] == [], f"{what} at {one['width']} px"
        assert (one["empty"], one["missing"], one["unresolved"]) == (0, 0, 0)
    assert console == []


def test_what_is_out_of_its_box_or_missing_would_be_found(cohort_page, tmp_path):
    browser()
    broken = cohort_page.replace("<main>", '<main><p style="width: 60px; white-space: nowrap">a line that runs on</p>')
    broken = broken.replace("</main>", '<img src="missing.png"><a href="#nowhere">x</a></main>')
    broken = broken.replace("</main>", "<script>console.error('told')</script></main>")
    (found,), console = measured(broken, [1200], tmp_path)
    assert any("a line that runs on" in text for text in found["wide"])
    assert (found["missing"], found["unresolved"]) == (1, 1)
    assert found["errors"]
    assert any("told" in line for line in console)


@pytest.mark.validation
def test_the_page_prints(cohort_report, tmp_path):
    browser()
    target = tmp_path / "printed.pdf"
    run([f"--print-to-pdf={target}", (cohort_report / "report.html").as_uri()], tmp_path)
    assert target.read_bytes().startswith(b"%PDF")


def test_colors_mean_the_same_on_a_dark_page(tmp_path):
    """Both ends of the color scale are painted as often, and in the same order, in the dark as in the light."""
    from matplotlib.image import imread

    bar = Drawing("Bar", "low to high", bar_figure())
    browser()
    page_of_bar = page(Report("report", "Bar", "", "", [Section("bar", "Bar", [bar])], provenance()), {})
    path = tmp_path / "bar.html"
    path.write_text(page_of_bar, encoding="utf-8")
    places, papers = {}, {}
    for scheme, setting in {"dark": 0, "light": 1}.items():
        shot = tmp_path / f"{scheme}.png"
        look = f"--blink-settings=preferredColorScheme={setting}"
        run([look, f"--screenshot={shot}", "--window-size=800,600", path.as_uri()], tmp_path)
        pixels = imread(shot)[:, :, :3]
        papers[scheme] = pixels[-1, -1].mean()
        ends = [np.abs(pixels - np.array(colormaps[SCALE](end)[:3])).max(axis=2) < 0.02 for end in (0.0, 1.0)]
        places[scheme] = [(int(one.sum()), float(np.nonzero(one)[1].mean())) for one in ends]
    assert papers["dark"] < 0.2 < 0.8 < papers["light"]
    for (dark, at_dark), (light, at_light) in zip(places["dark"], places["light"], strict=True):
        assert light > 100
        assert dark == pytest.approx(light, rel=0.1)
        assert at_dark == pytest.approx(at_light, abs=20)


def bar_figure():
    """Return a figure of the color scale from its low end, left, to its high one."""
    with style():
        figure = new_figure(10, 3)
        ax = figure.subplots()
        for k in range(10):
            ax.barh(0, 1, left=k, color=colormaps[SCALE](k / 9))
    return figure
