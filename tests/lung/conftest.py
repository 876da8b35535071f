"""The small phantom as a scan, and what `vasowave extract` makes of it: once for all tests that only read it."""

import pytest
from made_phantom import outlets_of, phantom, root_of

from extract_command import run
from phantom import write_dicom_series
from vasowave.lung.read import write_volume


@pytest.fixture(scope="session")
def scan(tmp_path_factory):
    """Folder with the phantom as DICOM series and as one file, its embedding and its volume."""
    embedding, volume = phantom()
    folder = tmp_path_factory.mktemp("scan")
    write_dicom_series(volume, folder / "dicom")
    write_volume(volume, folder / "image.nrrd")
    return folder, embedding, volume


@pytest.fixture(scope="session")
def extracted(scan):
    """Folder that the command wrote, what it said and its warnings."""
    folder, embedding, _ = scan
    result, notes = run(folder / "dicom", "-o", folder / "out", "--root", root_of(embedding), *outlets_of(embedding))
    assert result.exit_code == 0, result.output + repr(result.exception)
    return folder / "out", result, notes
