import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from phantom import embed
from vasowave.base import InputError, VasowaveWarning
from vasowave.lung import Line, Tree
from vasowave.lung.exchange import PolyLines, merged, read_centerlines, read_polydata, write_centerlines, write_vtp
from vasowave.lung.measure import network_of
from vasowave.pulse.examples import control_network

MOUSE = Path(__file__).parents[2] / ".." / "shared" / "data" / "mouse-lung-centerline"


@pytest.fixture(scope="module")
def control():
    network = control_network()
    lines = embed(network, np.random.default_rng(3)).lines
    radius = network.radius
    return network, Tree(tuple(Line(x, np.full(len(x), radius[i])) for i, x in enumerate(lines)), network.parent)


def whole_lines(tree):
    """Root-to-terminal lines whose points are nowhere identical: every line is sampled at its own places."""
    found = []
    for number, row in enumerate(tree.terminals):
        way = [tree.lines[row]]
        while tree.parent[row] >= 0:
            row = tree.parent[row]
            way.append(tree.lines[row][:-1])
        line = way[-1].then(*way[-2::-1])
        table = np.column_stack([line.points, line.radius])
        at = np.linspace(0, len(line) - 1, 3 * len(line) + number)
        found.append(Line.of(np.column_stack([np.interp(at, np.arange(len(line)), column) for column in table.T])))
    return found


def by_size(network):
    order = np.lexsort([network.length.round(9), network.radius.round(9)])
    return network.length[order], network.radius[order]


def test_exported_centerlines_read_back_as_the_same_vessels(control, tmp_path):
    _, tree = control
    write_centerlines(tree, tmp_path / "tree.vtp")
    data = read_polydata(tmp_path / "tree.vtp")
    assert len(data.lines) == 11  # terminals of the 21-vessel network
    again = read_centerlines(tmp_path / "tree.vtp", unit=1, cut="identical")
    for mine, theirs in zip(by_size(network_of(tree)), by_size(network_of(again)), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=1e-12)


@pytest.mark.parametrize("reverse", [False, True])
def test_lines_that_share_no_point_merge_into_the_21_vessels(control, reverse):
    from vasowave.lung import match
    from vasowave.lung.axes import cut_at_junctions

    network, tree = control
    lines = [line[::-1] if reverse else line for line in whole_lines(tree)]
    found = network_of(cut_at_junctions(merged(lines)))
    pairs = match(network, found)
    assert len(found) == len(pairs) == 21
    order = [pairs[row] for row in range(21)]
    # Junctions move by at most about half a radius of the parent along it, at either end of a vessel.
    reach = np.array([network.radius[max(p, 0)] for p in network.parent]) + network.radius
    assert (np.abs(found.length[order] - network.length) < 1.5 * reach).all()
    np.testing.assert_allclose(found.radius[order], network.radius, rtol=1e-9)


def test_a_flat_table_gives_the_same_tree_as_its_lines(control, tmp_path):
    _, tree = control
    lines = whole_lines(tree)
    text = "X Y Z MaximumInscribedSphereRadius\n" + "\n".join(
        " ".join(repr(float(v * 10)) for v in (x, y, z, r))
        for line in lines
        for (z, y, x), r in zip(line.points, line.radius, strict=True)
    )
    (tmp_path / "lines.dat").write_text(text + "\n")
    whole = lines[0].then(*lines[1:])
    data = PolyLines(
        whole.points[:, ::-1] * 10,
        tuple(np.split(np.arange(sum(map(len, lines))), np.cumsum([len(x) for x in lines])[:-1])),
        {"Radius": whole.radius * 10},
    )
    write_vtp(data, tmp_path / "lines.vtp")
    flat, kept = (read_centerlines(tmp_path / f"lines.{kind}", unit=0.1) for kind in ("dat", "vtp"))
    np.testing.assert_array_equal(flat.parent, kept.parent)
    np.testing.assert_allclose(network_of(flat).length, network_of(kept).length, rtol=1e-9)


def test_swc_gives_the_vessels_it_describes(tmp_path):
    (tmp_path / "fork.swc").write_text(
        "# three vessels, micrometers\n1 3 0 0 0 400 -1\n2 3 3000 0 0 400 1\n"
        "3 3 3000 4000 0 300 2\n4 3 3000 0 5000 200 2\n5 3 3000 0 9000 200 4\n"
    )
    network = network_of(read_centerlines(tmp_path / "fork.swc", unit=1e-4))
    np.testing.assert_allclose(network.length, [0.3, 0.4, 0.9], rtol=1e-12)
    np.testing.assert_array_equal(network.parent, [-1, 0, 0])
    (tmp_path / "cycle.swc").write_text("1 3 0 0 0 4 -1\n2 3 3 0 0 4 3\n3 3 3 4 0 3 2\n")
    with pytest.raises(InputError, match="form a cycle"):
        read_centerlines(tmp_path / "cycle.swc", unit=1)
    (tmp_path / "lost.swc").write_text("1 3 0 0 0 4 -1\n2 3 3 0 0 4 7\n")
    with pytest.raises(InputError, match="line 2: parent 7 is not in the file"):
        read_centerlines(tmp_path / "lost.swc", unit=1)


def test_a_damaged_vtp_is_an_input_error_wherever_it_is_cut(control, tmp_path):
    write_centerlines(control[1], tmp_path / "tree.vtp")
    content = (tmp_path / "tree.vtp").read_bytes()
    for end in np.linspace(0, len(content) - 12, 60).astype(int):
        (tmp_path / "cut.vtp").write_bytes(content[:end])
        with pytest.raises(InputError, match=r"cut\.vtp"):
            read_centerlines(tmp_path / "cut.vtp", unit=1)
    rng = np.random.default_rng(0)
    for _ in range(60):
        wrong = bytearray(content)
        wrong[rng.integers(200, len(content))] = ord("!")
        (tmp_path / "cut.vtp").write_bytes(wrong)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VasowaveWarning)
            with pytest.raises(InputError):
                read_centerlines(tmp_path / "cut.vtp", unit=1)


@pytest.mark.skipif(not MOUSE.exists(), reason="the measured mouse lung is not beside the project")
def test_the_mouse_lung_becomes_one_tree_of_about_530_vessels():
    voxel = 0.00427  # cm; the file is in voxels, this size is assumed
    begin = time.process_time()
    tree = read_centerlines(next(MOUSE.glob("*.vtp")), unit=voxel)  # a loop would warn, and warnings are errors
    network = network_of(tree)
    print(f"{len(network)} vessels, {len(network.terminals)} terminals, {time.process_time() - begin:.2f} CPU-s")
    assert len(network.terminals) == 267  # one for each line of the file
    assert 525 <= len(network) <= 2 * 267 - 1  # the authors counted 530; 533 if all junctions were bifurcations
    assert network.radius.max() < 11.1 * voxel  # largest inscribed radius in the file
    assert network.radius.min() > 0.19 * voxel
    assert 1.5 < np.median(network.length / network.radius) < 30


@pytest.mark.parametrize(
    ("name", "text"), [("c.vtp", "<VTKFile><PolyData>"), ("c.swc", "1 0 0 0 0 1 -1\n2 0 0 0 1 1 7\n")]
)
def test_an_error_in_a_file_of_lines_names_the_file_once(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as caught:
        read_centerlines(tmp_path / name, 0.1)
    assert str(caught.value).count(name) == 1
