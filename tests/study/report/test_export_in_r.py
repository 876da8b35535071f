"""The lines for R of the page on export, run as they stand there on the tables of a report."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "export.md"


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R is not installed (no Rscript)")
def test_r_reads_the_values_that_the_page_on_export_asks_for(cohort_report, tmp_path):
    lines = PAGE.read_text(encoding="utf-8").partition("In R:\n\n")[2].partition("\n\n")[0]
    snippet = re.sub(r"^    ", "", lines, flags=re.MULTILINE)
    (table,) = cohort_report.rglob("Estimates.csv")
    folder = tmp_path / "my-study" / "report" / "tables"
    folder.mkdir(parents=True)
    shutil.copy(table, folder)
    script = f"{snippet.replace('subset(', 'found <- subset(')}\nwrite.csv(found, 'found.csv', row.names = FALSE)\n"
    (tmp_path / "snippet.R").write_text(script, encoding="utf-8")
    done = subprocess.run(
        ["Rscript", "--vanilla", "snippet.R"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0, done.stderr
    expected = pd.read_csv(table)
    expected = expected[expected["parameter"] == "beta"]
    read = pd.read_csv(tmp_path / "found.csv")
    assert len(read) == len(expected) > 0
    numbers = [place for place, kind in enumerate(expected.dtypes) if kind.kind == "f"]
    np.testing.assert_allclose(read.iloc[:, numbers], expected.iloc[:, numbers], rtol=1e-12)
    assert read["animal"].tolist() == expected["animal"].tolist()
