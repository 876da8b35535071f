"""The small phantom as a scan, and what `vasowave extract` makes of it: once for all tests that only read it."""

import pytest

from extract_command import run
from made_phantom import outlets_of, root_of, written_scan


@pytest.fixture(scope="session")
def scan(tmp_path_factory):
    """Folder with the phantom as DICOM series and as one file, its embedding and its volume."""
    return written_scan(tmp_path_factory.mktemp("scan"))


@pytest.fixture(scope="session")
def extracted(scan):
    """Folder that the command wrote, what it said and its warnings."""
    folder, embedding, _ = scan
    result, notes = run(folder / "dicom", "-o", folder / "out", "--root", root_of(embedding), *outlets_of(embedding))
    assert result.exit_code == 0, result.output + repr(result.exception)
    return folder / "out", result, notes
