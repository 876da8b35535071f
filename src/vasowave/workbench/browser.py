"""A browser is started with a file that only its user can read: all users see what a program is started with."""

import os
import secrets
import tempfile
import webbrowser
from contextlib import suppress
from functools import partial
from pathlib import Path
from urllib.parse import urljoin

from vasowave.base.io.trusted import state_folder
from vasowave.base.runtime.writing import put
from vasowave.workbench.access import Guarded, redirection


def remove(file: Path) -> None:
    """Remove a file, if that is possible."""
    with suppress(OSError):
        file.unlink(missing_ok=True)


def in_a_browser(address: str, desk: str, guard: Guarded) -> Path | None:
    """Open a desk of the page in a browser and return the file that leads there once; None where none can be written.

    Parameters
    ----------
    address : str
        Of the page, with its key.
    desk : str
        What stands behind the address.
    guard : Guarded
        Gives the ticket that stands in the file, and removes the file when the ticket is used.
    """
    for folder in (os.environ.get("XDG_RUNTIME_DIR"), state_folder(), tempfile.gettempdir()):
        if not folder or not Path(folder).is_absolute():
            continue
        file = Path(folder) / f"vasowave-open-{secrets.token_hex(8)}.html"
        page = redirection(urljoin(address, guard.ticket(desk, partial(remove, file))))
        with suppress(OSError):
            file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            put(file, [page.encode()], 0o600)
            webbrowser.open(file.as_uri())
            return file
    return None
