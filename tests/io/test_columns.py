"""Columns of a text table and their titles."""

import pytest

from vasowave.errors import InputError
from vasowave.io.columns import read_columns

ALIASES = {"pap": "pressure", "lap": "pressure"}


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("PAP [mmHg],LAP [mmHg]", r"'LAP \[mmHg\]' and 'PAP \[mmHg\]' are both read as pressure; leave out or rename"),
        ("PAP [mmHg],PAP [mmHg]", r"two columns are called 'PAP \[mmHg\]'; keep one of them"),
    ],
)
def test_two_columns_that_are_read_as_one_quantity_are_named_as_they_are_written(tmp_path, header, message):
    table = tmp_path / "a.csv"
    table.write_text(f"{header}\n1,2\n", "utf-8")
    with pytest.raises(InputError, match=message):
        read_columns(table, ALIASES).find("pressure")
