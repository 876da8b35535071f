"""Every sentence of the answer of a study, held against the numbers of the study."""

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

import vasowave
from vasowave.cli.app import app
from vasowave.study.cohort import primary_comparison
from vasowave.study.entering import write_virtual_study
from vasowave.study.report import report_of
from vasowave.study.results import Results

NAMES = {
    "mean pressure": "mPAP", "cardiac output": "CO", "vascular resistance": "PVR",
    "characteristic impedance": "measured_Z_c", "pulse pressure / stroke volume": "pPAP_over_SV",
    "large arteries": "stiffness", "wall stiffness": "stiffness", "waves": "wave_speed", "wave speed": "wave_speed",
    "total compliance": "measured_C_T", "compliance of the beds": "C_p", "model time constant": "tau",
    "proximal resistance share": "a", "wave reflection": "measured_I_R", "model wave reflection": "I_R",
}  # fmt: skip
MORE = "higher|stiffer|faster|stronger|longer|larger"
LESS = "lower|softer|slower|weaker|shorter|smaller"
NUMBER = r"\d+(?:\.\d+)?(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
EFFECT = re.compile(
    rf"(?:and )?(?P<words>[a-z][a-z /]*[a-z]) (?P<symbol>\S+(?: C_T)?)(?: \(measured\))? "
    rf"(?P<first>{NUMBER}) → (?P<second>{NUMBER})"
    rf"[^(]*\((?P<ratio>{NUMBER}) times \[(?P<low>{NUMBER}), "
    rf"(?P<high>{NUMBER})\], p (?P<how>[=≈≤]) (?P<p>{NUMBER})\)"
)
USUAL = {"radii": "5 %", "lengths": "5 %", "exponent of stiffness along the tree": "0.5", "taper of vessels": "10 %",
         "gain of the flow": "5 %", "zero of the pressure": "0.5 mmHg"}  # fmt: skip
STATED = {"radii": "3 %", "lengths": "2 %", "exponent of stiffness along the tree": "0.3", "gain of the flow": "2 %",
          "zero of the pressure": "0.4 mmHg"}  # fmt: skip
STUDIES = {
    "default": {},
    "told": {
        "radius_scale_sd": 0.03, "length_scale_sd": 0.02, "k_sd": 0.3, "taper_sd": 0.0, "flow_gain_sd": 0.02,
        "zero_sd": 0.4, "report": {"lung_sd": 0.02},
    },
    "posterior": {"inference": "posterior"},
}  # fmt: skip


@dataclass
class Study:
    """Answers of a study by their questions, its results, and how it was set."""

    answers: dict[str, str]
    results: Results
    truth: pd.DataFrame
    kind: str

    @cached_property
    def rows(self):
        return self.results.compare("HPH").table.set_index("quantity")

    def sentences(self, *questions):
        return [one for question in questions for one in re.split(r"(?<=\.) (?=[A-Z])", self.answers[question])]


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=pytest.mark.validation if name == "default" else pytest.mark.weekly)
        for name in STUDIES
    ],
)
def study(request, tmp_path_factory):
    """Return the answers of a study of 7 + 5 virtual mice by their questions, its results and its settings."""
    folder = tmp_path_factory.mktemp("study") / request.param
    write_virtual_study(folder, starts=1)
    settings = yaml.safe_load((folder / "study.yaml").read_text())
    for key, value in STUDIES[request.param].items():
        settings[key] = {**settings.get(key, {}), **value} if isinstance(value, dict) else value
    settings["calibration"]["walls"] = ["linear"]
    (folder / "study.yaml").write_text(yaml.safe_dump(settings))
    done = CliRunner().invoke(app, ["run", str(folder), "--no-pdf"])
    assert done.exit_code == 0, done.output
    truth = pd.read_csv(folder / "truth.csv", comment="#", index_col="animal")
    results = vasowave.read_results(folder)
    cohort, family = results.gathered(results.in_order(), "CTL"), results.settings.report
    answers = report_of(cohort, primary_comparison(cohort, family), family).answers()
    return Study({question.rstrip("?"): text for question, text in answers}, results, truth, request.param)


def near(text, value):
    """Whether a value was written as `text`."""
    digits = text.split(".")[1] if "." in text else ""
    return abs(float(text) - value) <= 0.51 * 10.0 ** -len(digits)


def named(text, sign=None):
    """Return quantities of a list in words, ``a (× 1.2), b and c``, with what stands behind each."""
    parts = re.split(r", | and ", text)
    found = [re.fullmatch(rf"(.+?)(?: \(× ({NUMBER})(?: by the model)?\))?", part).groups() for part in parts]
    return {NAMES[words]: (size, sign) for words, size in found}


def directed(sentence):
    """Return quantities of ``Higher a and b and lower c in HPH than in CTL.`` with sizes and directions."""
    text = sentence.removesuffix(" in HPH than in CTL.")
    parts = re.split(rf"(?:^| and |, )({MORE}|{LESS}) ", f"{text[0].lower()}{text[1:]}")[1:]
    each = zip(parts[::2], parts[1::2], strict=True)
    return {key: value for how, what in each
            for key, value in named(what, 1 if re.fullmatch(MORE, how) else -1).items()}  # fmt: skip


def test_the_first_sentences_name_what_is_shown_its_direction_and_size_and_all_that_is_open(study):
    rows = study.rows
    shown = {*rows.index[rows["p"] < 0.05]}
    first, *rest, assumed = study.sentences("The answer")
    assert assumed == "Vascular resistance is over an assumed outflow pressure of 0 mmHg."
    if shown:
        effects = directed(first)
        assert {*effects} == shown
        assert first.count(" by the model)") == (rows.source[[*shown]] != "measured").sum()
        for name, (size, sign) in effects.items():
            assert near(size, rows.ratio[name])
            assert sign * np.log(rows.ratio[name]) > 0
    else:
        assert first == "No difference between HPH and CTL is shown."
    left = {}
    for sentence in rest:
        kind, what = re.fullmatch(r"(Undecided|No effect larger than) ([^:]+: .+)\.", sentence).groups()
        note, names = what.split(": ")
        left |= dict.fromkeys(named(names), kind)
        assert kind != "Undecided" or note == "(neither shown nor excluded)"
    assert {*left} == {*rows.index} - shown
    small = {name for name in left if rows.low[name] >= 0.8 and rows.high[name] <= 1.25}
    assert small == {name for name, kind in left.items() if kind != "Undecided"}


def test_every_effect_is_of_the_animals_and_its_interval_excludes_none_exactly_if_p_is_small(study):
    rows, table = study.rows, study.results.table()
    text = " ".join(study.answers[one] for one in ("Pressure and flow", "Large arteries", "Small vessels", "Waves"))
    effects = {"I_R" if one["words"] == "model wave reflection" else NAMES[one["words"]]: one
               for one in EFFECT.finditer(text)}  # fmt: skip
    assert {*effects} == {*rows.index}
    for name, one in effects.items():
        row = rows.loc[name]
        for key, value in (("ratio", row.ratio), ("low", row.low), ("high", row.high)):
            assert near(one[key], value), (name, key)
        assert (row.low > 1 or row.high < 1) == (row.p < 0.05)
        assert near(one["p"], row.p) or one["how"] == "≤"
        of_model = name.removeprefix("measured_") if name.startswith("measured_") else name
        source = "measured" if row.source == "measured" else "linear"
        values = table[(table["quantity"] == of_model) & (table["law"] == source)].set_index("animal")["value"]
        if len(values):
            for group, written in (("CTL", one["first"]), ("HPH", one["second"])):
                own = values[[animal.startswith(group) for animal in values.index]].astype(float)
                assert own.min() <= float(written) * 1.005
                assert own.max() >= float(written) * 0.995


def test_each_question_says_in_words_what_its_effects_show(study):
    rows = study.rows
    for question in ("Pressure and flow", "Large arteries", "Small vessels", "Waves"):
        first = study.sentences(question)[0]
        of_question = rows[rows["question"] == question]
        shown = of_question.index[of_question["p"] < 0.05]
        if len(shown):
            assert {name: sign for name, (_, sign) in directed(first).items()} == {
                name: int(np.sign(np.log(rows.ratio[name]))) for name in shown
            }
        else:
            assert first.startswith(("Undecided between HPH and CTL", "No effect larger than"))


def test_every_true_ratio_is_inside_its_interval(study):
    truth, rows = study.truth, study.rows
    logs = np.log(truth.drop(columns="group")).groupby(truth["group"]).mean()
    ratio = np.exp(logs.loc["HPH"] - logs.loc["CTL"])
    pairs = {"stiffness": "beta [mmHg]", "C_p": "C_p [ml/mmHg]", "a": "a [1]", "CO": "CO [ml/s]",
             "PVR": "R_T [mmHg s/ml]"}  # fmt: skip
    for name, column in pairs.items():
        assert rows.low[name] < ratio[column] < rows.high[name], name


def test_the_answer_rests_on_the_errors_that_were_told_and_on_usual_ones_for_the_rest(study):
    text = study.answers["What does this rest on"]
    assert "Each group has one imaged lung" in text
    errors = re.search(r"allow for these errors \(SD\): (.+?)\. [A-Z]", text)[1]
    usual = (USUAL, "usual values; the study gives none")
    sizes, source = {"default": usual, "told": (STATED, "stated"), "posterior": usual}[study.kind]
    assert errors.endswith(f" ({source})")
    found = re.findall(r"(?:^|, | and )([a-z ]+?) ([0-9.]+(?: %| mmHg)?)(?=,| and | \()", errors)
    assert dict(found) == sizes
    share = {"default": "9.0 % between lungs of one group (SD; a usual value", "posterior": "9.0 %",
             "told": "2.0 % between lungs of one group (SD; stated)"}[study.kind]  # fmt: skip
    assert f"Radii are taken to differ by {share}" in text


def test_lungs_that_differ_as_much_as_is_said_turn_an_effect(study):
    tipping = re.findall(rf"(?:and )?([a-z][a-z ]+[a-z]) \S+(?: C_T)? \((above|below) ({NUMBER}) %\)",
                         study.answers["What does this rest on"])  # fmt: skip
    assert tipping
    for words, side, share in tipping:
        shown = [study.results.compare("HPH", lung_sd=0.01 * float(share) * factor).table.set_index("quantity")
                 .p[NAMES[words]] < 0.05 for factor in (0.9, 1.1)]  # fmt: skip
        assert shown == [True, False], (words, side)


def test_chances_of_a_false_finding_are_those_of_the_design_and_one_wall_is_said_to_be_one(study):
    text = study.answers.get("How sure is this", "")
    chances = re.findall(r"\bin (\d+)(?: to (\d+))? if", text)
    assert chances[0] == ("5", "")
    assert all(float(low) > 6 for low, _ in chances[1:])
    assert study.answers["Which wall"].startswith(
        "Only the linear wall was fitted" if study.kind != "posterior" else ""
    )
