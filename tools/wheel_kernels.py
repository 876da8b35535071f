"""Put compiled kernels into the wheel, so that first use compiles nothing: a build hook of hatchling.

    HATCH_BUILD_HOOK_ENABLE_CUSTOM=true uv build --wheel

Without that variable, and for an editable installation, the wheel is one of pure Python. With it, the wheel is for the
Python that builds it and for Linux on x86-64; its kernels are met where Numba, llvmlite and NumPy are those of the
build (see `vasowave.base.runtime.shipped`), and elsewhere first use compiles as it does for a pure wheel.

A wheel is the same, bit for bit, wherever it is built from the same sources with the same packages.
"""

import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

INSIDE = "vasowave/compiled"
LAW = "from vasowave.pulse.solver.ready import compile_kernels; compile_kernels({law!r})"
FIT = """
import vasowave as vw
from vasowave.pulse.noise.arma import compile_kernels
compile_kernels()
vw.calibrate(vw.control_network(), vw.virtual_mouse(), "linear", search=vw.Search(starts=2))
"""
PROGRAMS = *(LAW.format(law=law) for law in ("linear", "tangent", "power")), FIT
"""What asks for the kernels, each program in a process of its own; what two ask for is compiled by the first."""
SAME = """
import itertools
from numba.core.compiler import CompileResult
from numba.np.ufunc import array_exprs
reduced = CompileResult._reduce
CompileResult._reduce = lambda result: (*reduced(result)[:6], "", *reduced(result)[7:])
array_exprs.hash = lambda expression, numbers=itertools.count(): next(numbers)
"""
"""Keeps out of the kernels what differs between builds: the listing of types with its paths, and places in memory."""


class KernelsHook(BuildHookInterface):
    """Compiles what fits with the wall laws of arteries ask for, and adds it to the wheel."""

    def dependencies(self) -> list[str]:
        return [*self.metadata.core.dependencies] if _is_served() else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable" or not _is_served():
            return
        self._place = tempfile.TemporaryDirectory()
        compiled = Path(self._place.name)
        compile_into(compiled, Path(self.root) / "src")
        for file in compiled.rglob("*.kernel"):
            build_data["force_include"][str(file)] = f"{INSIDE}/{file.relative_to(compiled).as_posix()}"
        python = sys.implementation.cache_tag.replace("cpython-", "cp")
        build_data["pure_python"] = False
        build_data["tag"] = f"{python}-{python}-manylinux_2_17_x86_64"  # no library is linked: any glibc serves

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if hasattr(self, "_place"):
            self._place.cleanup()


def _is_served() -> bool:
    return (platform.system(), platform.machine()) == ("Linux", "x86_64") and platform.libc_ver()[0] == "glibc"


def compile_into(folder: Path, source: Path) -> None:
    """Compile the kernels of the package in `source` into a folder, for the level of processors that wheels serve."""
    sys.path.insert(0, str(source))
    from vasowave.base.runtime.shipped import LEVEL

    target = {"NUMBA_CACHE_DIR": str(folder), "NUMBA_CPU_NAME": LEVEL, "NUMBA_CPU_FEATURES": ""}
    variables = os.environ | target | {"PYTHONPATH": str(source), "PYTHONHASHSEED": "0"}
    for code in PROGRAMS:  # one after another: Numba numbers what it compiles
        subprocess.run([sys.executable, "-c", SAME + code], env=variables, check=True)
    if not any(folder.rglob("*.kernel")):
        raise RuntimeError(
            "no kernel was compiled; see whether Numba compiles and the temporary folder can be written to"
        )
