"""Six tabs of two workbenches, `vasowave add` and an editor change one study at once: nothing confirmed is lost."""

import os
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress

import pytest
from served import Asker, served

import vasowave as vw
from vasowave.base import InputError
from vasowave.study.entering import add_files, read_rows

CHANGES = int(os.environ.get("VASOWAVE_CHANGES", "200"))
"""Of all tabs together."""

TABS = ("mouse_c1", "mouse_c2", "mouse_c3", "mouse_h1", "mouse_h2", "mouse_h3")
"""Each tab changes a row, whose cell no other hand changes."""


@contextmanager
def another(folder):
    """A workbench that is a program of its own."""
    command = [sys.executable, "-m", "vasowave", "open", str(folder), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        address = next(found[0] for line in program.stdout if (found := re.findall(r"http://\S+/", line)))
        try:
            yield Asker(address.rpartition("#")[0] or address, None, None)
        finally:
            program.terminate()


def cell(study, animal):
    return next(row["note"] for row in read_rows(study / "animals.csv").rows if row["animal"] == animal)


def tab(study, door, animal, lost):
    """Change a cell again and again; return how many changes were confirmed."""
    confirmed, text, sent, answered = 0, "", 0.0, 0.0
    for number in range(-(-CHANGES // len(TABS))):
        if (now := cell(study, animal)) != text:
            lost.append((animal, text, now, sent, answered))
            text = now
        new, sent = f"{animal} {number}", time.time()
        status, answer = door.post("act", {"do": "set-cells", "animal": animal, "cells": {"note": new}})
        if status == 200:
            confirmed, text, answered = confirmed + 1, new, time.time()
        else:
            assert "changed elsewhere meanwhile" in answer["error"] or "another program" in answer["error"], answer
    if (now := cell(study, animal)) != text:
        lost.append((animal, text, now, sent, answered))
    return confirmed


def edit(study, over, saves):
    """Save as an editor does, which takes no lock and replaces the file; keep when it read and when it wrote."""
    file, part = study / "animals.csv", study / "animals.csv~"
    while not over.wait(0.5):
        began, content = time.time(), file.read_text("utf-8")
        part.write_text(content.replace("\n", f"\n# saved {len(saves)}\n", 1) if "# saved" not in content else
                        re.sub("# saved .*", f"# saved {len(saves)}", content), "utf-8")  # fmt: skip
        part.replace(file)
        saves.append((began, time.time()))


@pytest.mark.validation
def test_what_six_tabs_an_editor_and_added_files_change_at_once_is_all_there(study, tmp_path):
    over, saves, lost, added = threading.Event(), [], [], []

    def add():
        mouse, titles = vw.virtual_mouse(), "time [s],pressure [mmHg],flow [ml/s]"
        while not over.wait(0.2):
            file = study / "recordings" / "control" / f"rat {len(added)}.csv"
            signals = zip(mouse.time, mouse.pressure + 0.01 * len(added), mouse.flow, strict=True)
            file.write_text("\n".join([titles, *(f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in signals), ""]), "utf-8")
            sent = time.time()
            with suppress(InputError):  # the editor has just saved
                add_files(study, [file], group="control")
                added.append((file.stem, sent, time.time()))

    with served(study) as one, another(study) as other, ThreadPoolExecutor(9) as hands:
        one.act("add-column", title="note")
        beside = [hands.submit(add), hands.submit(edit, study, over, saves)]
        tabs = [hands.submit(tab, study, (one, other)[i % 2], name, lost) for i, name in enumerate(TABS)]
        try:
            confirmed = sum(each.result() for each in tabs)
        finally:
            over.set()
        for each in beside:
            each.result()
    names = [row["animal"] for row in read_rows(study / "animals.csv").rows]
    print(f"{confirmed} confirmed, {len(added)} added, {len(saves)} saves, lost: {lost}")
    assert confirmed >= CHANGES // 4
    assert len(saves) >= 3
    assert len(added) >= 1
    # What an editor reads before a change and saves after it, no program can keep: it asks for no lock.
    gone = [*lost, *(one for one in added if one[0] not in names)]
    gaps = [any(began <= answered and sent <= ended for began, ended in saves) for *_, sent, answered in gone]
    assert [one for one, inside in zip(gone, gaps, strict=True) if not inside] == []
    assert {*names} <= {*TABS, *(name for name, *_ in added)}
    assert len(names) == len({*names})
