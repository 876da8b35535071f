import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np

import approval
from made_phantom import NETWORK, root_of
from vasowave.lung import match
from vasowave.lung.kept import read_value
from vasowave.pulse.network_formats import read_network


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_the_command_writes_everything_and_the_network_is_the_phantoms(extracted):
    folder, result, _ = extracted
    assert sorted(path.name for path in folder.iterdir()) == [
        "centerlines.csv", "centerlines.swc", "centerlines.vtp", "connectivity.csv", "dimensions.csv",
        "extraction.json", "figures", "mask.nrrd", "network.csv", "review.html", "stages", "surface.stl",
        "surface.vtp", "vessels.csv",
    ]  # fmt: skip
    found = read_network(folder / "network.csv")
    pairs = match(NETWORK, found)
    assert len(pairs) == len(found) == 5
    order = [pairs[row] for row in range(5)]
    # What IMAGING measured at this resolution: 5 % in the radius and 0.02 cm in the length.
    np.testing.assert_allclose(found.radius[order], NETWORK.radius, rtol=0.05)
    np.testing.assert_allclose(found.length[order], NETWORK.length, atol=0.025)
    for stage in ("image", "lumen", "axes", "radii", "uncertainty", "results"):
        assert f"{stage} …" in result.output


def test_the_table_carries_the_spread_of_the_radius_and_the_taper_of_straight_tubes_is_none(extracted):
    folder, _, _ = extracted
    spread = [float(row["radius_sd [cm]"]) for row in table(folder / "network.csv")]
    radius = [float(row["radius [cm]"]) for row in table(folder / "network.csv")]
    assert all(0 < sd < 0.05 * r for sd, r in zip(spread, radius, strict=True))
    rows = table(folder / "vessels.csv")
    assert [row["generation"] for row in rows] == ["1", "2", "2", "3", "3"]
    slopes = [(float(row["taper [cm/cm]"]), float(row["taper_se [cm/cm]"])) for row in rows if row["taper [cm/cm]"]]
    assert len(slopes) >= 3
    assert all(abs(slope) < 0.02 for slope, _ in slopes)
    network = read_network(folder / "network.csv")
    seen = np.isfinite(network.taper)
    assert seen.sum() >= 3  # and by the sections' areas
    assert np.all(np.abs(network.taper[seen]) < 0.02)
    np.testing.assert_allclose(network.radius_sd, spread)


def test_approved_what_an_extraction_writes_and_draws(extracted):
    folder, _, _ = extracted
    stored = json.loads((folder / "extraction.json").read_text(encoding="utf-8"))
    told = [f"{key}: {value}" for key in ("settings", "notes", "doubts") for value in stored[key]]
    tables = [line for path in sorted(folder.glob("*.csv")) for line in approval.table(path)]
    words = [line.replace(str(folder.parent), "…") for line in approval.page(folder / "review.html")]
    approval.approve("extraction", [*told, *tables, *words], 1e-4, 3 * PROCESSORS)  # cm, cm/cm of taper; two digits
    approval.approve("extraction, figures", approval.figures(folder / "figures"), 0.2, PROCESSORS)


def test_approved_what_every_stage_of_an_extraction_finds(extracted):
    folder, _, _ = extracted
    found = []
    for path in sorted((folder / "stages").glob("*.stage")):
        key = path.read_bytes()[32:96].decode()
        found += approval.parts(path.stem, read_value(path, key)[1])
    approval.approve("extraction, stages", found, 1e-4, PROCESSORS)  # cm


PROCESSORS = 1e-2  # of a number: another processor adds in another order, and searches end a little elsewhere


def test_an_interrupt_leaves_nothing_behind(scan, tmp_path):
    folder, embedding, _ = scan
    # A background job inherits a SIGINT that is ignored.
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from vasowave.cli import run; run()"
    )
    arguments = ["extract", folder / "image.nrrd", "-o", tmp_path / "out", "--root", root_of(embedding)]
    with subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)], stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    ) as process:  # fmt: skip
        for line in process.stderr:
            if line.startswith("results"):
                time.sleep(0.3)
                process.send_signal(signal.SIGINT)
                break
        rest = process.stderr.read()
        assert process.wait(60) == 130, rest
    assert "nothing half-written was left" in rest
    assert not list(tmp_path.iterdir())
