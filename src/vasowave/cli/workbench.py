"""The command that opens the workbench: open."""

import os
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from vasowave.base.errors import EXTRAS, InputError
from vasowave.cli.app import app

_WHAT = typer.Argument(help="A study, a fit, a recording, an image, or a folder that is to become a study.")


@app.command(
    "open",
    epilog="Example: vasowave open my-study. Everything that the page does is a file of the study, which all other "
    "commands understand. Ctrl-C ends it.",
)
def open_workbench(
    place: Annotated[Path, _WHAT] = Path(),
    browser: Annotated[bool, typer.Option(help="Open the page in a browser; else the address is printed only.")] = True,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port; by default one that is free.")] = 0,
) -> None:
    """Open the workbench in a browser: look at recordings and images, choose beats, mend vessels, run, explore.

    It answers on this machine alone.
    """
    missing = [name for name in ("starlette", "uvicorn") if find_spec(name) is None]
    if missing:
        raise InputError(f"the workbench needs {' and '.join(missing)}, the extra 'workbench': {EXTRAS}")
    from vasowave.workbench.access import Guarded
    from vasowave.workbench.browser import in_a_browser, remove
    from vasowave.workbench.opening import opened
    from vasowave.workbench.server import serve

    folder, desk, sentences, image = opened(place)
    for sentence in sentences:
        typer.echo(sentence)

    files: list[Path | None] = []

    def announce(address: str, guard: Guarded) -> None:
        typer.echo(f"Workbench: {address}{desk}\nCtrl-C ends it. The address carries a key; give it to nobody.")
        if browser:
            files.append(in_a_browser(address, desk, guard))

    goes_on = serve(folder, port, announce, image)
    for file in filter(None, files):  # of a browser that never came
        remove(file)
    typer.echo("Ended." + (f" The run goes on; see vasowave status {folder}" if goes_on else ""))
    sys.stdout.flush()
    os._exit(0)  # at once: nobody waits for what is still being read, and files are written whole or not at all
