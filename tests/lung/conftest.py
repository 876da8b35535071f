"""The small phantom as a scan, once for all tests that only read it."""

import pytest

from made_phantom import written_scan


@pytest.fixture(scope="session")
def scan(tmp_path_factory):
    """Folder with the phantom as DICOM series and as one file, its embedding and its volume."""
    return written_scan(tmp_path_factory.mktemp("scan"))
