"""Recordings as labs write them: continuous, of virtual mice, with titles, gaps and drifts of all kinds."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from vasowave.catheter import SYNTHETIC_NOTICE, Disturbances, labchart_text, synthetic_raw_recording
from vasowave.catheter.signals import RawRecording
from vasowave.pulse.cycle import Recording
from vasowave.pulse.examples import virtual_mouse
from vasowave.pulse.network import Network, write_network

SMALL = Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])


def recorded(seed: int, mean: float, drift: float = 0.0, duration: float = 9.0) -> RawRecording:
    """Return a continuous recording whose pressure has this mean at the start, mmHg, and drifts by `drift` in all."""
    mouse = virtual_mouse(seed=seed)
    cycle = Recording(mouse.pressure + mean - mouse.pressure.mean(), mouse.flow, mouse.period)
    return synthetic_raw_recording(
        cycle, np.random.default_rng(seed), duration=duration, sampling_rate=1000.0,
        disturbances=Disturbances(pressure_drift=0.0), baseline=lambda t: drift * t / duration,
    ).raw  # fmt: skip


def exported(
    raw: RawRecording, titles: str = "Pressure 1\tFlow PA\tLead II", gap: tuple[float, float] | None = None
) -> str:
    """Return LabChart's text of a recording under other titles; the pressure is missing in a gap, s."""
    text = labchart_text(raw).replace("PAP\tFlow\tECG", titles).replace(SYNTHETIC_NOTICE, "start")
    if gap is None:
        return text
    lines = text.split("\n")
    head = next(i for i, line in enumerate(lines) if line[:1].isdigit())
    for i in range(head + round(gap[0] * raw.sampling_rate), head + round(gap[1] * raw.sampling_rate)):
        time, _, rest = lines[i].split("\t", 2)
        lines[i] = f"{time}\tNaN\t{rest}"
    return "\n".join(lines)


def write_lab(folder: Path, write: Callable[[Path, str, int, float], None], animals: dict[str, float]) -> Path:
    """Write a network and a recording for every animal, whose mean pressures are given; returns the folder."""
    folder.mkdir(parents=True)
    write_network(SMALL, folder / "lung.csv")
    for seed, (name, mean) in enumerate(animals.items()):
        write(folder, name, seed, mean)
    return folder
