"""What asks for more than a study, a screen or a disk has is refused in a sentence, before it is begun."""

import errno
import json
import os
import threading
import time

import pytest
from served import served

from vasowave.base import InputError
from vasowave.study.running import read_study
from vasowave.workbench import server


@pytest.fixture(scope="module")
def door(kept_results):
    with served(kept_results) as one:
        yield one


def refusal(door, what, body):
    status, _, answer = door.raw(
        "POST", door.root + what, body if isinstance(body, bytes) else json.dumps(body).encode()
    )
    assert status == 400, answer
    return json.loads(answer)["error"]


def simulated(door, **values):
    return door.post("simulate", {"animal": "CTL 0", "law": "linear", "values": values})


@pytest.mark.parametrize("value", [1e-300, 1e300, 1e308])
@pytest.mark.parametrize("name", ["beta", "R_T", "tau", "length", "wall_viscosity"])
def test_a_value_that_is_no_animals_is_refused_with_the_range_of_those_that_can_be(door, name, value):
    status, answer = simulated(door, **{name: value})
    if (name, value) == ("wall_viscosity", 1e-300):  # as good as none
        assert status == 200
    else:
        assert status == 400
        assert f"{name}: {value:.3g} is far from " in answer["error"]
        assert "; give a value from " in answer["error"]


def test_values_at_the_end_of_the_range_are_tried_and_beyond_it_are_not(door):
    knobs = {one["name"]: one["value"] for one in door.get("model", animal="CTL 0", law="linear")["knobs"]}
    assert simulated(door, R_T=999 * knobs["R_T"])[0] == 200
    assert simulated(door, R_T=1001 * knobs["R_T"])[0] == 400
    assert simulated(door, beta=knobs["beta"] / 1001)[0] == 400
    assert simulated(door, length=9.9)[0] == 200
    assert simulated(door, length=10.1)[0] == 400


@pytest.mark.parametrize("text", ["1" + "0" * 400, "1e400", "NaN", "true", '"1"'])
def test_what_is_no_finite_number_is_no_value(door, text):
    body = f'{{"animal": "CTL 0", "law": "linear", "values": {{"R_T": {text}}}}}'.encode()
    assert refusal(door, "simulate", body) == "values are finite numbers by the names of parameters"


def test_a_figure_has_as_many_panels_as_there_are(door):
    assert refusal(door, "figure", {"animal": "CTL 0", "panels": ["flow"] * 8}).startswith(
        "panels: 8 values are too many"
    )
    assert refusal(door, "figure", {"animal": "CTL 0", "panels": ["flow"] * 500}).endswith("at once; at most 7")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without pipes")
@pytest.mark.parametrize("kind", ["pipe", "zero"])
def test_an_image_that_never_ends_is_refused(ran, kind):
    (ran / "images").mkdir()
    image = ran / "images" / "lung.nrrd"
    os.mkfifo(image) if kind == "pipe" else image.symlink_to("/dev/zero")
    with served(ran) as door:
        status, _, answer = door.raw("GET", door.root + "volume?image=lung")
        assert (status, "is a pipe or a device, not a file; copy its content" in json.loads(answer)["error"]) == (
            400,
            True,
        )
        assert "is a pipe or a device" in refusal(door, "vessels", {"image": "lung", "wishes": {}})


def test_decisions_on_all_beats_of_hours_are_taken_at_once_and_no_more_than_a_file_holds(asker, study):
    """Within a time in which 100 000 times 100 000 of them could not be compared."""

    def edited(count, offset):
        edits = [["reject", round(0.1 * i + offset, 4), None] for i in range(count)]
        return asker.post("act", {"do": "edit-beats", "animal": "mouse_c1", "edits": edits})

    assert edited(100_001, 0.0)[1]["error"] == "edits: 100001 values are too many at once; at most 100000"
    begun = time.monotonic()
    assert edited(100_000, 0.0)[1]["said"].startswith("100000 edits in ")
    assert edited(100_000, 0.0005)[1]["said"].startswith("100000 edits in ")  # of the same beats
    assert time.monotonic() - begun < 60
    before = (study / "edits" / "mouse_c1.csv").read_bytes()
    assert "100001 edits of beats; at most 100000" in edited(1, 20_000.0)[1]["error"]
    assert (study / "edits" / "mouse_c1.csv").read_bytes() == before


def test_a_table_of_a_hundred_thousand_animals_is_refused_before_its_rows_are_looked_at(tmp_path):
    rows = "".join(f"M{at},CTL,networks/a.csv,recordings/a.csv\n" for at in range(100_000))
    (tmp_path / "animals.csv").write_text(f"animal,group,network,recording\n{rows}")
    (tmp_path / "study.yaml").write_text("groups: [CTL]\n")
    with pytest.raises(InputError, match="100000 rows, and a study holds 10000 at most"):
        read_study(tmp_path)


def test_nobody_waits_for_what_takes_others_long(ran, monkeypatch):
    """A hundred figures are more than the forty threads that answer."""
    ended = threading.Event()
    monkeypatch.setattr(server, "line_of", lambda desk, wish: str(ended.wait(30)))
    with served(ran) as door:
        many = [threading.Thread(target=door.post, args=("figure", {"only": "line"})) for _ in range(100)]
        for one in many:
            one.start()
        try:
            assert door.get("results")["animals"]
            door.act("set-groups", groups=["CTL", "HPH", "third"])
            assert not ended.is_set()
        finally:
            ended.set()
            for one in many:
                one.join()


@pytest.mark.parametrize(
    ("number", "status", "said"),
    [(errno.ENOSPC, 507, "no space left on the disk; make room"),
     *((one, 403, f"/data/study: {os.strerror(one).lower()}; see who may read and write")
       for one in (errno.EROFS, errno.EACCES, errno.EPERM)),
     (errno.EIO, 500, "the workbench failed here (OSError: ")],
)  # fmt: skip
def test_a_disk_on_which_nothing_can_be_done_any_more_is_told_and_the_server_lives_on(
    kept_results, monkeypatch, number, status, said
):
    def failing(desk):
        raise OSError(number, os.strerror(number), "/data/study")

    monkeypatch.setattr(server, "checked", failing)
    with served(kept_results) as door:
        given, _, answer = door.raw("GET", door.root + "check")
        assert (given, json.loads(answer)["error"][: len(said)]) == (status, said)
        assert door.get("state")["study"]
