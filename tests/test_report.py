import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

from made_fit import made_fit
from vasowave.animal.datasets import groups
from vasowave.errors import InputError
from vasowave.figures import tree
from vasowave.figures.gallery import gallery, svg
from vasowave.figures.network import layout
from vasowave.report import summary, wording, write_report
from vasowave.results import write_results


@pytest.fixture(scope="module")
def fits():
    return made_fit("linear"), made_fit("tangent")


@pytest.fixture(scope="module")
def folder(fits, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report") / "mouse"
    write_results(fits, folder)
    write_report(fits, folder)
    return folder


@pytest.fixture(scope="module")
def figures(fits):
    return gallery(tree_of(fits))


def tree_of(fits):
    return xr.DataTree.from_dict({f"/{name}": dataset for name, dataset in groups(fits).items()})


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


class Page(HTMLParser):
    """Collects the tables' rows, all ids and all addresses of a page."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.ids, self.addresses, self.open = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.ids += [values["id"]] if "id" in values else []
        self.addresses += [values[key] for key in ("src", "href", "xlink:href", "action") if key in values]
        if tag == "tr":
            self.rows.append([])
        self.open.append(tag)

    def handle_endtag(self, tag):
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, text):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1].append(text)


def test_the_page_shows_the_values_of_the_fits(fits, page):
    rows = {row[0]: row for row in Page(page).rows if row}
    for column, fit in enumerate(fits):
        assert float(rows["total resistance R_T"][2 + column]) == pytest.approx(fit.total_resistance, rel=5e-3)
        assert float(rows["resistance ratio a = R1/R_T"][2 + column]) == pytest.approx(
            100 * fit.resistance_ratio, rel=5e-3
        )
        assert float(rows["RMSE"][2 + column]) == pytest.approx(fit.rmse, rel=5e-3)
    assert float(rows["beta"][4]) == pytest.approx(0.3), "the last table with a row beta is the correlation"
    assert f"stiffness β = {fits[0].parameters.loc['beta', 'value']} ± 17 mmHg" in page
    assert f"Mean pressure {fits[0].recording.mean_pressure:.1f} mmHg" in page


def test_the_page_refers_to_nothing_outside_itself(page):
    assert all(address.startswith("#") for address in Page(page).addresses)
    assert not re.search(r"https?:|//\w|@import|<script|<link|<iframe|url\((?!#)", page)


def test_the_ids_of_the_embedded_figures_are_unique_and_resolved(page):
    found = Page(page)
    assert len(found.ids) == len(set(found.ids)) > 100
    used = set(re.findall(r"url\(#([^)]+)\)", page)) | {address[1:] for address in found.addresses}
    assert used
    assert used <= set(found.ids)


def test_synthetic_data_carry_a_banner_and_measured_data_do_not(page, tmp_path):
    assert "Synthetic data." in page
    measured = write_report([made_fit("linear", source="mouse6_p.dat and mouse6_q.dat")], tmp_path / "measured")
    assert "Synthetic data." not in measured.read_text(encoding="utf-8")


def test_a_source_with_markup_is_shown_as_text(tmp_path):
    path = write_report([made_fit("linear", source="<script>alert(1)</script>")], tmp_path / "mouse")
    assert "<script>" not in path.read_text(encoding="utf-8")


def test_disagreeing_starts_and_undetermined_parameters_are_said_in_words(fits):
    linear, tangent = (" ".join(summary.fit_sentences(fit)) for fit in fits)
    assert "All 4 starts" in linear
    assert "Only 3 of 4 starts" in tangent
    assert "do not determine r1" in tangent
    assert "Tangent wall: r1 is not determined by the data" in summary.warnings(fits)


def test_numbers_keep_their_digits():
    shown = [
        wording.number(value) for value in (52.07, 0.0, 1234.5, 0.00138, 1.3e-5, -2.0e7, 7, True, float("nan"), None)
    ]
    assert shown == ["52.1", "0", "1234", "0.00138", "1.30·10⁻⁵", "-2.00·10⁷", "7", "yes", "–", ""]


def test_the_figures_are_files_with_editable_text(folder):
    for name in ("fit", "nominal", "tree", "loop", "network"):
        text = (folder / "figures" / f"{name}.svg").read_text(encoding="utf-8")
        letters = "".join(ElementTree.fromstring(text).itertext())
        assert "mmHg" in letters or name == "network"
        assert (folder / "figures" / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_fit_gives_the_same_figure_to_the_last_byte(fits, figures):
    assert svg(gallery(tree_of(fits))["loop"]) == svg(figures["loop"])


def test_the_fit_figure_draws_the_data_of_both_walls_dashed_and_solid(fits, figures):
    pressure = figures["fit"].axes[0]
    measured, linear, tangent = pressure.get_lines()
    np.testing.assert_array_equal(measured.get_ydata()[:-1], fits[0].recording.pressure)
    assert tangent.get_linestyle() == "-"
    assert linear.get_linestyle() == "--"
    assert pressure.get_ylabel() == "pressure [mmHg]"


def test_the_fitted_decay_falls_by_e_in_one_time_constant(fits, figures):
    decay = figures["nominal"].axes[1].get_lines()[1]
    time, pressure = decay.get_data()
    slope = np.log(pressure[0] / pressure[-1]) / (time[-1] - time[0])
    assert 1 / slope == pytest.approx(fits[0].nominal.time_constant, rel=1e-12)
    np.testing.assert_allclose(np.mean(np.log(pressure)), np.mean(np.log(fits[0].nominal.decay[1])), rtol=1e-12)


def test_the_chosen_vessels_go_from_the_root_to_terminals_of_both_sides(fits):
    network = fits[0].model.network
    chosen = tree.main_vessels(network)
    assert chosen[:3] == ["1", "2", "3"]
    assert len(set(map(network.row, chosen)) & set(network.terminals.tolist())) == 2


def test_no_two_vessels_of_the_diagram_lie_on_each_other(fits):
    x, y = layout(fits[0].model.network)
    assert len(set(zip(x.tolist(), y.tolist(), strict=True))) == len(fits[0].model.network)


def test_a_folder_with_other_work_is_refused(fits, tmp_path):
    (tmp_path / "thesis.tex").write_text("ten years")
    with pytest.raises(InputError, match="not a vasowave result"):
        write_report(fits, tmp_path)
