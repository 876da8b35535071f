"""Extractions that keep their stages: the same answer, less work, and nothing believed that is not whole or theirs."""

import json
import shutil
import warnings

import numpy as np
import pytest

from extract_command import run
from phantom import embed, render
from vasowave.base import VasowaveWarning
from vasowave.lung import Options, extract, given, written
from vasowave.lung.kept import FOLDER, Keys, Stages, keys_of
from vasowave.lung.read import read_volume, write_volume
from vasowave.pulse.network import Network
from vasowave.study.report import write_network_files

NETWORK = Network(
    ("1", "2", "3", "4", "5"),
    np.array([-1, 0, 0, 1, 1]),
    np.array([0.3, 0.3, 0.25, 0.2, 0.25]),
    np.array([0.052, 0.042, 0.032, 0.034, 0.03]),
)
ALL = {"image", "lumen", "loops", "axes", "elsewhere", "witness", "profiles", "grey"}


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """A folder with an image and the stages of its first extraction, and where its vessels lie."""
    rng = np.random.default_rng(5)
    embedding = embed(NETWORK, rng)
    folder = tmp_path_factory.mktemp("kept")
    write_volume(render(embedding, 100, 0.012, rng, noise=6.0), folder / "image.nrrd")
    extracted(folder, Options(embedding.cannula[0].tolist()), Stages(folder))
    return folder, embedding


def extracted(folder, options, stages=None, image="image.nrrd"):
    """Return everything that an extraction says, and save its stages."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = extract(folder / image, options, stages=stages)
    if stages:
        stages.save()
    place = folder / "answer"
    place.mkdir(exist_ok=True)
    write_network_files(found.measured, place, found.doubts)
    texts = [(place / name).read_text() for name in ("network.csv", "vessels.csv", "centerlines.csv")]
    return *texts, found.notes, [(one.about, one.text, one.places.tolist()) for one in found.doubts]


def copied(folder, place):
    """Return a copy of the stages in `folder` and when each was written."""
    shutil.copytree(folder / FOLDER, place / FOLDER)
    return Stages(place), {file.name: file.stat().st_mtime_ns for file in (place / FOLDER).iterdir()}


def made_anew(place, before):
    return {file.stem for file in (place / FOLDER).iterdir() if file.stat().st_mtime_ns != before.get(file.name)}


def middle(embedding, row):
    line = embedding.lines[row]
    return line[2 * len(line) // 3]


@pytest.mark.parametrize(
    ("edits", "made"),
    [
        ({"remove": 4}, {"profiles"}),
        pytest.param({"cut": 4, "merge": 1}, {"profiles"}, marks=pytest.mark.validation),
        ({"root": None}, {"lumen", "loops", "axes", "elsewhere", "witness", "profiles", "grey"}),
    ],
)
def test_after_an_edit_the_answer_is_that_of_an_extraction_from_nothing(scan, tmp_path, edits, made):
    folder, embedding = scan
    outward = embedding.cannula[0] + [0.01, 0, 0]
    places = {edit: outward if row is None else middle(embedding, row) for edit, row in edits.items()}
    lines = [f"{edit} {written(place).replace(',', ' ')}" for edit, place in places.items()]
    (tmp_path / "edits.txt").write_text("\n".join(lines) + "\n")
    options = Options(embedding.cannula[0].tolist(), edits=tmp_path / "edits.txt")
    stages, before = copied(folder, tmp_path)
    again = extracted(folder, options, stages)
    assert made_anew(tmp_path, before) == made
    assert again == extracted(folder, options)


@pytest.mark.validation
def test_the_command_writes_the_same_files_with_kept_stages_as_without(scan, tmp_path):
    folder, embedding = scan
    edits = tmp_path / "edits.txt"
    edits.write_text(f"remove {written(middle(embedding, 4)).replace(',', ' ')}\n")
    told = []
    for name, keep in (("out", "--keep"), ("out", "--keep"), ("fresh", "--no-keep")):
        arguments = [folder / "image.nrrd", "--root", written(embedding.cannula[0]), "--edits", edits]
        assert run(*arguments, keep, "-o", tmp_path / name)[0].exit_code == 0
        said = json.loads((tmp_path / name / "extraction.json").read_text())
        said["provenance"].pop("created")
        told.append((said, (tmp_path / name / "network.csv").read_text()))
    assert told[0] == told[1] == told[2]
    assert not (tmp_path / "fresh" / FOLDER).exists()


def test_damaged_stages_are_made_again(scan, tmp_path):
    folder, embedding = scan
    stages, before = copied(folder, tmp_path)
    rng = np.random.default_rng(0)
    for file in (tmp_path / FOLDER).iterdir():
        content = bytearray(file.read_bytes())
        content[int(rng.integers(len(content)))] ^= 1 << int(rng.integers(8))
        file.write_bytes(content)
    before = dict.fromkeys(before, 0)
    options = Options(embedding.cannula[0].tolist())
    assert extracted(folder, options, stages) == extracted(folder, options, Stages(folder))
    assert made_anew(tmp_path, before) == ALL


def test_a_stage_has_another_key_exactly_where_something_that_it_depends_on_is_another(scan):
    folder, embedding = scan
    root = embedding.cannula[0].tolist()
    volume = read_volume(folder / "image.nrrd")

    def keys(image="image", **options):
        own = Options(**({"root": root} | options))
        return keys_of(image, given(volume, volume, own), own)

    def same(other):
        return {name for name in Keys._fields if getattr(other, name) == getattr(keys(), name)}

    everything = set(Keys._fields)
    assert same(keys(pressure=10.0, vessels=3, min_radius=None, scale="cannula")) == everything
    assert same(keys(cannula=0.08)) == everything - {"grey"}  # a cannula is cut off, whatever its size
    assert same(keys(cannula=0)) == everything - {"axes", "elsewhere", "grey"}
    assert same(keys(loops="open")) == everything - {"loops"}
    assert same(keys(outlets=[root])) == everything - {"loops", "axes", "elsewhere", "grey"}
    assert same(keys(root=[0, 0, 0], seed=root)) == {"lumen", "profiles"}  # strangers are cut by the root's radius
    assert same(keys(threshold=44.0)) == same(keys(method="level-set")) == set()  # profiles know what is closed in it
    assert same(keys(region=([0, 0, 0], [1, 1, 1]))) == set()
    assert same(keys(image="another")) == set()


def test_what_is_kept_is_bounded(scan, tmp_path):
    folder, embedding = scan
    stages, _ = copied(folder, tmp_path)
    (tmp_path / FOLDER / "older.stage").write_bytes(b"of an earlier program")
    extracted(folder, Options(embedding.cannula[0].tolist(), threshold=44.0), stages)
    kept = {file.stem: file.stat().st_size for file in (tmp_path / FOLDER).iterdir()}
    assert set(kept) == ALL
    assert sum(kept.values()) < 2.5 * 4 * 100**3
