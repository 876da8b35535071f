"""Files and folders appear whole or not at all: in a study."""

import pandas as pd
import pytest

from vasowave.study.report import write_tables


@pytest.mark.parametrize(
    ("text", "cell"),
    [("=cmd|x", "'=cmd|x"), ("@A1", "'@A1"), ("+1+A2", "'+1+A2"), ("-1.5", "-1.5"), ("+2", "+2"), ("MPA", "MPA")],
)
def test_a_text_that_a_spreadsheet_would_run_is_written_as_text(tmp_path, text, cell):
    write_tables([], {"vessels": pd.DataFrame({"vessel": [text], "radius [cm]": [0.05]})}, tmp_path)
    assert (tmp_path / "vessels.csv").read_text() == f"vessel,radius [cm]\n{cell},0.05\n"
