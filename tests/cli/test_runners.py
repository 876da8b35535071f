"""The programs that try vasowave do what they say: mutants, growth, the page of their tables."""

import ast

import pytest

import lines_of_tests
import load
import mutants
import planted_faults
import robustness_page


@pytest.fixture(scope="module")
def drawn():
    return mutants.drawn(12, 3)


def test_a_drawn_mutant_changes_one_line_and_still_is_python(drawn):
    assert len({(one.file, one.line) for one in drawn}) == 12
    for one in drawn:
        before, after = one.file.read_text(encoding="utf-8").splitlines(), one.source().splitlines()
        assert [n for n, pair in enumerate(zip(before, after, strict=True), 1) if pair[0] != pair[1]] == [one.line]
        ast.parse(one.source())


def test_every_kind_of_change_is_drawn(tmp_path):
    (tmp_path / "a.py").write_text("def f(x, y):\n    return not x < y and x + 2.5 == [True]\n")
    changes = {(one.old, one.new) for one in mutants.mutants_of(tmp_path / "a.py")}
    assert changes == {
        ("<", "<="),
        ("and", "or"),
        ("+", "-"),
        ("2.5", "5.0"),
        ("==", "!="),
        ("not ", ""),
        ("True", "False"),
    }


def test_the_tests_of_a_module_are_its_namesakes_first_and_never_none(drawn):
    names = [test.name for test in mutants.nearest_tests(mutants.SOURCE / "catheter" / "baseline" / "baseline.py")]
    assert names[0] == "test_baseline.py"
    assert "test_sensitivity.py" in [
        t.name for t in mutants.nearest_tests(mutants.SOURCE / "pulse" / "solver" / "node_variations.py")
    ]
    assert all(mutants.tests_of(one) for one in drawn[:2])


def test_growth_is_the_power_between_the_two_largest_studies():
    costs = {10: load.Cost(9.0, 9.0, 0.1), 100: load.Cost(4.0, 3.0, 0.1), 1000: load.Cost(40.0, 30.0, 0.2)}
    assert load.exponent(costs) == pytest.approx(1.0, rel=1e-12)
    assert "| 9.0 s (9), 0.10 GB | 4.0 s (3), 0.10 GB | 40.0 s (30), 0.20 GB | 1.00 |" in load.table({"report": costs})


def test_a_table_goes_between_its_marks_and_nowhere_else(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- x -->\nold\n<!-- end of x -->\nb\n")
    robustness_page.put("x", "| 1 |\n", page)
    assert page.read_text() == "a\n<!-- x -->\n| 1 |\n<!-- end of x -->\nb\n"
    with pytest.raises(ValueError, match="0 places for 'y'"):
        robustness_page.put("y", "", page)


def test_what_a_test_sets_up_for_its_file_is_recorded_for_all_of_the_file():
    said = ["src/a.py:7\tt.py::one (setup)", "src/a.py:8\tt.py::two (call)", "src/a.py:9\t"]
    found = lines_of_tests.lines_of(said, ["t.py::one", "t.py::two", "other.py::three"])
    assert found == {"src/a.py": {"7": ["t.py::one", "t.py::two"], "8": ["t.py::two"]}}


@pytest.mark.parametrize("name", ["inputs", "faults", "kills", "load", "mutants"])
def test_the_page_of_robustness_has_a_place_for_every_program(name):
    assert robustness_page.PAGE.read_text(encoding="utf-8").count(f"<!-- {name} -->") == 1


def test_every_planted_fault_fits_the_source():
    for fault in planted_faults.FAULTS:
        text = (planted_faults.ROOT / "src" / "vasowave" / fault.file).read_text(encoding="utf-8")
        for old, new in fault.edits:
            assert text.count(old) == 1, f"{fault.name}: write it anew"
            assert old != new
