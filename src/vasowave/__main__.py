"""The command ``vasowave``, also as ``python -m vasowave``.

Studies come from anywhere, so no program that lies in the current folder may run: that folder leaves the path of
imports before anything else is imported, here and in all processes that are started from here.
"""

import os
import sys

_STEERING = {".numba_config.yaml": "how the solver is compiled", "matplotlibrc": "how figures are drawn, and by what"}
"""Files of the current folder by which Numba and Matplotlib would let themselves be steered, and in what."""


def leave_folder() -> None:
    """Take the current folder off the path of imports, unless this package itself lies there."""
    folder, home = os.getcwd(), os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    if folder != home:
        sys.path[:] = [place for place in sys.path if os.path.abspath(place) != folder]
    os.environ["PYTHONSAFEPATH"] = "1"


def main() -> None:
    """Run the command line."""
    leave_folder()
    for file, effect in _STEERING.items():
        if os.path.lexists(file):
            sys.exit(f"Error: {os.path.abspath(file)}: would change {effect}; remove it")
    try:
        from vasowave.cli import run

        run()
    except KeyboardInterrupt:  # while the program itself is loaded, before or after a command
        sys.exit(130)


if __name__ == "__main__":
    main()
