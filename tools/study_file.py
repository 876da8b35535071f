"""List every key of study.yaml and every column of animals.csv for docs/study-file.md.

uv run python tools/study_file.py           writes the page anew
"""

from pathlib import Path

from vasowave.study.entering import columns_table, keys_table

PAGE = Path(__file__).parents[1] / "docs" / "study-file.md"


def page() -> str:
    """Return the page."""
    return f"""\
# The study file

Every setting of a study and every column of its table, with what it means and its default.
[A study](study.md) says how they are filled in. `tools/study_file.py` makes this page
of what the program declares.

## Every key of study.yaml

{keys_table()}
## Every column of animals.csv

Any further column is yours.

{columns_table()}"""


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
