"""The Explorer and the Figure desk: a model under the hand, all animals, and figures that Python draws again."""

import json
import re
import shutil

import numpy as np
import pytest
from served import served

import vasowave as vw
from made_posterior import with_posterior
from vasowave.base import InputError
from vasowave.study.animal import stored_model, stored_recording, to_bytes
from vasowave.study.folder import StudyFile
from vasowave.study.results import ResultStore, write_results
from vasowave.workbench import Desk, Explorer, posterior_draws


def moved(folder, animal, law, **values):
    """Return the pressure at the inlet that `vasowave` simulates with other values, mmHg."""
    result = vw.read_results(folder)[animal]
    model, recording = stored_model(result, law), stored_recording(result)
    return vw.sweep(model, recording, {name: [value] for name, value in values.items()}, samples=128).root_pressure


@pytest.mark.parametrize(("animal", "law"), [("CTL 0", "linear"), ("CTL 1", "tangent")])
def test_what_a_slider_shows_is_what_a_sweep_of_the_stored_model_gives(kept_results, animal, law):
    """A tree, and vessels that join again."""
    explorer, desk = Explorer(), Desk(kept_results)
    knobs = {one["name"]: one["value"] for one in explorer.described(desk, animal, law)["knobs"]}
    values = {"R_T": 1.3 * knobs["R_T"], "radius": 1.1}
    shown = explorer.simulated(desk, animal, law, values)
    expected = moved(kept_results, animal, law, **values).values.ravel()
    np.testing.assert_allclose(shown["pressure"], expected, atol=0.02)
    assert shown["indices"]["mPAP"] > 1.1 * explorer.simulated(desk, animal, law, {})["indices"]["mPAP"]


def test_what_would_change_is_what_the_sliders_show_with_an_interval_about_it(kept_results):
    explorer, desk = Explorer(), Desk(kept_results)
    knobs = {one["name"]: one["value"] for one in explorer.described(desk, "CTL 0", "linear")["knobs"]}
    values = {"R_T": 0.7 * knobs["R_T"], "radius": 1.05}
    answer = explorer.predicted(desk, "CTL 0", "linear", values)
    before, after, change, low, high = answer["rows"]["mPAP"]
    assert before == pytest.approx(explorer.simulated(desk, "CTL 0", "linear", {})["indices"]["mPAP"], rel=1e-3)
    assert after == pytest.approx(explorer.simulated(desk, "CTL 0", "linear", values)["indices"]["mPAP"], rel=1e-3)
    assert low <= change <= high < 0
    assert answer["units"]["mPAP"] == "mmHg"
    with pytest.raises(InputError, match="move a slider first"):
        explorer.predicted(desk, "CTL 0", "linear", {"R_T": knobs["R_T"]})


def test_vessels_that_join_again_are_drawn_so_and_all_have_numbers(kept_results):
    explorer, desk = Explorer(), Desk(kept_results)
    axes = np.array(explorer.described(desk, "CTL 1", "linear")["tree"]["axes"])
    shown = explorer.simulated(desk, "CTL 1", "linear", {})
    assert axes.shape == (6, 2, 3)
    np.testing.assert_allclose(axes[4, 0], axes[5, 1], atol=1e-4)  # the one across ends where the other branch goes on
    assert {len(one) for one in shown["vessels"].values()} == {6}
    flow = np.array(shown["vessels"]["mean flow [ml/s]"])
    assert flow[1] == pytest.approx(flow[3] + flow[5], rel=1e-3)  # what comes in goes on, and across


def test_the_flow_of_every_vessel_and_of_the_root_wherever_it_stands_is_that_of_the_simulation(kept_results):
    explorer, desk = Explorer(), Desk(kept_results)
    shown = explorer.simulated(desk, "CTL 0", "tangent", {})
    stored = vw.read_results(kept_results)["CTL 0"].laws["tangent"].simulation
    expected = stored["flow"].sel(station="middle").mean("time").values
    np.testing.assert_allclose(shown["vessels"]["mean flow [ml/s]"], expected, rtol=1e-3)
    assert shown["vessels"]["mean flow [ml/s]"][2] == pytest.approx(
        sum(shown["vessels"]["mean flow [ml/s]"][:2]), rel=1e-3
    )
    inlet = stored["flow"].sel(vessel="1", station="inlet")
    assert np.mean(shown["flow"]) == pytest.approx(float(inlet.mean()), rel=1e-3)
    assert np.ptp(shown["flow"]) == pytest.approx(float(np.ptp(inlet.values)), rel=0.01)


@pytest.fixture(scope="module")
def band(kept_results):
    """What is drawn about the fit of an animal."""
    return Explorer().band(Desk(kept_results), "CTL 0", "tangent")


def test_the_band_is_that_of_the_models_that_are_walked_through(kept_results, band):
    explorer, desk, found = Explorer(), Desk(kept_results), band
    pressures = np.array([one["pressure"] for one in found["draws"]["curves"]])
    assert found["draws"]["count"] == len(pressures) == 40
    low, high = np.array(found["band"]["pressure"])
    np.testing.assert_allclose([low, high], np.percentile(pressures, (2.5, 97.5), axis=0))
    for k in (0, 17):  # each is what its values simulate
        values = {name: list_[k] for name, list_ in found["draws"]["values"].items()}
        again = explorer.simulated(desk, "CTL 0", "tangent", values)
        np.testing.assert_allclose(again["pressure"], pressures[k], atol=0.02)


def test_draws_of_a_posterior_are_walked_through_as_they_are_stored(kept_results):
    result = with_posterior(vw.read_results(kept_results)["CTL 0"])
    posterior = result.laws["linear"].posterior
    walked = posterior_draws(posterior)
    assert (walked["kind"], walked["count"]) == ("draws of the posterior", 100)
    stored = posterior.draws("stiffness").ravel()
    assert set(walked["values"]["stiffness"]) <= {float(f"{one:.6g}") for one in stored}
    assert walked["values"]["stiffness"][0] == pytest.approx(stored[0], rel=1e-5)
    assert walked["values"]["stiffness"][-1] == pytest.approx(stored[-1], rel=1e-5)


DRAWN = "Number(document.querySelector('[data-panel=pressure]')?.dataset.drawn)"


def opened(program, door, desk):
    page = program.page(f"{door.origin}{door.root}#{desk}")
    return page


def index(page, name, kind="index"):
    return float(page.js(f"document.querySelector('[data-{kind}={name}]').textContent"))


def slide(page, key, value):
    page.js(
        f"(() => {{ const one = document.querySelector('[data-key={json.dumps(key)}]'); one.focus(); "
        f"one.value = {value}; one.dispatchEvent(new Event('input')); }})()"
    )


def test_a_slider_moves_the_model_and_back_to_the_fit_undoes_it(program, kept_results, band):
    with served(kept_results) as door:
        page = opened(program, door, "explorer/CTL%200/tangent")
        page.until(f"{DRAWN} > 1")
        fit = index(page, "mPAP")
        page.js("document.querySelector('[data-knob=R_T]').focus()")
        for _ in range(8):
            page.key("PageUp", windowsVirtualKeyCode=33)
        page.until(f"Number(document.querySelector('[data-index=mPAP]').textContent) > {1.05 * fit}")
        out = "document.querySelector('[data-knob=R_T]').closest('.knob').querySelector('output').textContent"
        value = float(page.js(out).split()[0])
        expected = moved(kept_results, "CTL 0", "tangent", R_T=value).mean()
        page.until(
            f"Math.abs(Number(document.querySelector('[data-index=mPAP]').textContent) - {float(expected)}) < 0.03"
        )
        page.click_text("What would change?")
        page.until("document.querySelector('tr[data-predicted=mPAP]')")
        after = page.js("document.querySelector('tr[data-predicted=mPAP]').children[2].textContent")
        assert float(after) == pytest.approx(float(expected), abs=0.03)
        page.click_text("Back to the fit")
        page.until(f"Number(document.querySelector('[data-index=mPAP]').textContent) === {fit}")
        page.choose("[data-key=beside]", "HPH 2")
        page.until("document.querySelector('[data-other=mPAP]')")
        other = Explorer().simulated(Desk(kept_results), "HPH 2", "tangent", {})["indices"]["mPAP"]
        assert index(page, "mPAP", "other") == pytest.approx(other, rel=1e-3)
        page.until("Number(document.querySelector('[data-tree=\"HPH 2\"]').dataset.drawn) > 0")
        before = page.js("document.querySelector('[data-tree=\"HPH 2\"]').dataset.drawn")
        slide(page, "moment", 12)
        page.until(f"document.querySelector('[data-tree=\"HPH 2\"]').dataset.drawn !== '{before}'")
        assert page.js("document.querySelector('[data-key=colored]').value") == "pressure [mmHg] now"
        page.until("document.querySelector('[data-key=draw]')")
        slide(page, "draw", 3)
        page.until("document.querySelector('[data-drawn=R_T]')")
        drawn = band["draws"]["values"]["R_T"][2]
        assert index(page, "R_T", "drawn") == pytest.approx(drawn, rel=1e-3)
        assert page.errors == []


ROWS = "[...document.querySelectorAll('.points tbody tr')].map(one => [...one.children].map(cell => cell.textContent))"


@pytest.mark.validation
def test_groups_and_sources_go_on_and_off_and_the_table_says_what_the_results_say(program, kept_results):
    table = vw.read_results(kept_results).table().query("quantity == 'R_T'").set_index(["animal", "law"])["value"]
    with served(kept_results) as door:
        page = opened(program, door, "explorer/CTL%200/linear")
        page.until(f"{DRAWN} > 1")
        page.choose("[data-key=quantity]", "R_T")
        page.until(f"{ROWS}.some(one => one[0] === 'mean CTL')")
        rows = page.js(ROWS)
        assert [one[0] for one in rows] == ["CTL 0", "CTL 1", "mean CTL", "HPH 2"]  # one animal has no mean
        for name, _, _, value, _ in rows:
            if not name.startswith("mean"):
                assert float(value) == pytest.approx(table[name, "linear"], rel=1e-3)
        low, high = sorted(float(one[3]) for one in rows[:2])
        assert low < float(rows[2][3]) < high
        page.click("[data-key='show tangent wall']")
        page.until(f"{ROWS}.length === 8")
        page.click("[data-key='show HPH']")
        page.until(f"{ROWS}.length === 6")
        assert {one[1] for one in page.js(ROWS)} == {"CTL"}
        page.click("[data-key='show logarithmic']")
        page.click("details summary")
        page.click_text("CTL 1", ".points td")
        page.until("document.querySelector('[data-key=animal]')?.value === 'CTL 1'")
        assert page.errors == []


@pytest.mark.validation
def test_a_result_that_its_row_left_behind_says_so_on_every_desk(program, ran):
    with served(ran) as door:
        page = opened(program, door, "explorer/CTL%200/linear")
        page.until(f"{DRAWN} > 1")
        assert "outdated" not in page.js("document.body.innerText")
        door.act("set-cells", animal="CTL 0", cells={"wedge [mmHg]": "2"})
        page.until("document.querySelector('.old')?.textContent.startsWith('outdated')")
        page.js("location.hash = 'figures/CTL%200'")
        page.until("document.body.dataset.ready === 'figures' && document.querySelector('.old')")
        assert page.errors == []


@pytest.mark.validation
def test_the_line_of_python_draws_the_figure_of_the_page_again(program, kept_results, tmp_path, monkeypatch):
    with served(kept_results) as door:
        page = opened(program, door, "figures/HPH%202")
        page.until("document.querySelector('img.preview')?.dataset.drawn === '1'")
        color = page.js("document.querySelector('[data-key=color]').value")
        assert color == "#d6259b"  # of its group, as in the report
        page.click("[data-key='panel flow']")
        page.type("[data-key=width]", "120")
        page.choose("[data-key=family]", "serif")
        page.until("document.querySelector('code.line').textContent.includes(\"'serif'\")")
        line = page.js("document.querySelector('code.line').textContent")
        picture = "document.querySelector('img.preview')"
        page.until(f"Math.abs({picture}.naturalWidth - 2 * {picture}.naturalHeight) < 3")
        assert page.errors == []
        given = {"animal": "HPH 2", "panels": ["pressure", "flow", "impedance"], "width": 120, "height": 60, "font": 8,
                 "family": "serif", "color": "#d6259b"}  # fmt: skip
        files = {kind: door.raw("POST", door.root + "figure", json.dumps(given | {"format": kind}).encode())[2]
                 for kind in ("svg", "pdf", "png")}  # fmt: skip
    monkeypatch.chdir(tmp_path)
    exec(line, {})
    shown = (tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert shown == files["svg"].decode()
    points = 72 / 25.4
    width, height = map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', shown).groups())
    assert (width, height) == pytest.approx((120 * points, 60 * points), abs=0.01)
    assert "#d6259b" in shown
    assert "serif" in shown
    assert files["pdf"].startswith(b"%PDF")
    assert files["png"].startswith(b"\x89PNG")


@pytest.mark.validation
def test_the_figure_of_two_groups_is_that_of_their_line_of_python(cohort_results, kept_results, tmp_path, monkeypatch):
    store, pieces = ResultStore(tmp_path / "results"), {}
    for number, one in enumerate(reversed(cohort_results)):  # the reference is the first group, not the first file
        pieces[one.name, one.group] = store.keep(f"{number}", to_bytes(one.to_datatree()))
    write_results(tmp_path / "results", pieces, {}, StudyFile(groups=["CTL", "HPH"]))
    shutil.copy(kept_results / "study.yaml", tmp_path)
    shutil.copy(kept_results / "animals.csv", tmp_path)
    with served(tmp_path) as door:
        line = door.post("figure", {"group": "HPH", "only": "line"})[1]["line"]
        content = door.raw("POST", door.root + "figure", json.dumps({"group": "HPH", "format": "svg"}).encode())[2]
    monkeypatch.chdir(tmp_path)
    exec(line, {})
    assert (tmp_path / "figure.svg").read_text(encoding="utf-8") == content.decode()
    assert "mPAP" in content.decode()


def test_a_figure_that_cannot_be_is_refused_in_a_sentence(kept_results):
    wish = {"animal": "CTL 0", "panels": ["pressure"], "format": "svg"}
    with served(kept_results) as door:
        wrongs = {"is no color": {"color": "javascript:x"}, "no font": {"family": "No Such Font"},
                  "panels": {"panels": []}, "width": {"width": 1e9}, "no result": {"animal": "no"},
                  "no group 'no'": {"animal": "", "group": "no"}}  # fmt: skip
        for said, wrong in wrongs.items():
            status, answer = door.post("figure", wish | wrong)
            assert status == 400
            assert said in answer["error"]


def test_every_curve_of_a_figure_has_the_color_that_was_chosen_and_laws_differ_by_their_dashes(kept_results):
    wish = {"animal": "CTL 0", "panels": ["pressure", "residuals", "pressure_area"], "format": "svg"}
    with served(kept_results) as door:
        root = door.root + "figure"
        drawn = door.raw("POST", root, json.dumps(wish | {"color": "#ff0000"}).encode())[2].decode()
    strokes = re.findall(r'style="fill: none;([^"]*)"', drawn)
    colors = {found for one in strokes for found in re.findall(r"stroke: (#[0-9a-f]{6})", one)}
    assert "#ff0000" in colors
    assert "#8c0000" not in colors
    assert {"stroke-dasharray" in one for one in strokes if "#ff0000" in one} == {True, False}
