"""Phantom to network: topology, lengths and radii over random embeddings; time and memory.

Usage: python benchmarks/imaging.py accuracy [voxels per edge, 256] [embeddings, 40] [first seed, 5000] [6/45 12/45 …]
       python benchmarks/imaging.py cost [voxels per edge, 256]
The last arguments are noise/threshold, grey levels. Ctrl-C ends `accuracy` early with the table of what was run; it
uses two processes. Embeddings that do not fit into the volume are passed over.
Constants were chosen on seeds 2000-2007, 1000-1019, 3000-3018 (256³), 2000-2003, 3100, 3101, 4000-4013 (497³).
"""

import resource
import sys
import tempfile
import time
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import pairwise

import numpy as np

from phantom import PE90_RADIUS, embed, render, write_dicom_series
from vasowave.base import VasowaveError, VasowaveWarning
from vasowave.base.io import apart
from vasowave.lung import Options, extract, free_length, match
from vasowave.lung.axes import tree_of
from vasowave.lung.lumen import segment
from vasowave.lung.measure import RELIABLE, cannula_radius, densitometry, network_of, without_cannula
from vasowave.lung.read import Volume
from vasowave.pulse.examples import control_network, hypertensive_network

EDGE = 2.2
"""Edge of the volume, cm."""
SETTINGS = ((6, 45), (12, 45), (6, 35), (6, 65))
"""Noise and threshold, grey levels; contrast 88."""
SPARE = 10
"""So many more seeds are tried for embeddings that fit into the volume."""


def phantoms(network, seed, voxels, settings):
    """Return the embedding and, for each noise level, its volume; all share the noise's pattern."""
    rng = np.random.default_rng(seed)
    embedding = embed(network, rng)
    clean = render(embedding, voxels, EDGE / voxels, rng, noise=0)
    grain = render_noise(voxels, rng)
    levels = sorted({noise for noise, _ in settings})
    return embedding, {n: Volume(clean.grey + np.float32(n) * grain, clean.spacing, clean.origin) for n in levels}


def render_noise(voxels, rng):
    from scipy.ndimage import gaussian_filter

    grain = gaussian_filter(rng.standard_normal((voxels,) * 3, dtype=np.float32), 0.7)
    return grain / grain.std()


def measure(network, embedding, volume, lumen, guided):
    """Return errors as a dict, or None where the topology is wrong."""
    outlets = np.array([embedding.lines[t][-1] for t in network.terminals]) if guided else None
    tree, cannula = without_cannula(tree_of(lumen, embedding.cannula[0], outlets).tree, volume)
    found = network_of(tree)
    pairs = match(network, found)
    if not len(found) == len(network) == len(pairs):
        return None
    order = [pairs[row] for row in range(len(network))]
    dense = densitometry(tree, volume, found.radius).radius
    free = (free_length(tree) >= RELIABLE * found.radius)[order]
    change = found.length[order] - network.length
    return {
        "length": change / network.length,
        "length missed": (np.abs(change) > 0.05 * network.length) & (np.abs(change) > 0.006),
        "inscribed": (found.radius[order] / network.radius - 1)[free],
        "densitometric": (dense[order] / network.radius - 1)[free & np.isfinite(dense[order])],
        "scale": np.array([cannula_radius(cannula, volume) / PE90_RADIUS - 1]),
    }


def accuracy(voxels, count, first, settings):
    results = {(mode, *setting): [] for mode in ("automatic", "guided") for setting in settings}
    done = 0
    with ProcessPoolExecutor(2) as pool:
        jobs = [pool.submit(one_embedding, seed, voxels, settings) for seed in range(first, first + count + SPARE)]
        try:
            for job in as_completed(jobs):
                seed, runs = job.result()
                done += bool(runs)
                print(f"seed {seed}: {done} of {count}", file=sys.stderr, flush=True)
                for case, (found, reason) in runs.items():
                    results[case].append(found)
                    if found is None:
                        print(f"  seed {seed}, {case[0]}, noise {case[1]}, threshold {case[2]}: {reason}", flush=True)
                if done >= count:
                    break
        except KeyboardInterrupt:
            print("stopped early", flush=True)
        pool.shutdown(wait=True, cancel_futures=True)
    print(f"{voxels}³, {done} embeddings from seed {first} on; errors in percent, median / 95th percentile / worst;")
    print("radii where 2 radii of length are free")
    print("| mode | noise | threshold | right | length | 5 % and 0.06 mm missed | inscribed | densitometric | scale |")
    print("|---|---|---|---|---|---|---|---|---|")
    for (mode, noise, threshold), runs in results.items():
        good = [run for run in runs if run is not None]
        columns = [spread(good, key) for key in ("length", "inscribed", "densitometric", "scale")]
        missed = f"{100 * np.concatenate([run['length missed'] for run in good]).mean():.1f} %" if good else "-"
        columns.insert(1, missed)
        print(f"| {mode} | {noise} | {threshold} | {len(good)} of {len(runs)} | " + " | ".join(columns) + " |")


def one_embedding(seed, voxels, settings):
    """Return the seed and, for every mode and setting, the errors or None, and why; nothing where it does not fit."""
    warnings.simplefilter("ignore", VasowaveWarning)
    network = (control_network(), hypertensive_network())[seed % 2]
    try:
        embedding, volumes = phantoms(network, seed, voxels, settings)
    except VasowaveError as error:
        print(f"  seed {seed}: {error}", flush=True)
        return seed, {}
    runs = {}
    for noise, threshold in settings:
        lumen = segment(volumes[noise], threshold, embedding.cannula[0])
        for mode in ("automatic", "guided"):
            try:
                found = measure(network, embedding, volumes[noise], lumen, mode == "guided")
                runs[mode, noise, threshold] = found, "another topology"
            except VasowaveError as error:
                runs[mode, noise, threshold] = None, str(error)
    return seed, runs


def spread(runs, key):
    values = 100 * np.abs(np.concatenate([run[key] for run in runs])) if runs else np.array([])
    return " / ".join(f"{value:.1f}" for value in np.quantile(values, (0.5, 0.95, 1))) if len(values) else "-"


def cost(voxels):
    """Print CPU seconds of every stage and the peak memory, from a DICOM series on disk to the network."""
    embedding = embed(control_network(), np.random.default_rng(0))
    with tempfile.TemporaryDirectory() as folder:
        begin = time.process_time()
        volume = render(embedding, voxels, EDGE / voxels, np.random.default_rng(1))
        print(f"phantom rendered in {time.process_time() - begin:.1f} CPU-s")
        write_dicom_series(volume, folder)
        del volume
        rendering = _peak()
        marks = [("start", seconds())]
        found = extract(folder, Options(embedding.cannula[0]), lambda stage: marks.append((stage, seconds())))
    marks.append(("end", seconds()))
    for (stage, since), (_, until) in pairwise(marks[1:]):
        print(f"{stage:12} {until - since:5.1f} CPU-s")
    print(
        f"total {marks[-1][1] - marks[0][1]:.1f} CPU-s, {len(found.network)} vessels, peak {_peak():.2f} GB "
        f"({rendering:.2f} GB while the phantom was made)"
    )


def _peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def seconds():
    """Return the CPU seconds of this process and of the one that reads images, which counts once it has ended."""
    apart._HELPER.stop()
    return time.process_time() + sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def main():
    warnings.simplefilter("ignore", VasowaveWarning)
    settings = tuple(tuple(map(int, text.split("/"))) for text in sys.argv[2:] if "/" in text) or SETTINGS
    numbers = [int(value) for value in sys.argv[2:] if "/" not in value]
    if sys.argv[1:2] == ["cost"]:
        cost(*numbers or [256])
    elif sys.argv[1:2] == ["accuracy"]:
        voxels, count, first = [*numbers, *(256, 40, 5000)[len(numbers) :]]
        accuracy(voxels, count, first, settings)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
