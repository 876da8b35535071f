"""The site made of these pages: `uv run --group docs sphinx-build -W docs build/site`.

Pages are Markdown, the reference comes from docstrings, and the gallery's scripts are run while it is built.
"""

import importlib.metadata
import re
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "tools")]  # shown.py, constants.py, ...

import constants  # noqa: E402
import finding_codes  # noqa: E402

for pages in (constants, finding_codes):  # made of the program whose documentation this is, so not committed
    pages.PAGE.write_text(pages.page(), encoding="utf-8")

project = "vasowave"
author = "The vasowave authors"
release = importlib.metadata.version("vasowave")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
    "shown",
]
exclude_patterns = ["gallery", "figures", "made", "package.md", "paper", "changes"]
html_theme = "furo"
html_title = "vasowave"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0072b2", "color-brand-content": "#0072b2"},
    "dark_css_variables": {"color-brand-primary": "#56b4e9", "color-brand-content": "#56b4e9"},
}
html_static_path = ["static"]
html_css_files = ["site.css"]

myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # a parameter may be called like an attribute of two classes

napoleon_google_docstring = False
napoleon_use_ivar = True  # attributes stand in the table of their class
autodoc_typehints = "none"  # the docstrings say the types, with shapes and units
autodoc_default_options = {"members": True, "member-order": "bysource"}
autosummary_generate = False

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "made-gallery",
    "filename_pattern": r"\.py$",
    "abort_on_example_error": True,
    "capture_repr": (),
    "min_reported_time": 1e9,
    "show_memory": False,
    "download_all_examples": False,
    "show_signature": False,
    "remove_config_comments": True,
}


def setup(app: object) -> None:
    """Let |u|, a modulus, and (*shape in docstrings be no marks of reStructuredText."""

    def plain(_app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
        lines[:] = [re.sub(r"\|(\w+)\|", r"\|\1\|", line).replace("(*", r"(\*") for line in lines]

    app.connect("autodoc-process-docstring", plain)  # type: ignore[attr-defined]
