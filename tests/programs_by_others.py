"""Programs of others, each in an environment of its own, for the tests that ask them."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest


def environment_with(folder: Path, *packages: str) -> Path:
    """Return the Python of a fresh environment that holds these packages, or skip where they cannot be installed."""
    uv = shutil.which("uv")
    if uv is None:
        pytest.skip("uv, which makes environments, is not on the path")
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    python = folder / "environment" / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    subprocess.run([uv, "venv", "--quiet", "--python", version, str(folder / "environment")], check=True)
    command = [uv, "pip", "install", "--quiet", "--python", str(python), *packages]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"{', '.join(packages)} cannot be installed here: {done.stderr.strip().splitlines()[-1]}")
    return python
