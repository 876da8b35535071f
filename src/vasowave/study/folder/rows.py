"""One animal as its row in the table says it: group, files, and what the files do not tell."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from vasowave.base.cures import field_of
from vasowave.base.sites import PULMONARY
from vasowave.base.sites import SITES as ARTERIES
from vasowave.catheter.read.formats import companion_files
from vasowave.catheter.read.site_files import COLUMNS as SITES
from vasowave.catheter.read.site_files import site_files
from vasowave.pulse.inference.known_errors import SHARED_SOURCES, columns

ERRORS = {title: name for name, (title, _) in columns().items()}
"""Columns of errors that the lab knows, and the settings that they stand for."""

FILES = ("network", "recording", "flow", "beat edits", "sites", "ventricle", "loops", "wedge wave")
"""Columns that hold names of files."""

WEDGE = "wedge [mmHg]"

COLUMNS = {
    "animal": "Name of the animal, each once.",
    "group": "One of the groups of study.yaml.",
    "network": "File of its vessels: name, parent, length [cm], radius [cm]. Animals may share one.",
    "image pressure [mmHg]": "Pressure at which its vessels were imaged, where the network's file does not say it.",
    "recording": "File of its recording: one averaged cycle, or a continuous recording.",
    "flow": "File of the flow, if the recording holds the pressure only; continuous ones are joined on their clocks.",
    "kind": "cycle (one averaged cycle) or raw (continuous, beats are found and averaged); empty: told from the file.",
    "period [s]": "Period of a cycle without times; beside times it tells whether the last sample is the next one's.",
    WEDGE: "Wedge pressure, or that of the left atrium: what lies behind the vascular beds; empty: 0.",
    "wedge wave": "Table of that pressure over one cycle in step with the recording; its mean is the wedge pressure "
    "where none is given.",
    "pressure unit": "Unit of the pressure, where its file names none or a wrong one.",
    "flow unit": "Unit of the flow, where its file names none or a wrong one.",
    "pressure channel": "raw: title of the pressure channel, where the titles do not tell.",
    "flow channel": "raw: title of the flow channel.",
    "ecg channel": "raw: title of the ECG channel.",
    "flow diameter [mm]": "Diameter of the vessel where a velocity (Doppler) was recorded in place of the flow: the "
    "flow is velocity times area, and `flow gain [1]` the share of the mean in a velocity that is a peak.",
    "sheet": "Of a workbook the sheet to read; by default the first that holds pressure and flow.",
    "subject row": "Of a table of several subjects, a row or columns of each: which of them is read, by its name.",
    "site": f"Artery that was recorded, where it is not that of study.yaml: {', '.join((PULMONARY, *ARTERIES))}.",
    "block": "raw: block of a LabChart file, counted from 1; the longest by default.",
    "start [s]": "raw: start of the stretch to use, since the start of the block.",
    "end [s]": "raw: end of the stretch to use.",
    "beat edits": "raw: file of what a person decided of single beats: reject, keep, move (action, time [s], to [s]).",
    "sites": f"Table of what was observed at further places, one row a place, with the columns {', '.join(SITES)}.",
    "ventricle": "Table of the pressure in the ventricle that ejects into the network, with its time: one cycle or "
    "several beats, not in step with the recording. Gives its elastance beside the artery's.",
    "loops": "Recording of pressure and volume of a ventricle, some seconds of beats, best with a fall of the preload; "
    "gives E_es, E_a, preload-recruitable work and others (`vasowave loops`).",
    "volume channel": "loops: title of the volume's channel, where the titles do not tell.",
    "volume unit": "loops: unit of the volume, where its file names none or a wrong one.",
    "volume delay [s]": "loops: by how much the volume was recorded later than the pressure; negative: earlier.",
    "zero [mmHg]": "What the transducer reads at zero pressure, where it is not 0; it is subtracted.",
    "zero after [mmHg]": "What it reads at zero pressure after the recording: the mean of both is subtracted, and the "
    "zero's SD is that of a drift between them, where no other is said.",
    "pressure gain [1]": "By what the pressure above the zero is multiplied, where a second point of calibration says "
    "that the transducer reads too much or too little.",
    "flow zero [ml/s]": "What the probe reads where nothing flows; it is subtracted.",
    "flow gain [1]": "By what the flow is multiplied, likewise; -1 turns that of a probe mounted backward.",
    "pressure cutoff [Hz]": "Cut-off frequency of the amplifier's filter, of first order, which is taken out of the "
    "pressure again; empty: none.",
    "pressure damping [1]": "Damping ratio where the response is of second order, with the cut-off as its natural "
    "frequency: of a catheter (in place of the study's `catheter`), or 0.71 of a Butterworth filter.",
    "flow cutoff [Hz]": "Likewise of the flow meter's.",
    "flow damping [1]": "Likewise of the flow meter's.",
    "pressure delay [s]": "By how much the pressure was recorded too late; negative: too early.",
    "flow delay [s]": "Likewise of the flow.",
    "hematocrit [1]": "Share of cells in the blood, 0.2 to 0.8: the viscosity of study.yaml is that at 0.45.",
    "temperature [°C]": "Of the blood while it was recorded, 20 to 45: the viscosity of study.yaml is that at 37.",
    "sampling rate [1/s]": "raw: samples per second of a table without a time column.",
    "synthetic": "yes if the recording was made and not measured; the report then says so.",
    "shared recording": "yes if another animal has the same recording on purpose; else that is an error.",
    "R_T [mmHg s/ml]": "Total resistance known from elsewhere (a published table): `check` compares, `run` ignores it.",
    "C_T [ml/mmHg]": "Total compliance known from elsewhere, likewise.",
    "tau [s]": "Time constant known from elsewhere, likewise.",
    **dict(columns().values()),
    **SHARED_SOURCES,
}
"""Columns of animals.csv and what they hold; the first four are needed."""

REQUIRED_COLUMNS = ("animal", "group", "network", "recording")


NUMBERS = {title: field_of(title) for title in COLUMNS if title.endswith("]") or title in ("block", *ERRORS)}
"""Columns of numbers, and the names of what they say."""


@dataclass(frozen=True)
class AnimalRow:
    """One row of the table; a number is None and a text empty where the cell is.

    An empty `kind` is told from the file, see `recording.describe`.
    """

    animal: str
    group: str
    network: Path
    recordings: tuple[Path, ...]
    line: int
    kind: Literal["", "cycle", "raw"] = ""
    period: float | None = None
    pressure_unit: str = ""
    flow_unit: str = ""
    pressure_channel: str = ""
    flow_channel: str = ""
    ecg_channel: str = ""
    flow_diameter: float | None = None
    sheet: str = ""
    subject_row: str = ""
    site: str = ""
    block: int | None = None
    start: float | None = None
    end: float | None = None
    beat_edits: Path | None = None
    sites: Path | None = None
    ventricle: Path | None = None
    loops: Path | None = None
    volume_channel: str = ""
    volume_unit: str = ""
    volume_delay: float | None = None
    wedge_wave: Path | None = None
    zero: float | None = None
    pressure_gain: float | None = None
    flow_zero: float | None = None
    flow_gain: float | None = None
    pressure_cutoff: float | None = None
    pressure_damping: float | None = None
    flow_cutoff: float | None = None
    flow_damping: float | None = None
    pressure_delay: float | None = None
    flow_delay: float | None = None
    sampling_rate: float | None = None
    image_pressure: float | None = None
    wedge: float | None = None
    synthetic: bool = False
    shared_recording: bool = False
    R_T: float | None = None
    C_T: float | None = None
    tau: float | None = None
    hematocrit: float | None = None
    temperature: float | None = None
    errors: Mapping[str, float] = field(default_factory=dict)
    """Settings of `KnownErrors` that are said of this animal."""
    lab_cells: Mapping[str, str] = field(default_factory=dict)
    """Cells of the columns that are the lab's own, by title, and of those that say what animals share."""

    @property
    def calibration(self) -> tuple[float, float, float, float]:
        """What is subtracted from the pressure that was read, mmHg, the factors of pressure and flow, and what is
        subtracted from the flow, ml/s.
        """
        pressure_gain, flow_gain = (1.0 if gain is None else gain for gain in (self.pressure_gain, self.flow_gain))
        return self.zero or 0.0, pressure_gain, flow_gain, self.flow_zero or 0.0

    @property
    def files(self) -> dict[str, Path]:
        """Every file that is read for this animal, by its role; a table of sites names waveforms."""
        files = {"network": self.network, **dict(zip(("recording", "flow"), self.recordings, strict=False))}
        recorded = (*self.recordings, *([self.loops] if self.loops else []))
        companions = [file for recording in recorded for file in companion_files(recording)]
        files |= {f"recording, file {place}": file for place, file in enumerate(companions, start=2)}
        optional_files = {"beat edits": self.beat_edits, "ventricle": self.ventricle, "loops": self.loops,
                          "wedge wave": self.wedge_wave}  # fmt: skip
        files |= {role: file for role, file in optional_files.items() if file is not None}
        waves = () if self.sites is None else (self.sites, *site_files(self.sites))
        return files | {f"site {place}" if place else "sites": file for place, file in enumerate(waves)}
