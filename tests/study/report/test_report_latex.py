"""The tables of a report as LaTeX."""

import shutil
import subprocess

import pytest

from vasowave.study.report import Table, latex, latex_table


def test_latex_takes_no_character_for_a_command():
    assert latex("50 % of R_T & m_123 #1") == r"50 \% of $R_T$ \& m\_123 \#1"
    assert latex("8.1·10⁻⁴ ± 2 mmHg² β₀ †") == r"8.1$\cdot$10$^{-4}$ $\pm$ 2 mmHg$^{2}$ $\beta$$_{0}$ \dag{}"
    text = latex_table(Table("x", "A_b & c", ("a", "b"), [("1", "2 %"), ("3", "4")]))
    body = text.split("\\midrule")[1].split("\\bottomrule")[0].strip().splitlines()
    assert body == [r"1 & 2 \% \\", r"3 & 4 \\"]
    assert "$A_b$ \\& c" in text


def test_the_tables_compile_with_latex(cohort_report, tmp_path):
    program = shutil.which("pdflatex") or shutil.which("tectonic")
    if program is None:
        pytest.skip("neither pdflatex nor tectonic is on this machine")
    inputs = "\n".join(f"\\input{{{path}}}" for path in sorted((cohort_report / "tables").glob("*.tex")))
    (tmp_path / "all.tex").write_text(
        f"\\documentclass{{article}}\\usepackage{{booktabs}}\\usepackage{{amssymb}}\\begin{{document}}{inputs}\\end{{document}}"
    )
    done = subprocess.run(
        [program, "all.tex"], cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]


def test_the_letters_of_every_latex_table_are_plain(cohort_report):
    for path in (cohort_report / "tables").glob("*.tex"):
        odd = {letter for letter in path.read_text(encoding="utf-8") if ord(letter) > 127}
        assert not odd, f"{path.name}: {odd}"
