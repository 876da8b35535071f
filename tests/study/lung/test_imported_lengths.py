"""Lines of other programs get the lengths that an extraction gives, and an SD that holds what they leave open."""

import csv
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree
from test_turned_images import ENDS as TURNED_ENDS
from test_turned_images import JUNCTION as TURNED_JUNCTION
from test_turned_images import ROOT as FIRST
from test_turned_images import SPACING, fork_image
from typer.testing import CliRunner

from foreign_lines import outcome
from vasowave.base import InputError, VasowaveWarning
from vasowave.cli import app
from vasowave.lung import Line, Options, Tree, extract
from vasowave.lung.axes import cut_at_junctions
from vasowave.lung.exchange import (
    Alike,
    PolyLines,
    as_extracted,
    measured_lines,
    merged,
    read_surface_points,
    write_centerlines,
    write_stl,
    write_surface_vtp,
    write_vtp,
)
from vasowave.lung.lumen import Surface, surface_points
from vasowave.lung.read import Volume

LONGER = 36
ROOT = np.subtract(FIRST, [LONGER, 0, 0]) * SPACING  # z, y, x, cm
JUNCTION, ENDS = TURNED_JUNCTION * SPACING, TURNED_ENDS * SPACING
RADII = np.array([5.0, 4.0, 3.2]) * SPACING
TRUE = np.linalg.norm([JUNCTION - ROOT, *(ENDS - JUNCTION)], axis=1)


def fork_lines(missing=0.0, rough=0.0, late=False):
    """Both ways from the root: their steps and radii scatter by `rough`; they end `missing` radii early, as VMTK's do.

    Where `late`, daughters leave the parent's line in a curve, a radius and a half beyond the junction.
    """
    rng, lines = np.random.default_rng(4), []
    for end, radius in zip(ENDS, RADII[1:], strict=True):
        along = (end - JUNCTION) / np.linalg.norm(end - JUNCTION)
        begin = ROOT + np.array([missing * RADII[0], 0, 0])
        corners = np.array([begin, JUNCTION, end - missing * radius * along])
        run = np.append(0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
        count = int(run[-1] / 0.004)
        at = np.append(0, np.cumsum(rng.uniform(1 - rough, 1 + rough, count) ** 2))
        at *= run[-1] / at[-1]
        points = np.stack([np.interp(at, run, corners[:, k]) for k in range(3)], axis=1)
        if late:
            beyond = np.clip((at - run[1]) / (1.5 * RADII[0]), 0, 1)[:, None]
            straight = JUNCTION + np.outer(at - run[1], [1.0, 0, 0])
            points = np.where(at[:, None] > run[1], beyond * points + (1 - beyond) * straight, points)
        wide = np.where(at < run[1], RADII[0], radius) * (1 + 0.01 * bool(rough) * rng.normal(size=len(at)))
        lines.append(Line(points, wide))
    return lines


@pytest.fixture(scope="module")
def extracted():
    """Lengths and their SD by `extract` from a volume of the fork, and the points of its surface."""
    volume = Volume(fork_image(LONGER), np.full(3, SPACING), -np.array([LONGER, 0, 0]) * SPACING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = extract(volume, Options(np.add(ROOT, [0.02, 0, 0]), ENDS, cannula=0))
    length, sd = lengths(Alike(found.tree, found.measured.length_sd))
    length[0] += 0.02  # the root was given inside
    return length, sd, surface_points(found.lumen)


def lengths(alike):
    """Return the lengths of the root and of the daughters in the order of ENDS, and their SD."""
    length = np.array([line.length for line in alike.tree.lines])
    ends = np.array([line.points[-1] for line in alike.tree.lines[1:]])
    order = [0, *(1 + np.linalg.norm(ends - end, axis=1).argmin() for end in ENDS)]
    return length[order], alike.length_sd[order]


@pytest.mark.parametrize("with_surface", [False, True], ids=["alone", "surface"])
@pytest.mark.parametrize(
    "lines",
    [{}, {"missing": 1.0, "rough": 0.9}, {"missing": 1.0, "rough": 0.9, "late": True}],
    ids=["drawn", "balls", "late"],
)
def test_a_fork_has_the_lengths_of_its_extraction_however_its_lines_run(extracted, lines, with_surface):
    way = fork_lines(**lines)
    if lines:  # as VMTK lays balls into the surface; radii that were drawn step at the junction, and show it too early
        wall = cKDTree(extracted[2])
        way = [Line(line.points, wall.query(line.points)[0]) for line in way]
    tree = cut_at_junctions(merged(way))
    alike = as_extracted(tree, extracted[2] if with_surface else None)
    length, sd = lengths(alike)
    if lines or with_surface:
        assert np.median(np.abs(length / extracted[0] - 1)) < 0.04  # the aim
    assert (np.abs(length - extracted[0]) < 2 * np.hypot(sd, extracted[1])).all()
    assert (np.abs(length - TRUE) < 2 * sd).all()
    assert (sd < 0.1 * TRUE).all()
    np.testing.assert_allclose([np.median(line.radius) for line in alike.tree.lines[:1]], RADII[:1], rtol=0.03)


def test_an_end_that_may_be_either_is_put_in_the_middle_and_its_sd_holds_both():
    rng = np.random.default_rng(1)
    even = fork_lines(missing=1.0)  # steps tell nothing, and the radii were measured
    shaken = [Line(line.points, line.radius * (1 + 0.01 * rng.normal(size=len(line)))) for line in even]
    tree = cut_at_junctions(merged(shaken))
    middle, ball, wall = (lengths(as_extracted(tree, None, ends)) for ends in ("auto", "ball", "wall"))
    np.testing.assert_allclose(middle[0][1:], (ball[0][1:] + wall[0][1:]) / 2, rtol=0.02)
    np.testing.assert_allclose(ball[0][1:] - wall[0][1:], RADII[1:], rtol=0.2)
    assert (np.abs(middle[0] - TRUE) < 2 * middle[1]).all()
    assert (middle[1][1:] > ball[1][1:]).all()


@pytest.mark.parametrize("pieces", [1, 2, 5])
def test_an_end_of_an_appended_point_of_the_wall_is_not_prolonged_in_how_many_pieces_the_step_may_be(pieces):
    lines = fork_lines(missing=1.0, rough=0.9)
    appended = []
    for line, end in zip(lines, ENDS, strict=True):
        touching = np.linalg.norm(end - line.points[-1])  # the radius of the last ball
        line = Line(line.points, np.append(line.radius[:-1], touching))
        first = np.linspace(ROOT, line.points[0], pieces + 1)[:-1], np.full(pieces, line.radius[0])
        last = np.linspace(line.points[-1], end, pieces + 1)[1:], np.full(pieces, touching)
        appended.append(Line(*first).then(line, Line(*last)))
    bare, whole = (lengths(as_extracted(cut_at_junctions(merged(one)))) for one in (lines, appended))
    ways = [one[0][0] + one[0][1:] for one in (bare, whole)]  # from the root to the ends, wherever they part
    np.testing.assert_allclose(*ways, rtol=0.01)


@pytest.fixture
def files(tmp_path, extracted):
    """The fork's lines as VMTK writes them (mm), and its surface."""
    lines = fork_lines(missing=1.0, rough=0.9)
    whole = lines[0].then(lines[1])
    rows = (np.arange(len(lines[0])), len(lines[0]) + np.arange(len(lines[1])))
    fields = {"MaximumInscribedSphereRadius": 10 * whole.radius}
    write_vtp(PolyLines(10 * whole.points[:, ::-1], rows, fields), tmp_path / "fork.vtp")
    points = extracted[2]
    surface = Surface(points, np.arange(3 * (len(points) // 3)).reshape(-1, 3))
    write_stl(surface, tmp_path / "fork.stl")
    write_surface_vtp(surface, tmp_path / "surface.vtp")
    corners = 10 * points[surface.triangles][:, :, ::-1]
    text = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join("vertex {:.6g} {:.6g} {:.6g}\n".format(*c) for c in three)
        + "endloop\nendfacet\n"
        for three in corners
    )
    (tmp_path / "text.stl").write_text(f"solid fork\n{text}endsolid fork\n")
    return tmp_path


@pytest.mark.parametrize("name", ["fork.stl", "surface.vtp", "text.stl"])
def test_a_surface_gives_the_corners_that_were_written(files, name, extracted):
    found = read_surface_points(files / name, 0.1)
    expected = extracted[2]
    expected = expected[: 3 * (len(expected) // 3)] if name.endswith(".stl") else expected
    assert len(found) == pytest.approx(len(np.unique(expected.round(6), axis=0)), rel=0.02)
    np.testing.assert_allclose(found.min(axis=0), expected.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(found.max(axis=0), expected.max(axis=0), atol=1e-6)


def run(*arguments):
    return CliRunner().invoke(app, ["centerlines", *map(str, arguments)])


def test_the_command_gives_lengths_with_their_sd(files):
    result = run(files / "fork.vtp", "-o", files / "out", "--unit", "mm", "--surface", files / "fork.stl")
    assert result.exit_code == 0, repr(result.exception)
    with (files / "out" / "vessels.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert all(0 < float(row["length_sd [cm]"]) < 0.05 for row in rows)
    measured = measured_lines(files / "fork.vtp", 0.1, surface=files / "fork.stl")
    assert np.median(np.abs(np.sort(measured.network.length) / np.sort(TRUE) - 1)) < 0.04


def test_a_surface_in_another_unit_is_refused(files):
    corners = read_surface_points(files / "fork.stl", 1.0)  # mm taken for cm
    write_stl(Surface(corners, np.arange(3 * (len(corners) // 3)).reshape(-1, 3)), files / "large.stl")
    with pytest.raises(InputError, match="are its unit and its place theirs"):
        measured_lines(files / "fork.vtp", 0.1, surface=files / "large.stl")


def test_half_a_surface_file_is_refused(files):
    (files / "half.stl").write_bytes((files / "fork.stl").read_bytes()[:-70])
    with pytest.raises(InputError, match=r"half\.stl: not a whole STL file"):
        read_surface_points(files / "half.stl", 0.1)
    text = (files / "text.stl").read_text()
    (files / "half.stl").write_text(text[: len(text) // 2])
    with pytest.raises(InputError, match=r"half\.stl: not a whole STL file"):
        read_surface_points(files / "half.stl", 0.1)


@pytest.mark.parametrize(
    ("unit", "scale", "message"),
    [
        ("um", 1.0, "the unit is probably mm"),
        ("cm", 1.0, "the unit is probably mm"),
        ("mm", 20.0, r"the numbers are probably voxels.*as the unit \(0\.002 to 0\.008 would fit\)"),
        ("mm", 4.0, "it would fit a rat"),
    ],
)
def test_a_root_that_no_mouse_has_is_refused_with_the_likely_unit(files, unit, scale, message):
    tree = Tree(tuple(cut_at_junctions(merged(fork_lines())).lines), np.array([-1, 0, 0]))
    write_centerlines(tree.times(scale), files / "lines.vtp", unit=0.1)
    arguments = (files / "lines.vtp", "-o", files / "out", "--unit", unit, "--cut", "identical")
    result = run(*arguments)
    assert isinstance(result.exception, InputError)

    assert re.search(message, str(result.exception)), str(result.exception)
    assert not (files / "out").exists()
    if scale == 4.0:
        assert run(*arguments, "--species", "rat").exit_code == 0
    assert run(*arguments, "--species", "other").exit_code == 0


LUNG = Path(__file__).parents[3] / ".." / "shared" / "data" / "mouse-lung-centerline"


@pytest.mark.skipif(not LUNG.exists(), reason="the measured mouse lung is not beside the project")
def test_the_helps_own_example_on_a_lung_in_voxels_is_an_error(tmp_path):
    result = run(next(LUNG.glob("*.vtp")), "-o", tmp_path / "out", "--unit", "mm", "--cut", "identical")
    assert "the numbers are probably voxels" in str(result.exception)
    assert "0.002 to 0.0081 would fit" in str(result.exception)  # its voxels have 0.00427 cm


@pytest.mark.validation
@pytest.mark.parametrize(("kind", "seed"), [("plain", 3101), ("taper 15 %", 3102)])
def test_lines_along_the_voronoi_diagram_have_true_lengths_and_those_of_the_extraction(kind, seed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        found = outcome(kind, seed)
    ways = ("vmtk", "appended", "curves", "vmtk, surface", "appended, surface", "curves, surface")
    assert all(np.median(np.abs(found[name]["length"])) < 0.04 for name in ways)
    for beside in ("sd", "both doors"):  # a volume has eleven vessels, too few to judge each way by itself
        held = [np.abs(found[name][beside]) < 2 for name in ways]
        assert np.mean(np.concatenate(held)) >= 0.9
        assert min(map(np.mean, held)) >= 0.8
    assert np.median(np.abs(found["vmtk, cut tube"]["length"])) > 0.04  # what it is needed for
