"""An emulator that is stored and read back."""

import numpy as np
import pytest

import vasowave as vw


def test_what_is_read_back_answers_as_what_was_written_and_what_was_changed_is_refused(tmp_path):
    network = vw.Network(("1",), [-1], [0.4], [0.05])
    fit = vw.calibrate(
        network, vw.virtual_mouse(), search=vw.Search(starts=1, fixed=dict.fromkeys(("r1", "r2", "c1"), 1.0))
    )
    emulator = vw.emulate(fit)
    path = emulator.to_netcdf(tmp_path / "emulator.nc")
    again = vw.read_emulator(path)
    stiffness = np.linspace(*emulator.box.loc["beta", ["low", "high"]], 9)
    assert np.array_equal(again({"beta": stiffness}), emulator({"beta": stiffness}))
    assert again.quantities.equals(emulator.quantities)
    assert repr(again) == repr(emulator)
    content = bytearray(path.read_bytes())
    place = content.find(np.float64(emulator.data["answers"].values[3, 0]).tobytes())
    content[place + 3] ^= 1
    path.write_bytes(content)
    with pytest.raises(vw.errors.InputError, match="changed since"):
        vw.read_emulator(path)
    with pytest.raises(vw.errors.InputError, match=r"absent\.nc"):
        vw.read_emulator(tmp_path / "absent.nc")
    with pytest.raises(vw.errors.InputError, match="no emulator"):
        vw.read_emulator(vw.Posterior.to_netcdf(_Tree(), tmp_path / "other.nc"))


class _Tree:
    """What another file of ours holds."""

    def __init__(self):
        import xarray as xr

        self.data = xr.DataTree(xr.Dataset({"x": ("draw", np.zeros(3))}))
