"""A lab's design from continuous recordings to the page: sex, litters, pairs and two probes in one table."""

import numpy as np
import pytest
from typer.testing import CliRunner

from lab_files import SMALL, exported, recorded
from vasowave.cli import app
from vasowave.pulse.network import write_network
from vasowave.study.cohort import primary_comparison
from vasowave.study.results import read_results

pytestmark = [pytest.mark.usefixtures("undrawn"), pytest.mark.validation]

STUDY = """\
groups: [WT, HOX]
calibration: {walls: [linear], starts: 1, fixed: {c1: 1.0, r1: 1.0}}
model_selection: false
flow_gain_sd: 0.07
numerics: {cell_size: 0.45}
design: {covariates: [sex], blocks: [litter], subject: mouse, occasion: time}
report: {pdf: false, quantities: [mPAP, PVR, R_T]}
"""
DRUG, HYPOXIA = 0.75, 1.8  # what they do to the pressures
ANIMALS = [f"{group}{number}" for group in ("WT", "HOX") for number in range(3)]


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Six mice of three litters, before and after a drug that lowers the pressure, which hypoxia has raised."""
    folder = tmp_path_factory.mktemp("design")
    write_network(SMALL, folder / "n.csv")
    (folder / "study.yaml").write_text(STUDY, "utf-8")
    rng, rows = np.random.default_rng(3), ["animal,group,network,recording,sex,litter,mouse,time,probe"]
    for place, mouse in enumerate(ANIMALS):
        own, group = float(np.exp(0.03 * rng.standard_normal())), mouse.rstrip("012")
        for time in ("before", "after"):
            noise = float(np.exp(0.02 * rng.standard_normal()))
            mean = 15 * own * noise * (HYPOXIA if group == "HOX" else 1) * (DRUG if time == "after" else 1)
            name = f"{mouse} {time}"
            (folder / f"{name}.txt").write_text(exported(recorded(10 * place + len(time), mean, duration=7.0)), "utf-8")
            rows.append(f"{name},{group},n.csv,{name}.txt,{'fm'[place % 2]},L{place % 3},{mouse},{time},P{place % 2}")
    (folder / "animals.csv").write_text("\n".join(rows) + "\n", "utf-8")
    for command in ("check", "run"):
        done = CliRunner().invoke(app, [command, str(folder)])
        assert done.exit_code == 0, done.output
        assert ("Recordings 12; wall laws linear" if command == "check" else "12 recordings") in done.output
    answer, page = done.output.index("\nThe answer: "), done.output.index("\nReport: ")
    assert answer < page  # a run ends with what it found, and where it stands
    assert len(done.output[done.output.index("12 recordings computed") :].strip().splitlines()) <= 15
    assert "How sure is this?" not in done.output  # which the page says
    return folder


def test_the_page_says_what_the_design_says(study):
    page = (study / "report" / "report.html").read_text("utf-8")
    assert "Ratios and means of groups are adjusted for sex: they are those of groups with the same mean of it" in page
    assert "one litter (of 3: L0, L1 and L2) may be alike (random effects)" in page
    assert "the 12 recordings are of 6 animals (column mouse), whose own level is a random effect" in page
    assert "time (before and after; compared with before) is a second factor" in page
    assert "12 recordings of 6 animals in 2 groups: WT, HOX" in page
    assert "WT (n = 3)" in page
    assert "One animal moves an effect most" in page
    assert "12 of 12 recordings done" in CliRunner().invoke(app, ["status", str(study)]).output
    assert "Mann-Whitney" not in (study / "report" / "supplement.html").read_text("utf-8")


def test_what_was_done_to_the_animals_is_what_the_comparison_finds(study):
    rows = read_results(study).compare("HOX", "WT").table.set_index(["quantity", "what"])
    mPAP = rows.loc[("mPAP", "groups")]
    assert mPAP["low"] < HYPOXIA < mPAP["high"]  # wide: three mice a group leave few degrees of freedom
    assert mPAP["ratio"] == pytest.approx(HYPOXIA, rel=0.1)
    stored = read_results(study)
    every = primary_comparison(stored.gathered(stored.in_order(), "WT"), stored.settings.report).table()
    (drug,) = every[(every["quantity"] == "mPAP") & (every["other"] == "time after")].to_dict("records")
    assert drug["low"] < DRUG < drug["high"]
    assert drug["ratio"] == pytest.approx(DRUG, rel=0.05)  # within each mouse, so that its own level does not matter


def test_the_gain_of_the_probes_is_known_of_resistances_and_shared(study):
    stored = read_results(study)
    PVR = stored["WT0 before"].measured.quantities["PVR"]
    assert PVR.attrs["standard_error"] / float(PVR) == pytest.approx(0.07, rel=0.02)
    assert PVR.attrs["share_probe"] == pytest.approx(1.0)
    assert {one.label: one.order for one in stored.variables}["probe"] == ["P0", "P1"]
