"""Write a synthetic micro-CT of five vessels and a cannula: `python make_scan.py scan.nrrd`."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
from phantom import embed, render
from vasowave.lung.read import write_volume
from vasowave.pulse.network import Network

tree = Network(
    ("trunk", "left", "right", "left a", "left b"),
    np.array([-1, 0, 0, 1, 1]),
    np.array([0.35, 0.40, 0.30, 0.25, 0.30]),  # cm
    np.array([0.052, 0.042, 0.032, 0.034, 0.026]),  # cm
)
rng = np.random.default_rng(5)
embedding = embed(tree, rng)
write_volume(render(embedding, 140, 0.0095, rng, noise=6.0), sys.argv[1])
