"""The series of frames that ParaView plays: what is in it, and whether VTK itself opens it."""

import json
import subprocess
import zlib
from base64 import b64decode
from xml.etree import ElementTree

import numpy as np
import pytest

from programs_by_others import environment_with
from vasowave.base import InputError
from vasowave.pulse.model import pressure
from vasowave.pulse.network import Network
from vasowave.study.exchange import SIDES, drawn_axes, read_axes, ring_directions, write_paraview

TYPES = {"Float32": "<f4", "Int32": "<i4"}
SCRIPT = """
import json, sys
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

told = []
for name in sys.argv[1:]:
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(name)
    reader.Update()
    data = reader.GetOutput()
    arrays = {data.GetPointData().GetArrayName(i): vtk_to_numpy(data.GetPointData().GetArray(i))
              for i in range(data.GetPointData().GetNumberOfArrays())}
    root = arrays["vessel"] == 0
    told.append({
        "error": reader.GetErrorCode(), "points": data.GetNumberOfPoints(), "faces": data.GetNumberOfPolys(),
        "time": float(vtk_to_numpy(data.GetFieldData().GetArray("TimeValue"))[0]),
        "pressure": float(arrays["pressure_mmHg"][root][0]), "names": sorted(arrays), "bounds": data.GetBounds(),
    })
print(json.dumps(told))
"""


def arrays_of(path):
    """Return the arrays of a frame by name, decoded by the rules of VTK's XML format."""
    found = {}
    for element in ElementTree.parse(path).iter("DataArray"):
        if element.get("format") == "ascii":
            found[element.get("Name")] = np.array(element.text.split(), dtype=float)
            continue
        size = len(b64decode(element.text[:44])) // 8
        assert size == 4  # one block: count, length, last length, packed length
        values = np.frombuffer(zlib.decompress(b64decode(element.text[44:])), TYPES[element.get("type")])
        width = int(element.get("NumberOfComponents", 1))
        found[element.get("Name")] = values.reshape(-1, width) if width > 1 else values
    return found


@pytest.fixture(scope="module")
def series(tangent, tmp_path_factory):
    folder = tmp_path_factory.mktemp("series")
    write_paraview(tangent, folder, drawn_axes(tangent.network))
    return folder


def test_the_series_lists_every_frame_with_its_time_in_one_cycle(series, tangent):
    listed = list(ElementTree.parse(series / "waves.pvd").iter("DataSet"))
    times = [float(one.get("timestep")) for one in listed]
    assert len(listed) == 64
    np.testing.assert_allclose(np.diff(times), tangent.inflow.period / 64)
    for one, time in list(zip(listed, times, strict=True))[::21]:
        assert arrays_of(series / one.get("file"))["TimeValue"] == time


def test_a_ring_lies_at_the_radius_of_its_area_and_carries_the_waves_of_its_place(series, tangent):
    frame = arrays_of(series / "frames" / "016.vtp")
    run, sample = tangent.run, 16 * 512 // 64
    for row in (0, 5, len(tangent.network) - 1):
        own = np.flatnonzero(frame["vessel"] == row)
        for station, ring in ((0, own[:SIDES]), (-1, own[-SIDES:])):
            area, flow = run.stations[:, sample, row, station]
            points = frame["Points"][ring]
            radius = np.linalg.norm(points - points.mean(axis=0), axis=1)
            np.testing.assert_allclose(np.pi * radius**2, area, rtol=1e-4)
            np.testing.assert_allclose(frame["area_cm2"][ring], area, rtol=1e-6)
            np.testing.assert_allclose(frame["flow_ml_per_s"][ring], flow, rtol=1e-6)
            wall = type(tangent.model.wall)(*(value[row] for value in tangent.model.wall))
            expected = pressure(wall, area, tangent.model.area0[row])
            np.testing.assert_allclose(frame["pressure_mmHg"][ring], expected, rtol=1e-5)
            np.testing.assert_allclose(frame["velocity_cm_per_s"][ring], flow / area, rtol=1e-5)


def test_faces_join_neighboring_rings_of_one_vessel(series):
    frame = arrays_of(series / "frames" / "000.vtp")
    faces = frame["connectivity"].reshape(-1, 4)
    np.testing.assert_array_equal(frame["offsets"], 4 * np.arange(1, len(faces) + 1))
    assert np.all(np.ptp(frame["vessel"][faces], axis=1) == 0)
    assert set(faces.ravel()) == set(range(len(frame["Points"])))
    sides = np.linalg.norm(frame["Points"][faces] - frame["Points"][np.roll(faces, -1, axis=1)], axis=2)
    around = 2 * np.sin(np.pi / SIDES) * np.sqrt(frame["area_cm2"][faces] / np.pi)
    np.testing.assert_allclose(sides[:, 0], around[:, 0], rtol=1e-3)  # no face crosses the tube


def test_rings_stand_across_a_bent_axis_without_twisting():
    turn = np.linspace(0, np.pi, 30)
    helix = np.column_stack([np.cos(turn), np.sin(turn), 0.3 * turn])
    around = ring_directions(helix)
    along = np.gradient(helix, axis=0)
    np.testing.assert_allclose(np.einsum("psi,pi->ps", around, along), 0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(around, axis=2), 1)
    steps = np.linalg.norm(np.diff(around[:, 0], axis=0), axis=1)
    assert steps.max() < 1.1 * np.pi / 29  # as fast as the axis bends, no faster


def test_a_drawn_tree_has_true_lengths_and_joins_daughters_to_their_parents(tangent):
    network, axes = tangent.network, drawn_axes(tangent.network)
    lengths = [np.linalg.norm(axis[-1] - axis[0]) for axis in axes]
    np.testing.assert_allclose(lengths, network.length)
    for row, parent in enumerate(network.parent):
        if parent >= 0:
            np.testing.assert_array_equal(axes[row][0], axes[parent][-1])
    ends = np.array([axes[row][-1] for row in network.terminals])
    apart = np.linalg.norm(ends[:, None] - ends[None], axis=2)
    assert apart[np.triu_indices(len(ends), 1)].min() > 0.02  # cm: no terminal hides another


def test_measured_axes_are_taken_by_the_names_of_the_vessels(tmp_path, tangent):
    names = tangent.network.name
    rows = [f"{name},{i},{2 * i},{0.5}" for name in names for i in range(3)]
    path = tmp_path / "centerlines.csv"
    path.write_text("\n".join(["vessel,x [mm],y [mm],z [mm]", *rows]))
    axes = read_axes(path, tangent.network)
    np.testing.assert_allclose(axes[4][2], [0.2, 0.4, 0.05])
    path.write_text("\n".join(["vessel,x [mm],y [mm],z [mm]", *rows[3:]]))
    with pytest.raises(InputError, match=f"no axis of vessel '{names[0]}'"):
        read_axes(path, tangent.network)


@pytest.mark.validation
def test_vtk_itself_opens_every_frame(series, tangent, tmp_path):
    python = environment_with(tmp_path, "vtk==9.7.2", "numpy")
    frames = sorted(map(str, (series / "frames").iterdir()))
    done = subprocess.run([python, "-c", SCRIPT, *frames], capture_output=True, text=True, check=True)
    told = json.loads(done.stdout)
    assert done.stderr == ""  # VTK writes there what it does not like
    assert len(told) == 64
    assert {one["error"] for one in told} == {0}
    expected = tangent.run.pressure[::8, 0, tangent.network.root]
    np.testing.assert_allclose([one["pressure"] for one in told], expected, rtol=1e-6)
    np.testing.assert_allclose([one["time"] for one in told], np.arange(64) * tangent.inflow.period / 64)
    assert told[0]["names"] == [
        "area_cm2",
        "flow_ml_per_s",
        "pressure_mmHg",
        "velocity_cm_per_s",
        "vessel",
        "wall_shear_Pa",
    ]
    assert told[0]["faces"] == len(arrays_of(frames[0])["connectivity"]) // 4


@pytest.mark.parametrize("longer", [1.0, 1.1])
def test_a_vessel_that_closes_a_loop_is_an_arc_between_the_ends_of_the_others(longer):
    """Of two ways between the same nodes; the second way is drawn as an arc that is as long as it is, or a flat one."""
    nodes = [[0, 1], [1, 2], [1, 2], [2, 3]]
    ring = Network(tuple("abcd"), None, [1.0, 1.0, longer, 1.0], [0.1, 0.08, 0.06, 0.09], nodes=nodes)
    axes = drawn_axes(ring)
    np.testing.assert_allclose(axes[2][[0, -1]], axes[1][[0, -1]])
    chord = np.linalg.norm(axes[2][-1] - axes[2][0])
    along = np.linalg.norm(np.diff(axes[2], axis=0), axis=1).sum()
    assert along > 1.02 * chord
    if longer > 1:
        assert along == pytest.approx(longer, rel=0.015)
