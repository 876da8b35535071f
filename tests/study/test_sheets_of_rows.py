"""Rows of files that are added: their channels, site and sheet."""

from made_workbook import saved, signals
from vasowave.study.entering import add_files, new_study


def test_rows_get_the_channels_that_their_files_have_the_site_and_the_sheet(tmp_path):
    for name, title in (("a", "Ch 3"), ("b", "Ch 4")):
        rows = signals(95, titles=("time [s]", f"{title} [mmHg]", "Aortic flow [ml/s]"))
        (tmp_path / f"{name}.csv").write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n")
    saved(tmp_path / "c.xlsx", A=signals(15), B=signals(12))
    new_study(tmp_path / "study")
    cells = {"pressure channel": "Ch 3", "site": "aorta", "sheet": "B"}
    rows = {row["animal"]: row for row in add_files(tmp_path / "study", [tmp_path], cells=cells).rows}
    assert rows["a"]["pressure channel"] == "Ch 3"
    assert rows["b"].get("pressure channel", "") != "Ch 3"
    assert {row["site"] for row in rows.values()} == {"aorta"}
    assert [name for name, row in rows.items() if row.get("sheet") == "B"] == ["c"]
