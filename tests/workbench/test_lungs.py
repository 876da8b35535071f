"""The Lung desk: an image by clicks to a network that the command line gives too."""

import json
import subprocess
import sys

import numpy as np
import pytest
from served import served

from driven import driven
from vasowave.base import InputError
from vasowave.lung import Options, extract
from vasowave.lung.read import write_volume
from vasowave.pulse.network_formats import read_network
from vasowave.study.entering import new_study
from vasowave.workbench import Desk, Lungs, Wishes, Workplace, act, opened, smaller

pytestmark = pytest.mark.filterwarnings("ignore::vasowave.base.errors.VasowaveWarning")  # the lumen touches the border
WISHES = {"threshold": 100.0, "cannula": 0.0, "species": "other"}
ROOT = (0.03, 0.06, 0.002)


@pytest.fixture
def lab(scan, tmp_path):
    """A study whose only file is the image."""
    folder = tmp_path / "study"
    new_study(folder)
    (folder / "images").mkdir()
    write_volume(scan, folder / "images" / "mouse 6.nrrd")
    return folder


@pytest.fixture
def at(lab):
    return Workplace.around(Desk(lab))


def do(at, what, **given):
    return act(at, {"do": what, "image": "mouse 6", **given})


def found(at):
    return at.lungs.shown(at.desk, "mouse 6", Wishes(**WISHES))


def begun(at):
    """Return the vessels after a root was said, and the middle of one of the two daughters."""
    at.lungs.reduced(at.desk, "mouse 6")
    do(at, "edit-tree", action="root", point=ROOT)
    shown = found(at)
    daughter = shown["vessels"][-1]["points"]
    return shown, daughter[len(daughter) // 2][:3]


def by_command(lab):
    """Return the network that `vasowave extract` finds with the file of edits."""
    options = Options(threshold=100.0, cannula=0.0, species="other", edits=lab / "edits" / "mouse 6.txt")
    return extract(lab / "images" / "mouse 6.nrrd", options).network


def test_edits_of_the_desk_are_the_file_that_extract_reads_and_give_its_network(at, lab):
    shown, point = begun(at)
    assert len(shown["vessels"]) == 3
    do(at, "edit-tree", action="root", point=ROOT)  # takes the place of the one before
    assert (lab / "edits" / "mouse 6.txt").read_text(encoding="utf-8").count("root") == 1
    do(at, "edit-tree", action="radius", point=point, radius=0.0123)
    do(at, "edit-tree", action="move", point=shown["vessels"][0]["points"][-1][:3], to=[0.03, 0.061, 0.093])
    ours, theirs = found(at), by_command(lab)
    assert [one["name"] for one in ours["vessels"]] == list(theirs.name)
    for field in ("length", "radius"):  # five digits are sent to the page
        np.testing.assert_allclose([one[field] for one in ours["vessels"]], getattr(theirs, field), rtol=1e-4)
    assert 0.0123 in theirs.radius


def test_an_edit_that_cannot_be_made_is_refused_and_the_file_stays(at, lab):
    _, point = begun(at)
    before = (lab / "edits" / "mouse 6.txt").read_bytes()
    for wrong, why in (({"action": "merge", "point": point}, "this is a terminal"),
                       ({"action": "cut", "point": [0.001, 0.001, 0.17]}, "no vessel at"),
                       ({"action": "move", "point": point}, "a move has a place"),
                       ({"action": "radius", "point": point, "radius": -1.0}, "radius"),
                       ({"action": "remove", "point": [float("nan")] * 3}, "finite")):  # fmt: skip
        with pytest.raises(InputError, match=why):
            do(at, "edit-tree", **wrong)
        assert (lab / "edits" / "mouse 6.txt").read_bytes() == before
    with pytest.raises(InputError, match="no image"):
        act(at, {"do": "edit-tree", "image": "../mouse 6", "action": "root", "point": ROOT})


def test_edits_that_are_no_text_are_named_and_stay(at, lab):
    path, content = lab / "edits" / "mouse 6.txt", b"# von J\xfcrgen\nroot 1 2 3\n"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    at.lungs.reduced(at.desk, "mouse 6")
    for wrong in (
        lambda: at.lungs.described(at.desk, "mouse 6"),
        lambda: do(at, "edit-tree", action="root", point=ROOT),
        lambda: do(at, "forget-edit", line=2, text="root 1 2 3"),
    ):
        with pytest.raises(InputError, match=r"mouse 6\.txt: is not a text in UTF-8; save it as that"):
            wrong()
    assert path.read_bytes() == content


@pytest.mark.validation
def test_edits_are_undone_and_forgotten_and_what_another_hand_wrote_stays(at, lab):
    shown, point = begun(at)
    path = lab / "edits" / "mouse 6.txt"
    do(at, "edit-tree", action="remove", point=point)
    assert len(found(at)["vessels"]) == 1
    act(at, {"do": "undo"})
    assert found(at)["vessels"] == shown["vessels"]
    path.write_text(path.read_text(encoding="utf-8") + "# looked at by Ada\nunit mm\n", encoding="utf-8")
    do(at, "edit-tree", action="radius", point=point, radius=0.0123)
    text = path.read_text(encoding="utf-8")
    assert "by Ada" in text
    assert 0.0123 in by_command(lab).radius  # in cm, although mm stood above
    line = text.splitlines().index(next(one for one in text.splitlines() if one.startswith("radius"))) + 1
    with pytest.raises(InputError, match="changed elsewhere"):
        do(at, "forget-edit", line=line, text="radius 1 2 3 4")
    do(at, "forget-edit", line=line, text=text.splitlines()[line - 1])
    assert "radius" not in path.read_text(encoding="utf-8")


def test_the_image_of_a_screen_is_the_mean_of_its_voxels():
    grey = np.random.default_rng(1).random((200, 150, 3), dtype=np.float32)
    small, step = smaller(grey)
    assert (step, small.shape) == (2, (100, 75, 2))
    assert small[3, 4, 0] == pytest.approx(grey[6:8, 8:10, :2].mean(), rel=1e-6)
    assert small[3, 4, 1] == pytest.approx(grey[6:8, 8:10, 2].mean(), rel=1e-6)  # the last plane, which has no pair
    assert smaller(grey[:100])[1] == 2
    assert smaller(grey[:100, :100])[1] == 1


def test_an_image_that_is_opened_gets_a_study_and_stays_where_it_is(scan, tmp_path):
    image = tmp_path / "lung.nrrd"
    write_volume(scan, image)
    place = opened(image)
    assert (place.folder, place.desk, place.image) == (tmp_path / "lung study", "#lung/lung", image)
    assert Lungs(image).images(Desk(place.folder)) == {"lung": image}


READ = "document.querySelectorAll('tr[data-vessel]').length"


def test_an_image_becomes_a_network_by_clicks_and_keys(lab, tmp_path):
    """Root by a click into a slice; a daughter removed, taken back, a radius set; the table follows."""
    with driven(tmp_path) as program, served(lab) as door:
        page = program.page(f"{door.origin}{door.root}#lung/mouse%206")
        page.until("Number(document.querySelector('canvas.slice')?.dataset.drawn) > 0")
        for key, value in (("threshold", "100"), ("cannula", "0")):
            page.type(f"[data-key={key}]", value)
        page.choose("[data-key=species]", "other")
        x, y = page.place("canvas.slice:nth-child(3)")  # along x: y runs right, z up
        size = "(({clientWidth, clientHeight}) => [clientWidth, clientHeight])(document.querySelector('canvas.slice'))"
        wide, high = page.js(size)
        scale = min(wide / 0.12, high / 0.18)
        for kind in ("mousePressed", "mouseReleased"):
            page.mouse(kind, x, y + scale * 0.0875)  # 2.5 voxels from the lower edge
        page.click_text("Blood enters here")
        page.until(f"{READ} === 3", 60)
        assert (lab / "edits" / "mouse 6.txt").read_text(encoding="utf-8").count("root") == 1
        page.click("[data-key='look 3']")
        page.click("[data-edit=remove]")
        page.until(f"{READ} === 1")
        page.click("#undo")
        page.until(f"{READ} === 3")
        page.click("[data-key='look 2']")
        page.type("[data-key=radius]", "0.0125")
        page.click_text("Set it")
        page.until("document.querySelector('[data-vessel=\"2\"]').innerText.includes('0.0125')")
        page.click("[data-key='look 1']")
        page.click("canvas.slice:nth-child(3)")  # its middle, where the vessel ends
        page.until("!document.querySelector('[data-key=move]').disabled")
        page.click("[data-key=move]")
        page.js("document.querySelector('canvas.slice:nth-child(3)').focus()")
        for _ in range(2):
            page.key("ArrowRight")
        before = page.js("document.querySelector('#vessels').innerText")
        page.click_text("move it here")
        page.until(f"document.querySelector('#vessels').innerText !== {json.dumps(before)}")
        edits = (lab / "edits" / "mouse 6.txt").read_text(encoding="utf-8")
        place = next(line for line in edits.splitlines() if line.startswith("move")).split()[1:]
        x, y, z, *to = map(float, place)
        assert to == pytest.approx([x, y + 0.004, z], abs=1e-4)  # two voxels
        page.click("#write")
        page.until("document.body.innerText.includes('network.csv is written')", 60)
        drawn = page.js("document.querySelector('canvas.slice').dataset.drawn")
        page.js("document.querySelector('canvas.slice').focus()")
        page.key("PageUp")
        page.until(f"document.querySelector('canvas.slice').dataset.drawn !== {json.dumps(drawn)}")
        assert page.errors == []
    assert 0.0125 in read_network(lab / "lungs" / "mouse 6" / "network.csv").radius


@pytest.mark.validation
def test_the_folder_of_the_desk_is_the_folder_of_the_command(at, lab):
    """Same bytes, save for what names the image's place and the time of the day."""
    _, point = begun(at)
    do(at, "edit-tree", action="cut", point=point)
    do(at, "write-lung", wishes=WISHES)
    by_hand = lab.parent / "by hand"
    subprocess.run(
        [sys.executable, "-m", "vasowave", "extract", lab / "images" / "mouse 6.nrrd", "-o", by_hand, "--threshold",
         "100", "--cannula", "0", "--species", "other", "--edits", lab / "edits" / "mouse 6.txt"],
        check=True, capture_output=True,
    )  # fmt: skip
    for name in ("network.csv", "vessels.csv", "centerlines.csv", "centerlines.vtp", "mask.nrrd", "surface.stl"):
        assert (lab / "lungs" / "mouse 6" / name).read_bytes() == (by_hand / name).read_bytes(), name
