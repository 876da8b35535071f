"""Symbols have true subscripts wherever they are read: no underscore is left on a page, in a drawing or on paper."""

import html
import re
from xml.etree import ElementTree

import pytest

from vasowave.study.figures import as_file, label_axes, lowered, new_figure, pieces, style
from vasowave.study.report import markup, written

NAMES = re.compile(r"ParAll_change|WIA-I_R|\b\w+_\w+(?=\":)|\w+\.(?:csv|svg)")
"""Names of files and keys of settings, which are as they are typed."""


def left(markup):
    """Return what is read of a page or a drawing and still has an underscore."""
    text = re.sub(r"<(script|style|code)\b.*?</\1>", " ", markup, flags=re.DOTALL)
    said = [*re.findall(r'\s(?:title|aria-label)="([^"]*)"', text), re.sub(r"<[^>]*>", " ", text)]
    return [one for part in said for one in re.findall(r"\S*_\S*", NAMES.sub("", html.unescape(part)))]


def test_no_underscore_is_read_on_pages_and_in_drawings(cohort_report, cohort_page, cohort_answer):
    assert "R<sub>T</sub>" in cohort_page
    assert left(cohort_page) == left(cohort_answer) == []
    for drawing in (cohort_report / "figures").glob("*.svg"):
        assert left(drawing.read_text(encoding="utf-8")) == [], drawing.name


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<p>R_T C_T, a = R₁/R_T.</p>", "<p>R<sub>T</sub> C<sub>T</sub>, a = R₁/R<sub>T</sub>.</p>"),
        ('<abbr title="the R_T">R_T</abbr>', '<abbr title="the RT">R<sub>T</sub></abbr>'),
        ("<option>Z_c</option> Z_c", "<option>Zc</option> Z<sub>c</sub>"),
        (
            '<td id="R_T">WIA-I_R, R_T.csv, my_R_T, C_parent</td>',
            '<td id="R_T">WIA-I_R, R_T.csv, my_R_T, C_parent</td>',
        ),
        ("<script>R_T < 3</script>E_es", "<script>R_T < 3</script>E<sub>es</sub>"),
    ],
)
def test_what_is_lowered_and_what_stays(text, said):
    assert lowered(text) == said


def test_a_drawing_lowers_one_letter_and_goes_on_at_its_height():
    drawn = lowered('<svg><text x="1">share of R_T in C_T [1]</text><title>R_T</title></svg>')
    text, title = ElementTree.fromstring(drawn)
    assert "".join(text.itertext()) == "share of RT in CT [1]"
    assert title.text == "RT"
    shifts = [(one.text, float(one.get("dy")[:-2]) * (0.72 if one.get("font-size") else 1.0)) for one in text]
    assert [name for name, _ in shifts] == ["T", " in C", "T", " [1]"]
    assert sum(shift for _, shift in shifts) == pytest.approx(0.0, abs=0.01)


def test_typst_gets_subscripts_of_its_own_and_reads_nothing_else_as_markup():
    assert written("no $sign_x$ #here") == '"no $sign_x$ #here"'
    assert written("R_T of x") == '[#"R"#sub("T")#" of x"]'
    assert "".join(base + low for base, low in pieces('"R_T" of')) == '"RT" of'
    assert "R_T" not in markup_of("R_T is high")


def markup_of(text):
    from vasowave.study.report import Paragraph, Report, Section

    return markup(Report("report", "Mice", "two", "", [Section("one", "One", [Paragraph(text)])]))


def test_a_file_of_matplotlib_has_them_too_and_the_figure_is_left_as_it_was():
    with style():
        figure = new_figure(6, 4)
        ax = label_axes(figure.subplots(), "R_T of $x$ [mmHg s/ml]", "share [1]")
        with_sign = as_file(figure, "png")
        assert ax.get_xlabel() == "R_T of $x$ [mmHg s/ml]"
        ax.set_xlabel("R_T of $x$ [mmHg s/ml]".replace("_", ""))
        assert as_file(figure, "png") != with_sign
