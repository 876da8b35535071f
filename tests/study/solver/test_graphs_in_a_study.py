"""Networks with loops and several inlets: what joins again, and what nothing but symmetry says: in a study."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import vasowave as vw

DATA = Path(__file__).parents[4] / "shared/data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason=f"no measured data at {DATA}")


def largest(one):
    return float(np.max(np.abs(one)))


@needs_data
@pytest.mark.parametrize(
    ("file", "vessels", "loops"),
    [("current/network/network.yaml", 11, 1), ("tests/aspirator/aspirator.yml", 3, 0)],
)
def test_published_networks_that_meet_again_run_from_their_files_and_keep_volume(file, vessels, loops):
    _closes(file, vessels, loops, vw.Numerics())


@needs_data
@pytest.mark.validation
def test_openbf_s_circle_of_willis_runs_from_its_file_and_keeps_volume():
    """Four feeding arteries with the ring: four loops."""
    waves = _closes("current/alastruey2007/circle_of_willis.yaml", 33, 4, vw.Numerics(cell_size=1.0))
    right, left = (waves.flow.sel(vessel=name).mean("time") for name in ("24-R-MCA", "23-L-MCA"))
    assert largest(right / left - 1) < 0.02  # both sides have nearly the same arteries


def _closes(file, vessels, loops, numerics):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vw.errors.VasowaveWarning)
        one, inflow = vw.read_openbf(DATA / "openbf" / file)
        waves = vw.simulate(one, inflow, numerics)
    nodes = len(np.unique([one.network.start, one.network.end]))
    assert (len(one.network), len(one.network) - nodes + 1) == (vessels, loops)
    assert abs(waves.attrs["volume_error"]) < 1e-12
    return waves
