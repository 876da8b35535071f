"""Build wheel and sources, with their SHA-256 and the list of the packages that they were tested with (CycloneDX).

    uv run python tools/parts.py dist

The wheel holds kernels where they can be compiled (see `wheel_kernels`); beside it lies one of pure Python for all
other systems.
"""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
WITH_KERNELS = {"HATCH_BUILD_HOOK_ENABLE_CUSTOM": "true"}
LISTED = ["export", "--quiet", "--all-extras", "--no-default-groups", "--format", "cyclonedx1.5"]


def parts(source: Path) -> dict[str, object]:
    """Return the list of parts, with the hash of every file of each, but neither time nor place nor random numbers."""
    listed = json.loads(subprocess.run(["uv", *LISTED], cwd=source, check=True, stdout=subprocess.PIPE).stdout)
    listed.pop("serialNumber", None)
    listed["metadata"].pop("timestamp", None)
    for part in listed["components"]:
        found = part.pop("externalReferences", [])
        part["hashes"] = [one for file in found for one in file.get("hashes", [])]
    return dict(listed)


def build(folder: Path, source: Path = ROOT) -> list[Path]:
    """Build everything that is shipped into a folder and return its files."""
    built = ["uv", "build", "--quiet", "--out-dir", str(folder), str(source)]
    subprocess.run(built, check=True)
    subprocess.run([*built, "--wheel"], env=os.environ | WITH_KERNELS, check=True)
    (folder / "parts.cdx.json").write_text(json.dumps(parts(source), indent=1) + "\n", "utf-8")
    files = sorted(path for path in folder.iterdir() if path.name.endswith((".whl", ".tar.gz", ".json")))
    sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files]
    (folder / "SHA256SUMS").write_text("".join(sums), "utf-8")
    return [*files, folder / "SHA256SUMS"]


if __name__ == "__main__":
    print(*build(Path(sys.argv[1] if len(sys.argv) > 1 else "dist")), sep="\n")
