import json

import numpy as np
import pytest

from made_fit import made_fit, made_recording
from vasowave.datasets import control_network
from vasowave.datasets.raw import synthetic_raw_recording
from vasowave.subject import Animal, Settings, analyze, read_tree, write_tree


@pytest.fixture(scope="module")
def tree():
    """Return the tree of a synthetic raw recording, with fits made from formulas instead of searches."""
    rng = np.random.default_rng(3)
    raw = synthetic_raw_recording(made_recording(), rng, duration=8.0).raw
    animal = Animal.from_raw("m 1", "CTL", control_network(), raw, synthetic=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vasowave.subject.pipeline.calibrate", lambda network, recording, wall, **more: made_fit(wall))
        return analyze(animal, Settings(starts=1))


def test_every_number_of_the_tree_has_a_unit(tree):
    for group in ("measured", "linear", "tangent"):
        for part in tree[group].subtree:
            for name, variable in part.data_vars.items():
                if variable.dtype.kind == "f" and part.name not in ("calibration",):
                    assert variable.attrs.get("units"), f"{part.path}/{name}"


def test_a_tree_survives_its_file_unchanged(tree, tmp_path):
    write_tree(tree, tmp_path / "m.nc")
    back = read_tree(tmp_path / "m.nc")
    assert back.identical(tree)
    assert [path.name for path in tmp_path.iterdir()] == ["m.nc"]
    assert json.loads(back.attrs["settings"])["starts"] == 1
