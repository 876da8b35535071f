"""Run a twentieth of the default tests, in random order, in each of the surroundings that programs meet elsewhere.

    uv run python tools/surroundings.py               all of them, a twentieth each
    uv run python tools/surroundings.py background 3  one of them, with the tests of another twentieth

``background``: SIGINT is ignored, as in a script's background, the language is C, the time zone one with odd minutes.
``elsewhere``: the package comes from a wheel and runs as a user without rights whose home is read-only and who has a
folder for what is cached, as containers give it; `tests/base/runtime/test_kernels.py` tries the want of any.
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
NOBODY = 65534
READ_ALL = "+dac_read_search"  # the interpreter may lie where only root may look


def background(place: Path) -> tuple[list[str], dict[str, str]]:
    """Return how Python is called where a script runs it in the background, and what is set there."""
    del place
    return [sys.executable], {"LANG": "C", "LC_ALL": "C", "TZ": "Asia/Kathmandu"}


def elsewhere(place: Path) -> tuple[list[str], dict[str, str]]:
    """Return how Python is called by a user of the wheel who owns nothing here, and what is set there."""
    uv = shutil.which("uv") or "uv"
    subprocess.run([uv, "build", "--quiet", "--wheel", "--out-dir", str(place / "wheel"), str(ROOT)], check=True)
    (wheel,) = (place / "wheel").glob("*.whl")
    python = str(place / "venv" / "bin" / "python")
    subprocess.run([uv, "venv", "--quiet", "--python", sys.executable, str(place / "venv")], check=True)
    pinned = place / "pinned.txt"
    listed = [uv, "pip", "freeze", "--exclude-editable", "--python", sys.executable]
    pinned.write_bytes(subprocess.run(listed, check=True, stdout=subprocess.PIPE).stdout)
    install = [uv, "pip", "install", "--quiet", "--python", python, str(wheel), "-r", str(pinned)]
    subprocess.run(install, check=True)
    home, files, bytecode, cache = (place / name for name in ("home", "files", "bytecode", "cache"))
    for folder in (home, files, bytecode, cache):
        folder.mkdir()
    home.chmod(0o555)
    more = {"HOME": str(home), "TMPDIR": str(files), "PYTHONPYCACHEPREFIX": str(bytecode), "XDG_CACHE_HOME": str(cache),
            "HYPOTHESIS_STORAGE_DIRECTORY": str(files / "hypothesis")}  # fmt: skip
    compiled = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vasowave"
    if compiled.is_dir():  # by the same source, so that nothing is compiled twice
        shutil.copytree(compiled, cache / compiled.name)
    if os.geteuid():  # somebody without rights already
        return [python], more
    place.chmod(0o755)
    for entry in (files, bytecode, cache, *cache.rglob("*")):
        os.chown(entry, NOBODY, NOBODY)
    user = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", f"--inh-caps={READ_ALL}",
            f"--ambient-caps={READ_ALL}"]  # fmt: skip
    if shutil.which(user[0]) is None or subprocess.run([*user, "true"], check=False).returncode:
        print("another user is not to be had here: setpriv is absent or not allowed")
        return [python], more
    return [*user, python], more


SURROUNDINGS = {"background": (background, 2), "elsewhere": (elsewhere, 8)}
"""With the twentieth of the tests that meets most of what differs: signals, processes and dates; files and pages."""
COUNT = 20


def run(name: str, number: int) -> int:
    """Run the tests of a twentieth in one of the surroundings and return the status of pytest."""
    with tempfile.TemporaryDirectory() as folder:
        python, more = SURROUNDINGS[name][0](Path(folder))
        chosen = {"VASOWAVE_SHARE": f"{number}/{COUNT}"}
        kept = {key: value for key, value in os.environ.items() if key not in ("XDG_STATE_HOME", "VIRTUAL_ENV")}
        print(f"\n{name}: twentieth {number}", flush=True)
        return subprocess.run(
            [*python, "-m", "pytest", "-q", "-p", "no:cacheprovider"], cwd=ROOT, env=kept | more | chosen, check=False,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN) if name == "background" else None,
        ).returncode  # fmt: skip


if __name__ == "__main__":
    names = [sys.argv[1]] if len(sys.argv) > 1 else list(SURROUNDINGS)
    sys.exit(max(run(name, int(sys.argv[2]) if len(sys.argv) > 2 else SURROUNDINGS[name][1]) for name in names))
