import csv
import json
import shutil

import numpy as np
import pytest
import SimpleITK
from typer.testing import CliRunner

from extract_command import run
from made_phantom import NETWORK, VOXEL, outlets_of, root_of
from vasowave.base import InputError
from vasowave.cli import app
from vasowave.lung import match, unmatched
from vasowave.lung.exchange import read_centerlines
from vasowave.lung.measure import network_of
from vasowave.lung.read import Volume, write_volume
from vasowave.pulse.network import Network, write_network
from vasowave.pulse.network_formats import read_network


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.validation
def test_the_edited_mask_gives_the_network_that_was_left_in_it(extracted, scan, tmp_path):
    folder, embedding, volume = extracted[0], scan[1], scan[2]
    image = SimpleITK.ReadImage(str(folder / "mask.nrrd"))
    labels = SimpleITK.GetArrayFromImage(image)
    away = embedding.lines[4][3 * len(embedding.lines[4]) // 10 :]  # most of vessel 5 is erased
    z, y, x = np.indices(labels.shape) * VOXEL + volume.origin[:, None, None, None]
    for point in away[::4]:
        labels[(z - point[0]) ** 2 + (y - point[1]) ** 2 + (x - point[2]) ** 2 < 0.06**2] = 0
    for label, point in ((2, embedding.cannula[0] + [0.02, 0, 0]), (3, embedding.lines[2][-1]),
                         (4, embedding.lines[3][-1])):  # fmt: skip
        near = (z - point[0]) ** 2 + (y - point[1]) ** 2 + (x - point[2]) ** 2 < 0.02**2
        labels[near & (labels > 0)] = label
    edited = SimpleITK.GetImageFromArray(labels)
    edited.CopyInformation(image)
    SimpleITK.WriteImage(edited, str(tmp_path / "edited.nrrd"))
    result, _ = run(scan[0] / "dicom", "-o", tmp_path / "out", "--mask", tmp_path / "edited.nrrd")
    assert result.exit_code == 0, repr(result.exception)
    found = read_network(tmp_path / "out" / "network.csv")
    left = Network(("1", "24", "3"), np.array([-1, 0, 0]), np.array([0.35, 0.65, 0.3]), NETWORK.radius[:3])
    pairs = match(left, found)
    assert len(found) == len(pairs) == 3
    np.testing.assert_allclose(found.length[[pairs[row] for row in range(3)]], left.length, atol=0.04)


def test_the_spread_over_thresholds_is_that_of_the_edited_tree(scan, tmp_path):
    folder, embedding, _ = scan
    middle = embedding.lines[4][2 * len(embedding.lines[4]) // 3]
    (tmp_path / "edits.txt").write_text(
        f"root {' '.join(root_of(embedding).split(','))}\nremove {middle[2]} {middle[1]} {middle[0]}\n"
    )
    result, notes = run(
        folder / "image.nrrd", "-o", tmp_path / "out", "--edits", tmp_path / "edits.txt", *outlets_of(embedding)
    )
    assert result.exit_code == 0, repr(result.exception)
    rows = table(tmp_path / "out" / "network.csv")
    assert len(rows) == 3
    assert all(row["radius_sd [cm]"] for row in rows), notes
    lengths = sorted(float(row["length [cm]"]) for row in rows)
    np.testing.assert_allclose(lengths, [0.3, 0.35, 0.65], atol=0.04)


@pytest.mark.validation
def test_a_voxel_size_that_is_wrong_by_5_percent_is_put_right_by_the_cannula(scan, tmp_path):
    _, embedding, volume = scan
    shift = 1.05
    wrong = Volume(volume.grey, volume.spacing * shift, volume.origin * shift)
    write_volume(wrong, tmp_path / "wrong.nrrd")
    places = ["--root", root_of(embedding), *outlets_of(embedding)]
    places[1::2] = [",".join(str(shift * float(v)) for v in text.split(",")) for text in places[1::2]]
    found = {}
    for scale in ("file", "cannula"):
        result, notes = run(
            tmp_path / "wrong.nrrd", "-o", tmp_path / scale, "--scale", scale, "--vessels", "3", *places
        )
        assert result.exit_code == 0, repr(result.exception)
        assert any("the cannula measures" in note for note in notes)
        found[scale] = read_network(tmp_path / scale / "network.csv")
    assert len(found["cannula"]) == 3
    factor = json.loads((tmp_path / "cannula" / "extraction.json").read_text())["settings"]["scale factor"]
    assert float(factor) == pytest.approx(1 / 1.05, rel=0.012)
    np.testing.assert_allclose(found["cannula"].length, found["file"].length * float(factor), rtol=1e-4)
    np.testing.assert_allclose(found["cannula"].radius, found["file"].radius * float(factor), rtol=1e-4)
    again = read_centerlines(tmp_path / "cannula" / "centerlines.vtp", 0.1, cut="identical")
    np.testing.assert_allclose(np.sort(network_of(again).length), np.sort(found["cannula"].length), rtol=1e-6)


def test_without_a_root_and_a_cannula_the_command_names_the_ends_one_could_mean(scan, tmp_path):
    folder, embedding, _ = scan
    result, _ = run(folder / "image.nrrd", "-o", tmp_path / "out", "--cannula", "0")
    assert isinstance(result.exception, InputError)
    offers = str(result.exception).split("lumen: ")[1].split("; ")
    places = [[float(v) for v in offer.split(" ")[0].split(",")] for offer in offers]
    near = [np.linalg.norm(np.array(place)[::-1] - embedding.cannula[0]) < 0.1 for place in places]
    assert sum(near) == 1
    assert not (tmp_path / "out").exists()


def test_a_second_run_replaces_the_first_and_leaves_the_users_own_files(extracted, scan, tmp_path):
    folder, embedding, _ = scan
    shutil.copytree(extracted[0], tmp_path / "out")
    arguments = [folder / "dicom", "-o", tmp_path / "out", "--root", root_of(embedding), *outlets_of(embedding)]
    assert len(read_network(tmp_path / "out" / "network.csv")) == 5
    (tmp_path / "out" / "edits.txt").write_text("# mine\n")
    assert run(*arguments, "--generations", "2")[0].exit_code == 0
    assert (tmp_path / "out" / "edits.txt").read_text() == "# mine\n"
    assert len(read_network(tmp_path / "out" / "network.csv")) == 3
    assert not list(tmp_path.glob(".*"))


def test_match_pairs_two_networks_and_lists_who_is_left(tmp_path):
    more = Network(
        (*NETWORK.name, "6", "7"), np.array([*NETWORK.parent, 2, 2]),
        np.array([*NETWORK.length, 0.2, 0.1]), np.array([*NETWORK.radius, 0.02, 0.015]),
    )  # fmt: skip
    pairs = match(NETWORK, more)
    assert pairs == {row: row for row in range(5)}
    assert unmatched(NETWORK, more, pairs) == ([], ["6", "7"])
    write_network(NETWORK, tmp_path / "a.csv")
    write_network(more, tmp_path / "b.csv")
    result = CliRunner().invoke(
        app, ["match", str(tmp_path / "a.csv"), str(tmp_path / "b.csv"), "-o", str(tmp_path / "m.csv")]
    )
    assert result.exit_code == 0
    assert [row["second"] for row in table(tmp_path / "m.csv")] == list("12345")
    assert "b.csv: 2 vessels without counterpart: 6, 7" in result.output
