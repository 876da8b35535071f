"""List the kinds of findings for docs/findings.md: code, what it asks of a person, its words, what to do.

uv run python tools/finding_codes.py           writes the page, as building the site does
"""

import importlib
import pkgutil
import re
from pathlib import Path

import vasowave
from vasowave.base import KINDS

PAGE = Path(__file__).parents[1] / "docs" / "findings.md"
ABOUT = """\
# Findings

What vasowave notices of files, recordings, networks, fits and posteriors has a code, numbers, a place and a severity;
its words are made from these. An *error* must be corrected before a study can run. A *look* asks a person to look:
`check` lists it, and commands warn of it. A *note* says how a number came about. Results keep code, severity, numbers,
place and words (attribute `findings` of the root and of the groups `recording`, `WALL/calibration` and
`WALL/inference`, JSON). No code looks into the words. `tools/finding_codes.py` makes this page when the site is built.

| code | severity | words | what to do |
|---|---|---|---|
"""


def load_all() -> None:
    """Load every module, so that all kinds are declared."""
    for module in pkgutil.walk_packages(vasowave.__path__, "vasowave."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)


def words(text: str) -> str:
    """Return a text of a kind with its values by name, without what to do."""
    text = re.sub(r"[;,]? ?\{remedy\}", "", text)
    return re.sub(r"\{(\w+)[^}]*\}", r"*\1*", text).replace("|", "/")


def page() -> str:
    """Return the page."""
    load_all()
    rows = (
        f"| `{code}` | {one.severity.value} | {words(one.text)} | {words(one.remedy)} |"
        for code, one in sorted(KINDS.items())
    )
    return ABOUT + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
