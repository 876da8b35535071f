"""The files that pages name: recordings and tables of synthetic mice with three vessels, and a scan of one."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.io import savemat
from skimage.measure import marching_cubes

import vasowave as vw
from lab_files import exported, recorded
from made_ventricle import made_ventricles
from phantom import embed, render, write_dicom_series
from vasowave.catheter import table_text
from vasowave.lung import Line, Tree
from vasowave.lung.exchange import write_centerlines, write_stl
from vasowave.lung.lumen import Surface
from vasowave.lung.read import write_volume
from vasowave.study.datasets import write_lab_files

SMALL = vw.Network(("MPA", "LPA", "RPA"), [-1, 0, 0], [0.41, 0.40, 0.37], [0.047, 0.032, 0.037])
SCAN = "0.91,1.2,0.05"  # x, y, z of its root, cm, as the page on extraction has it


def write_files(folder: Path, law: str) -> None:
    """Write the files that the pages' command lines and programs name; `law` is the program of a wall law."""
    write_lab_files(folder / "lab")
    for table in (folder / "lab").glob("*.csv"):
        vw.write_network(SMALL, table)
    for third in (folder / "lab").glob("*/mouse 3.txt"):
        third.unlink()
    vw.write_network(SMALL, folder / "lung.csv")
    shutil.copytree(folder / "lab", folder / "lab-files")
    (folder / "files").mkdir()
    (folder / "files" / "mouse 4.txt").write_text(exported(recorded(3, 20.0)), encoding="utf-8")
    raw = folder / "lab" / "control" / "mouse 1.txt"
    for name in ("recording.txt", "labchart.txt"):
        shutil.copy(raw, folder / name)
    cycle = vw.read_raw_recording(raw).average().recording.resampled(64)
    for name in ("cycle.csv", "recording.csv"):
        cycle.to_dataframe().to_csv(folder / name)
    for name, values in (("pressure", cycle.pressure), ("flow", cycle.flow)):
        np.savetxt(folder / f"{name}.dat", values)
    (folder / "ctl-1.csv").write_text(table_text(vw.read_raw_recording(raw)), encoding="utf-8")
    for name in ("network.csv", "ctl.csv", "control/network.csv", "hypertensive/network.csv"):
        (folder / name).parent.mkdir(exist_ok=True)
        vw.write_network(SMALL, folder / name)
    lengths = {"dim_mat": np.array([[1, 114.0, 13.0], [2, 111.0, 9.0], [3, 103.0, 10.0]])}  # voxels
    savemat(folder / "tree.mat", lengths | {"ves_conn": np.array([[1, 2, 3]], dtype=np.uint8)})
    (folder / "our_laws.py").write_text(law, encoding="utf-8")
    numbers = ["quantity,value,unit", "mean,38,mmHg", "wedge,11,mmHg", "cardiac output,4.6,l/min"]
    (folder / "numbers.csv").write_text("\n".join(numbers) + "\n", encoding="utf-8")
    _write_loops(folder)


def _write_loops(folder: Path) -> None:
    """Write pressure and volume of a ventricle, in one file and in two."""
    (made,) = made_ventricles(np.random.default_rng(4), ("cosine",), ("mouse",))
    table = np.c_[made.time, made.pressure, 1000 * made.volume]
    titles = ["time [s]", "LVP [mmHg]", "LVV [ul]"]
    for name, columns in (("occlusion", [0, 1, 2]), ("pressure", [0, 1]), ("volume", [0, 2])):
        header = ",".join(titles[column] for column in columns)
        np.savetxt(folder / f"{name}.csv", table[:, columns], "%.6g", ",", header=header, comments="")


def write_scan(folder: Path) -> None:
    """Write an image whose cannula ends where the page on extraction has it, and the axes in it as lines."""
    rng = np.random.default_rng(5)
    tree = embed(SMALL, rng)
    shift = np.array(SCAN.split(","), float)[::-1] - tree.cannula[0]
    image = render(tree, 110, 0.0105, rng, noise=6.0)
    image = replace(image, origin=image.origin + shift)
    write_volume(image, folder / "scan.nrrd")
    for name in ("scan", "scan-folder"):
        (folder / name).mkdir()
        write_dicom_series(image, folder / name)
    axes = (Line(one + shift, np.full(len(one), radius)) for one, radius in zip(tree.lines, SMALL.radius, strict=True))
    write_centerlines(Tree(tuple(axes), np.array(SMALL.parent)), folder / "lung.vtp", unit=0.1)
    points, triangles, *_ = marching_cubes(np.array(image.grey), 45.0)
    write_stl(Surface(points * image.spacing + image.origin, triangles), folder / "lung.stl")
