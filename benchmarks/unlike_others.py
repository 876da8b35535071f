"""Beside other programs on the same volumes: topology, lengths and radii of kimimaro, scikit-image's skeleton and VMTK.

Usage: python benchmarks/unlike_others.py run PYTHON RESULTS [volumes of each kind, 2] [first seed, 1000] [kind …]
       python benchmarks/unlike_others.py table RESULTS [page, docs/imaging.md]

PYTHON is that of an environment of its own (Python 3.12), in which the other programs are and vasowave is not:

    uv venv --python 3.12 others
    uv pip install --python others/bin/python kimimaro==5.8.5 vmtk==1.5.2 scikit-image==0.26.0

All get the lumen that vasowave finds, thresholded, with the cannula in it; VMTK is also told where the vessels end.
Lines become vessels by vasowave's own rules, so that only the lines differ. The root, which the cannula hides for the
others, is left out of lengths and radii. RESULTS gets a line a volume and program as it comes; what stands there is not
repeated.
"""

import json
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from unlike import KINDS, UNSEEN, make
from unlike_accuracy import pairing
from vasowave.base import VasowaveError, VasowaveWarning
from vasowave.lung import Line, Options, extract
from vasowave.lung.axes import Skeleton, cut_at_junctions
from vasowave.lung.exchange import merged
from vasowave.lung.lumen import segment
from vasowave.lung.measure import network_of

OURS, OTHERS = ("vasowave", "vasowave, guided"), ("kimimaro", "scikit-image", "vmtk")
THRESHOLD = 45.0
COLLAPSE = 0.6
"""Inner vessels shorter than so many radii are junctions, as in an extraction."""
BEGIN, END = "<!-- begin: other programs -->\n", "<!-- end: other programs -->\n"


def by_us(made, root, guided):
    """Return tree, lengths and radii of an extraction, and its CPU seconds."""
    begin = time.process_time()
    outlets = made.ends[made.terminals].tolist() if guided else None
    found = extract(made.volume, Options(root.tolist(), outlets, THRESHOLD))
    return found.tree, found.network, time.process_time() - begin


def by_another(program, python, made, root):
    """Return tree, lengths and radii of another program's lines, and its CPU seconds."""
    lumen = segment(made.volume, THRESHOLD, root)
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "lumen.npz", Path(folder) / "lines.npz"
        voxels = [(places - lumen.origin) / lumen.spacing for places in (root, made.ends[made.terminals])]
        np.savez(source, mask=lumen.mask, grey=lumen.grey, threshold=THRESHOLD, root=voxels[0], ends=voxels[1])
        script = Path(__file__).with_name("other_programs.py")
        command = [python, str(script), program, str(source), str(target)]
        subprocess.run(command, check=True, capture_output=True, timeout=600)
        with np.load(target) as file:
            lines = dict(file)
    line = Line(lines["points"] * lumen.spacing + lumen.origin, lines["radius"] * lumen.spacing)
    if "above" in lines:
        skeleton = Skeleton(line, lines["above"])
    else:
        rows = np.split(np.arange(len(line)), lines["line_ends"][:-1])
        skeleton = merged([line[own] for own in rows], "tube")
    tree = cut_at_junctions(skeleton, COLLAPSE)
    return tree, network_of(tree), float(lines["cost"])


def judged(made, tree, network):
    """Return whether the topology is right, and the errors of all vessels but the root, as shares."""
    order = pairing(made, tree)
    if order is None:
        return {"right": False, "count": len(network)}
    rows = np.flatnonzero(made.parent >= 0)
    found = np.array(order)[rows]
    length, radius = network.length[found] / made.length[rows] - 1, network.radius[found] / made.radius[rows] - 1
    return {"right": True, "count": len(network), "length": length.tolist(), "radius": radius.tolist()}


def run(python, path, count, first, kinds):
    done = {(one["kind"], one["seed"], one["program"]) for one in stored(path)}
    for seed in range(first, first + count):
        for kind in kinds:
            wanted = [program for program in (*OURS, *OTHERS) if (kind, seed, program) not in done]
            if not wanted:
                continue
            made = make((KINDS | UNSEEN)[kind], seed)
            if np.ptp(made.volume.spacing) > 0:
                continue  # the others take cubes
            for program in wanted:
                outcome = {"kind": kind, "seed": seed, "program": program} | one_outcome(program, python, made)
                with path.open("a") as file:
                    file.write(json.dumps(outcome) + "\n")
                print(outcome["kind"], seed, program, outcome.get("error", outcome.get("right")), flush=True)


def one_outcome(program, python, made):
    root = made.root + np.array([0.02, 0, 0])
    try:
        if program in OURS:
            tree, network, cost = by_us(made, root, program != OURS[0])
        else:
            tree, network, cost = by_another(program, python, made, root)
    except (VasowaveError, subprocess.SubprocessError, ValueError, IndexError) as error:
        told = getattr(error, "stderr", None)
        return {"error": (told.decode()[-200:] if told else str(error)[:200])}
    return judged(made, tree, network) | {"cost": cost}


def stored(path):
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def table(results):
    """Return the table: a row a kind, and for each program topology and errors in percent, median / 95th percentile."""
    programs = [*OURS, *OTHERS]
    lines = ["| kind | " + " | ".join(programs) + " |", "|---|" + "---|" * len(programs)]
    kinds = list(dict.fromkeys(one["kind"] for one in results))
    for kind in [*sorted(kinds, key=list(KINDS | UNSEEN).index), "all"]:
        cells = []
        for program in programs:
            runs = [one for one in results if one["program"] == program and kind in (one["kind"], "all")]
            good = [one for one in runs if one.get("right")]
            cells.append(f"{len(good)} of {len(runs)}: {spread(good, 'length')}; {spread(good, 'radius')}")
        lines.append(f"| {kind} | " + " | ".join(cells) + " |")
    costs = [np.mean([one["cost"] for one in results if one["program"] == program and "cost" in one] or [np.nan])
             for program in programs]  # fmt: skip
    lines.append("| CPU-s a volume | " + " | ".join(f"{cost:.1f}" for cost in costs) + " |")
    return "\n".join(lines) + "\n"


def spread(runs, what):
    values = 100 * np.abs(np.concatenate([one[what] for one in runs])) if runs else np.array([])
    return " / ".join(f"{value:.1f}" for value in np.quantile(values, (0.5, 0.95))) if len(values) else "–"


def put(text, page):
    """Put the table between its marks in `page`."""
    whole = page.read_text(encoding="utf-8")
    before, rest = whole.split(BEGIN)
    page.write_text(before + BEGIN + text + END + rest.split(END)[1], encoding="utf-8")


def main():
    warnings.simplefilter("ignore", VasowaveWarning)
    words = sys.argv[1:]
    if words[:1] == ["table"] and len(words) > 1:
        put(table(stored(Path(words[1]))), Path((words[2:] or ["docs/imaging.md"])[0]))
    elif words[:1] == ["run"] and len(words) > 2:
        numbers = [int(word) for word in words[3:] if word.isdigit()]
        kinds = [word for word in words[3:] if word in KINDS | UNSEEN] or list(KINDS | UNSEEN)
        count, first = [*numbers, *(2, 1000)[len(numbers) :]]
        run(words[1], Path(words[2]), count, first, kinds)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
