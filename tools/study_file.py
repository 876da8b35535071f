"""List every key of study.yaml and every column of animals.csv for docs/study-file.md.

uv run python tools/study_file.py           writes the page anew
"""

from pathlib import Path

from vasowave.base.settings import Setting, settings_of, summary
from vasowave.study.entering import written
from vasowave.study.folder.animal_columns import COLUMNS, REQUIRED_COLUMNS
from vasowave.study.folder.settings import StudyFile

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


def keys_table() -> str:
    """Return a table (Markdown) of every key of ``study.yaml``."""
    lines = ["| key | default | meaning |", "|---|---|---|"]
    for name, setting in settings_of(StudyFile).items():
        if setting.section:
            lines.append(f"| **`{name}`** | | {summary(setting.section)} |")
            for key, inner in settings_of(setting.section).items():
                lines.append(f"| `{name}.{key}` | {_default(inner)} | {inner.meaning} |")
        else:
            lines.append(f"| `{name}` | {_default(setting)} | {setting.meaning} |")
    return "\n".join(lines) + "\n"


def columns_table() -> str:
    """Return a table (Markdown) of every column of ``animals.csv``."""
    lines = ["| column | what it holds |", "|---|---|"]
    lines += [
        f"| `{title}`{' (needed)' if title in REQUIRED_COLUMNS else ''} | {column.meaning} |"
        for title, column in COLUMNS.items()
    ]
    return "\n".join(lines) + "\n"


def _default(setting: Setting) -> str:
    return "empty" if setting.default is None else f"`{written(setting.default)}`"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
