"""The first look: what it proposes is what extracts, and what it shows is there: in a study."""

import json
import re
import shlex
import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

import vasowave as vw
from approval import approve, figure, page
from made_phantom import phantom
from vasowave.base import InputError, VasowaveWarning
from vasowave.cli import app
from vasowave.lung.read import Volume, write_volume
from vasowave.study.figures import grey_scale_figure, histogram_figure, projections_figure, svg
from vasowave.study.report import command, look_json, look_page, look_text, write_look

CANNULA = 0.043


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    embedding, volume = phantom()
    path = tmp_path_factory.mktemp("look") / "mouse 6.nrrd"
    write_volume(volume, path)
    return path, embedding, volume


@pytest.fixture(scope="module")
def seen(scan):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        return vw.look(scan[0])


def test_what_is_told_of_the_image_is_what_it_is(scan, seen):
    _, _, volume = scan
    assert seen.image.grey.shape == volume.grey.shape
    assert seen.histogram.counts.sum() == volume.grey.size
    assert not seen.histogram.whole
    assert seen.levels.background == pytest.approx(12, abs=1)
    assert seen.levels.lumen == pytest.approx(100, rel=0.05)
    assert seen.grey.saturated < 0.001
    assert abs(seen.grey.scale.bend) < 0.03
    assert seen.loops == ()
    assert "voxel:             95 × 95 × 95 µm" in look_text(seen)
    assert "140 × 140 × 140 voxels (x, y, z), 1.33 × 1.33 × 1.33 cm" in look_text(seen)


def test_the_proposed_command_extracts_the_tree(scan, seen, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program, *words = shlex.split(command(seen))
    assert program == "vasowave"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output + repr(result.exception)
    assert "Network(5 vessels" in result.output


def test_approved_the_page_of_a_first_look_and_its_drawings(seen, tmp_path):
    path = tmp_path / "look.html"
    path.write_text(look_page(seen), encoding="utf-8")
    drawings = {
        "histogram": histogram_figure(seen), "grey scale": grey_scale_figure(seen),
        "wide": projections_figure(seen), "narrow": projections_figure(seen, wide=False),
    }  # fmt: skip
    drawn = [line for name, one in drawings.items() for line in figure(name, svg(one))]
    stored = [line for line in look_json(seen).partition('"provenance"')[0].splitlines() if "mouse 6" not in line]
    words = [line.replace(str(seen.source.parent), "") for line in page(path)]
    approve("look", [*words, *drawn, *stored], 0.2, 0.02)  # 2 %: another processor's rounding of a search


@pytest.mark.validation
def test_the_page_needs_no_network_and_json_holds_the_same(scan, seen, tmp_path):
    page = look_page(seen)
    assert not re.findall(r'(?:src|href)="(?!data:|#)[^"]', page)
    assert page.count("<svg") == 4  # three figures, one of them in two forms
    stored = json.loads(look_json(seen))
    assert stored["command"] == command(seen)
    assert stored["entrances"][0]["radius [cm]"] == pytest.approx(CANNULA, rel=0.03)
    for name in ("look.html", "look.json"):
        result = CliRunner().invoke(app, ["look", str(scan[0]), "-o", str(tmp_path / name)])
        assert result.exit_code == 0, result.output
        assert command(seen) in result.output
        assert (tmp_path / name).stat().st_size > 1000
    wrong = CliRunner().invoke(app, ["look", str(scan[0]), "-o", str(tmp_path / "look.txt")])
    assert isinstance(wrong.exception, InputError)


def ring(gap, noise=2.0):
    """A vessel that divides and joins again around a hole of `gap` voxels."""
    z, y, x = np.indices((30, 70, 90))
    half = gap / 2 + 5
    side = np.where(np.abs(x - 45) < 20, half * np.cos(np.pi * (x - 45) / 40), 0)
    tube = np.minimum(np.hypot(y - 35 - side, z - 15), np.hypot(y - 35 + side, z - 15)) < 5
    grey = 100 * (tube & (x > 3) & (x < 86)) + np.random.default_rng(0).normal(10, noise, z.shape)
    return Volume(grey, np.full(3, 0.01), np.zeros(3))


def test_of_a_ring_that_nothing_closes_the_proposed_command_cuts_it_and_doubts_what_it_cut(tmp_path):
    volume = ring(20)
    seen = vw.look(volume, cannula=0)
    assert (len(seen.loops), seen.closed, seen.opening) == (1, False, None)
    assert "--loops=open" in command(seen)
    assert "doubts the vessels there" in look_text(seen)
    assert sorted(round(float(one.place[2]), 1) for one in seen.entrances) == [0.1, 0.8]  # none within the ring
    assert "cannula:           none; if that is not so, give its diameter" in look_text(seen)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = vw.extract(volume, root=seen.options.root, threshold=seen.options.threshold, cannula=0, loops="open")
    assert any(one.vessels for one in found.doubts)
    write_look(seen, tmp_path / "ring.JSON")  # of an image that no file holds
    stored = json.loads((tmp_path / "ring.JSON").read_text(encoding="utf-8"))
    assert (stored["size"], stored["spacing [cm]"]) == ([90, 70, 30], [0.01] * 3)  # x, y, z
    (loop,) = stored["loops"]  # the ring's hole lies about x 0.45 and y 0.35
    assert np.hypot(loop["place [cm]"][0] - 0.45, loop["place [cm]"][1] - 0.35) < 0.2
    assert not [name for name in stored["provenance"] if name.startswith("sha256")]


def bare_fork():
    """A vessel of 0.036 cm that divides into two, in 0.004 cm voxels: no cannula anywhere."""
    z, y, x = np.indices((130, 90, 50)) * 0.004
    side = np.where(z < 0.28, 0.0, 0.5 * (z - 0.28))
    axis = np.minimum(np.hypot(y - 0.18 - side, x - 0.1), np.hypot(y - 0.18 + side, x - 0.1))
    inside = (axis < 0.036) & (z > 0.012) & (z < 0.5)
    grey = 10 + 100.0 * inside + np.random.default_rng(0).normal(0, 3, z.shape)
    return Volume(grey, np.full(3, 0.004), np.zeros(3))


@pytest.mark.validation
def test_of_an_image_without_a_cannula_the_proposed_command_runs_and_the_error_of_another_says_how(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    write_volume(bare_fork(), tmp_path / "bare.nrrd")
    seen = vw.look(tmp_path / "bare.nrrd")
    assert seen.findings[0].code == "image.no-cannula"
    assert "give its diameter, with the root at its outer end" in look_text(seen)
    assert not any("look:" in str(one) for one in seen.findings)
    words = shlex.split(command(seen))[1:]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 0, result.output + repr(result.exception)
        assert "Network(3 vessels, 2 terminals" in result.output
        with pytest.raises(InputError, match=r"no cannula found.*if there is none in the image, say so"):
            vw.extract(tmp_path / "bare.nrrd", root=seen.options.root, threshold=seen.options.threshold)
