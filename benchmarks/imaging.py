"""Phantom to network: topology, lengths and radii over random embeddings; time and memory.

Usage: python benchmarks/imaging.py [voxels per edge] [embeddings] [first seed, 1000];
constants were looked at on seeds 100-103 only (256³).
"""

import resource
import sys
import time
import warnings

import numpy as np

from vasowave.datasets import control_network, hypertensive_network
from vasowave.datasets.phantom import embed, render
from vasowave.errors import VasowaveError, VasowaveWarning
from vasowave.imaging.cannula import cannula_radius, without_cannula
from vasowave.imaging.extraction import tree_of
from vasowave.imaging.matching import match
from vasowave.imaging.radii import densitometric_radii, lumen_grey
from vasowave.imaging.segmentation import segment
from vasowave.imaging.tree import network_of


def one(network, seed, voxels, noise, threshold, guided):
    """Return (topology right, scale error, relative errors of length, inscribed and densitometric radius, seconds)."""
    rng = np.random.default_rng(seed)
    embedding = embed(network, rng)
    spacing = 2.2 / voxels
    volume = render(embedding, voxels, spacing, rng, noise=noise)
    begin = time.process_time()
    outlets = np.array([embedding.lines[t][-1] for t in network.terminals]) if guided else None
    lumen = segment(volume, threshold, embedding.cannula[0] + [2 * spacing, 0, 0])
    tree, cannula = without_cannula(tree_of(lumen, embedding.cannula[0], outlets))
    measured = cannula_radius(cannula, volume, lumen_grey(tree, volume))
    found = network_of(tree)
    dense = densitometric_radii(tree, volume, found.radius)
    seconds = time.process_time() - begin
    pairs = match(network, found)
    if len(found) != len(network) or len(pairs) != len(network):
        return False, np.nan, None, None, None, seconds
    order = [pairs[row] for row in range(len(network))]
    return (
        True,
        measured / 0.043 - 1,
        found.length[order] / network.length - 1,
        found.radius[order] / network.radius - 1,
        dense[order] / network.radius - 1,
        seconds,
    )


def spread(errors):
    """Return median and largest absolute error in percent, as text."""
    values = 100 * np.abs(np.concatenate(errors)) if errors else np.array([np.nan])
    values = values[np.isfinite(values)]
    return f"{np.median(values):5.1f} / {values.max():5.1f}" if len(values) else "    -"


def main():
    voxels = int(sys.argv[1]) if len(sys.argv) > 1 else 256
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    begin = int(sys.argv[3]) if len(sys.argv) > 3 else 1000
    warnings.simplefilter("ignore", VasowaveWarning)
    print(
        "mode noise threshold | topology | length % med/max | inscribed % | densitometric % | scale % | CPU s",
        flush=True,
    )
    for noise, threshold in ((6, 45), (12, 45), (6, 36), (6, 54)):
        for guided in (False, True):
            rows, failed = [], []
            for index in range(count):
                network = (control_network(), hypertensive_network())[index % 2]
                try:
                    rows.append(one(network, begin + index, voxels, noise, threshold, guided))
                except VasowaveError as error:
                    failed.append(f"seed {begin + index}: {error}")
            good = [row for row in rows if row[0]]
            columns = " | ".join(spread([row[k] for row in good]) for k in (2, 3, 4))
            scale = 100 * np.max(np.abs([row[1] for row in good])) if good else np.nan
            seconds = np.mean([row[5] for row in rows]) if rows else np.nan
            mode = "guided   " if guided else "automatic"
            print(
                f"{mode} {noise:3} {threshold} | {len(good)}/{count} | {columns} | {scale:.1f} | {seconds:.1f}",
                flush=True,
            )
            for line in failed:
                print("   ", line, flush=True)
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GB")


if __name__ == "__main__":
    main()
