"""The directive ``shown``: commands run while the site is built, in the folder of their page, and what they print.

The folder ``made/PAGE`` is empty when a page begins, so that no page relies on what another one left.

    ```{shown}
    vasowave new my-study
    ```

Options: ``:status:``, the exit status that is expected, 0 by default; ``:silent:`` runs without showing.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective

MADE = Path(__file__).parent / "made"
WIDTH = 80  # columns of the terminal that is shown


class Shown(SphinxDirective):
    """Run each line as a command and show it with its output."""

    has_content = True
    option_spec = {"status": directives.nonnegative_int, "silent": directives.flag}  # noqa: RUF012  docutils' own form

    def run(self) -> list[nodes.Node]:
        """Return one block of console text."""
        folder = MADE / Path(self.env.docname).name
        if not self.env.temp_data.setdefault("shown", False):
            self.env.temp_data["shown"] = True
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
        text = "\n".join(part for command in self.content if command for part in self._lines(command, folder))
        if "silent" in self.options:
            return []
        block = nodes.literal_block(text, text, language="text")
        return [block]

    def _lines(self, command: str, folder: Path) -> list[str]:
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        environment = os.environ | {"COLUMNS": str(WIDTH), "PATH": path, "NO_COLOR": "1", "TERM": "dumb"}
        done = subprocess.run(
            command, shell=True, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, check=False,
        )  # fmt: skip
        if done.returncode != self.options.get("status", 0):
            raise ExtensionError(f"{self.env.docname}: '{command}' ended with {done.returncode}:\n{done.stdout}")
        output = done.stdout.replace(f"{folder}{os.sep}", "").rstrip()
        return [f"$ {command}", *output.splitlines()]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("shown", Shown)
    return {"parallel_read_safe": False}
