"""vasowave: from one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model."""

import sys

# `python -m vasowave` puts the current folder first, where no file is to be taken for a module (see __main__).
if sys.argv[:1] == ["-m"] and not sys.flags.safe_path and {"vasowave", "-mvasowave"} & set(sys.orig_argv):
    del sys.path[0]

from importlib.util import find_spec
from typing import Any

from vasowave.base.accessors import on_first_use
from vasowave.base.faces import attach_face


def _register_methods() -> None:
    """Give the values of lower parts their methods that need upper ones; a part copied alone has none of these."""
    if find_spec("vasowave.study"):
        from vasowave.study.door.methods import register_all

        register_all()


on_first_use(_register_methods)
_load, _names = attach_face(__name__)


def __getattr__(name: str) -> Any:
    """Load what is asked for when it is asked for, so that importing the package costs nothing."""
    if name == "__version__":
        from importlib.metadata import version

        return version(__name__)
    return _load(name)


def __dir__() -> list[str]:
    return [*_names(), "__version__"]
