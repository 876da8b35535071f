"""`vasowave centerlines`: lines of other programs become a network."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from made_phantom import NETWORK
from phantom import embed
from vasowave.cli import app
from vasowave.lung import Line, Tree
from vasowave.lung.exchange import write_centerlines, write_swc
from vasowave.pulse.network_formats import read_network


@pytest.fixture(scope="module")
def lines(tmp_path_factory):
    """The same five vessels as VMTK (mm) and SWC (um) files."""
    folder = tmp_path_factory.mktemp("lines")
    embedding = embed(NETWORK, np.random.default_rng(5))
    tubes = zip(embedding.lines, NETWORK.radius, strict=True)
    tree = Tree(tuple(Line(line, np.full(len(line), radius)) for line, radius in tubes), np.array(NETWORK.parent))
    write_centerlines(tree, folder / "lines.vtp", unit=0.1)
    write_swc(tree, folder / "lines.swc")
    return folder


def run(*arguments):
    return CliRunner().invoke(app, ["centerlines", *map(str, arguments)])


@pytest.mark.parametrize(("file", "unit"), [("lines.vtp", "mm"), ("lines.swc", "um"), ("lines.vtp", "0.1")])
def test_lines_become_the_network_they_were_written_from(lines, tmp_path, file, unit):
    result = run(lines / file, "-o", tmp_path / "out", "--unit", unit, "--cut", "identical", "--pressure", 6.3)
    assert result.exit_code == 0, repr(result.exception)
    found = read_network(tmp_path / "out" / "network.csv")
    assert found.pressure == 6.3
    order = np.argsort(found.length)
    np.testing.assert_allclose(found.length[order], np.sort(NETWORK.length), rtol=1e-5)
    np.testing.assert_allclose(np.sort(found.radius), np.sort(NETWORK.radius), rtol=1e-5)
    assert len(found.terminals) == len(NETWORK.terminals)
    settings = json.loads((tmp_path / "out" / "centerlines.json").read_text())
    assert settings["settings"]["vessels in the file"] == 5
    assert (tmp_path / "out" / "figures" / "network.png").stat().st_size > 1000


def test_the_largest_vessels_alone_are_kept_and_an_earlier_result_is_replaced(lines, tmp_path):
    for count in (5, 3):
        result = run(lines / "lines.vtp", "-o", tmp_path / "out", "--unit", "mm", "--vessels", count)
        assert result.exit_code == 0, repr(result.exception)
        assert len(read_network(tmp_path / "out" / "network.csv")) == count


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--unit", "furlong"], "'furlong' is not a unit of length"),
        (["--unit", "-1"], "give the file's unit of length as a positive number"),
        (["--unit", "mm", "--cut", "here"], "part at a 'tube' or where 'identical'"),
        (["--unit", "mm", "--vessels", "3", "--generations", "2"], "keep either"),
    ],
)
def test_what_cannot_be_meant_is_refused_and_nothing_is_written(lines, tmp_path, arguments, message):
    result = run(lines / "lines.vtp", "-o", tmp_path / "out", *arguments)
    assert message in str(result.exception)
    assert not (tmp_path / "out").exists()


def test_a_folder_with_other_work_in_it_is_not_touched(lines, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    result = run(lines / "lines.vtp", "-o", tmp_path, "--unit", "mm")
    assert "not a vasowave result" in str(result.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
