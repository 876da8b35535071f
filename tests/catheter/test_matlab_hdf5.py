"""MATLAB files of version 7.3, written with h5py as MATLAB lays them out."""

import h5py
import numpy as np
import pytest

import vasowave as vw
from vasowave.base import InputError
from vasowave.base.io import read_mat

HEAD = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Sun Nov  1 10:00:00 2026 HDF5 schema 1.00 ."


def write_73(path, **variables):
    """Write variables as `save -v7.3` does: transposed, each with its class, behind a header of 512 bytes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            text = isinstance(value, str) or (isinstance(value, list) and isinstance(value[0], str))
            if text:
                rows = [value] if isinstance(value, str) else value
                width = max(map(len, rows))
                value = np.array([[ord(sign) for sign in row.ljust(width)] for row in rows], dtype="u2")
            matrix = np.atleast_2d(np.asarray(value))
            stored = file.create_dataset(name, data=matrix.T, chunks=True, compression="gzip")
            stored.attrs["MATLAB_class"] = np.bytes_("char" if text else "double")
            if text:
                stored.attrs["MATLAB_int_decode"] = np.int32(2)
        inner = file.create_group("#refs#").create_dataset("a", data=[1.0])
        cells = file.create_dataset("names", data=np.array([[inner.ref]], dtype=h5py.ref_dtype))
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
        empty = file.create_dataset("nothing", data=np.array([0, 0], dtype="u8"))
        empty.attrs["MATLAB_class"], empty.attrs["MATLAB_empty"] = np.bytes_("double"), np.uint8(1)
    with path.open("r+b") as file:
        file.write(HEAD.ljust(124) + b"\x00\x02IM")
    return path


def test_a_cycle_saved_with_v73_is_the_one_saved_with_v7(tmp_path):
    mouse = vw.virtual_mouse()
    path = write_73(tmp_path / "c.mat", time=mouse.time, pressure=mouse.pressure[:, None], flow=1e3 * mouse.flow,
                    flow_unit="ul/s", pressure_unit="mmHg")  # fmt: skip
    again = vw.read_recording(path)
    np.testing.assert_array_equal(again.pressure, mouse.pressure)
    np.testing.assert_allclose(again.flow, mouse.flow, rtol=1e-15)
    assert again.period == pytest.approx(mouse.period)


def test_matrices_keep_their_shape_and_texts_their_rows(tmp_path):
    table = np.arange(6.0).reshape(2, 3)
    found = read_mat(
        write_73(tmp_path / "m.mat", table=table, titles=["Pressure", "µ flow"], fill=9.969209968386869e36)
    )
    np.testing.assert_array_equal(found["table"], table)
    assert found["titles"].tolist() == ["Pressure", "µ flow  "]
    assert found["nothing"].shape == (0, 0)
    assert float(found["fill"][0, 0]) == 9.969209968386869e36  # netCDF's own mark of a missing value
    assert "names" not in found


def test_labcharts_export_is_read_from_v73_too(tmp_path):
    rate, time = 2000.0, np.arange(3000) / 2000.0
    pressure, flow = 14 + 5 * np.sin(60 * time), 0.2 + 0.2 * np.sin(60 * time)
    path = write_73(tmp_path / "l.mat", data=np.concatenate([pressure, flow]), datastart=[[1.0], [3001.0]],
                    dataend=[[3000.0], [6000.0]], titles=["PA pressure", "Flow"], samplerate=[[rate], [rate]],
                    unittext=["mmHg", "ml/s"], unittextmap=[[1.0], [2.0]])  # fmt: skip
    raw = vw.read_raw_recording(path)
    np.testing.assert_array_equal(raw.pressure, pressure)
    np.testing.assert_array_equal(raw.flow, flow)
    assert raw.sampling_rate == rate


def test_a_damaged_truncated_or_bloated_file_is_one_of_our_errors(tmp_path):
    whole = write_73(tmp_path / "m.mat", pressure=np.arange(64.0), flow=np.ones(64)).read_bytes()
    path = tmp_path / "d.mat"
    for raw in (whole[:1000], whole[:600], HEAD.ljust(512) + b"\x89HDF\r\n\x1a\n", whole[:2100] + bytes(400)):
        path.write_bytes(raw)
        with pytest.raises(InputError, match=r"d\.mat"):
            vw.read_recording(path, period=0.11)
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("pressure", shape=(1 << 30, 1), dtype="f8", chunks=(1 << 16, 1), compression="gzip")
    with pytest.raises(InputError, match="far more memory than the file is long"):
        vw.read_recording(path, period=0.11)
