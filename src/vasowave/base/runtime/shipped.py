"""Kernels that came with the package, compiled for a level of processors when its wheel was built.

They lie beside the source, and who may write there may write the package: they are trusted as it is. Their file and
folder names say all that those of a user's own kernels say, with the level in place of the processor.
"""

import platform
from functools import cache
from pathlib import Path

import numba
from numba.core.codegen import get_host_cpu_features

from vasowave.base.runtime.kept import PACKAGE

LEVEL = "x86-64-v3"
"""Processors for which kernels are compiled (x86-64 psABI); within a few percent of those for the very processor."""

_INSTRUCTIONS = frozenset(("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2"))
_PLACE = PACKAGE / "compiled"


def shipped_folder(stamp: str) -> Path | None:
    """Return where the kernels of a stamp lie in the package; None where there are none or this processor is another.

    Who tells Numba what to compile for (``NUMBA_CPU_NAME``) gets what they asked for.
    """
    folder = _PLACE / f"kernels-{stamp}"
    return folder if folder.is_dir() and _runs_here() else None


@cache
def _runs_here() -> bool:
    chosen = vars(numba.config)
    if platform.machine() not in ("x86_64", "AMD64") or chosen.get("CPU_NAME") or chosen.get("CPU_FEATURES"):
        return False
    names = {name[1:] for name in get_host_cpu_features().split(",") if name.startswith("+")}
    return names >= _INSTRUCTIONS


def for_level(target: tuple[str, str, str]) -> tuple[str, str, str]:
    """Return what the compiler is told (triple, processor, its instructions) where it compiles for the level."""
    return target[0], LEVEL, ""
