"""The practice of the paper's own program, as values, to reproduce its tables (`docs/deviations.md`)."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.base.units import MMHG
from vasowave.pulse.cycle.cycle import Recording, resample
from vasowave.pulse.model.blood import Blood, BoundaryLayer
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.network.network import Network

_LINES = 1024  # of a file that the program compares, at most


class Practice(NamedTuple):
    """How a group of authors computes: its numerics, its blood, the lengths that its grid allows, and its samples."""

    numerics: Numerics
    blood: Blood

    def network(self, network: Network) -> Network:
        """Return the network with straight vessels rounded down to whole cells, one at least, and radii as at rest."""
        cell = self.numerics.cell_size
        assert cell is not None
        cell_count = np.maximum(1.0, np.floor(np.round(network.length / cell, 6)))
        return replace(network, length=cell_count * cell, pressure=0.0, taper=None, taper_sd=None)

    def recording(self, recording: Recording) -> Recording:
        """Return the recording with samples where that program takes them to be.

        Its files hold N lines from 0 to T, of which the last repeats the first; of its N samples the k-th (from 0)
        stands at (k + 1) T/N and is compared with line k.
        """
        lines = min(len(recording.pressure) + 1, _LINES)
        pressure = np.append(recording.pressure, recording.pressure[0])
        if lines <= len(recording.pressure):
            pressure = resample(recording.pressure, lines - 1)
            pressure = np.append(pressure, pressure[0])
        shifted, flow = np.roll(pressure, 1), resample(recording.flow, lines)
        return replace(recording, pressure=shifted, flow=flow, flow_delay_sd=0.0)  # of which that program knows nothing


PAPER = Practice(
    Numerics(cycles_from_rest=8, cell_size=0.025),
    Blood(1.055 * MMHG / 1332.22, 0.049 / 1.055, BoundaryLayer(reference_radius=0.07)),
)
"""Eight cycles from rest, cells of 0.025 cm, friction as at 0.07 cm everywhere, and that program's constants."""
