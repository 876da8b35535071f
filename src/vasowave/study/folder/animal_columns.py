"""The columns of the table of animals: what each holds, of which recordings, and what it decides."""

import math
from dataclasses import dataclass
from typing import Literal

from vasowave.base.cures import field_of
from vasowave.base.sites import PULMONARY
from vasowave.base.sites import SITES as ARTERIES
from vasowave.catheter.read.site_files import COLUMNS as SITES
from vasowave.pulse.inference.known_errors import SHARED_SOURCES, columns

ERRORS = {title: name for name, (title, _) in columns().items()}
"""Columns of errors that the lab knows, and the settings that they stand for."""

WEDGE = "wedge [mmHg]"

_SMALLEST = math.ulp(0.0)  # above 0


@dataclass(frozen=True)
class Column:
    """A column of the table of animals; its title tells whether it holds a number, by its unit.

    Attributes
    ----------
    meaning : str
        What it holds.
    is_file : bool
        Whether it holds the name of a file.
    scope : {"", "raw", "cycle", "loops", "animal"}
        What it tells of, where that is not every recording: one kind of recordings, or what lies beside it.
    minimum : float
        The smallest number; by default positive ones only.
    enters_key : {"always", "where given", "never"}
        Whether it decides if a stored result still holds; files do by their content.
    is_option : bool
        Whether commands that read one recording take it as an option.
    is_covariate : bool
        Whether groups may be adjusted for it, as for a column of the lab.
    """

    meaning: str
    is_file: bool = False
    scope: Literal["", "raw", "cycle", "loops", "animal"] = ""
    minimum: float = _SMALLEST
    enters_key: Literal["always", "where given", "never"] = "always"
    is_option: bool = True
    is_covariate: bool = False


COLUMNS = {
    "animal": Column("Name of the animal, each once.", is_option=False),
    "group": Column("One of the groups of study.yaml.", is_option=False),
    "network": Column(
        "File of its vessels: name, parent, length [cm], radius [cm]. Animals may share one.",
        is_file=True,
        is_option=False,
    ),
    "image pressure [mmHg]": Column(
        "Pressure at which its vessels were imaged, where the network's file does not say it.", is_option=False
    ),
    "recording": Column(
        "File of its recording: one averaged cycle, or a continuous recording.", is_file=True, is_option=False
    ),
    "flow": Column(
        "File of the flow, if the recording holds the pressure only; continuous ones are joined on their clocks.",
        is_file=True,
        is_option=False,
    ),
    "kind": Column(
        "cycle (one averaged cycle) or raw (continuous, beats are found and averaged); empty: told from the file.",
        is_option=False,
    ),
    "period [s]": Column(
        "Period of a cycle without times; beside times it tells whether the last sample is the next one's.",
        scope="cycle",
    ),
    WEDGE: Column(
        "Wedge pressure, or that of the left atrium: what lies behind the vascular beds; empty: 0.", minimum=0.0
    ),
    "wedge wave": Column(
        "Table of that pressure over one cycle in step with the recording; its mean is the wedge pressure where "
        "none is given.",
        is_file=True,
    ),
    "pressure unit": Column("Unit of the pressure, where its file names none or a wrong one.", is_option=False),
    "flow unit": Column("Unit of the flow, where its file names none or a wrong one.", is_option=False),
    "pressure channel": Column(
        "raw: title of the pressure channel, where the titles do not tell.", scope="raw", is_option=False
    ),
    "flow channel": Column("raw: title of the flow channel.", scope="raw", is_option=False),
    "ecg channel": Column("raw: title of the ECG channel.", scope="raw", is_option=False),
    "flow diameter [mm]": Column(
        "Diameter of the vessel where a velocity (Doppler) was recorded in place of the flow: the flow is "
        "velocity times area, and `flow gain [1]` the share of the mean in a velocity that is a peak.",
        enters_key="where given",
    ),
    "sheet": Column(
        "Of a workbook the sheet to read; by default the first that holds pressure and flow.", enters_key="where given"
    ),
    "subject row": Column(
        "Of a table of several subjects, a row or columns of each: which of them is read, by its name.",
        scope="cycle",
        enters_key="where given",
    ),
    "site": Column(
        f"Artery that was recorded, where it is not that of study.yaml: {', '.join((PULMONARY, *ARTERIES))}.",
        enters_key="where given",
        is_option=False,
    ),
    "block": Column("raw: block of a LabChart file, counted from 1; the longest by default.", scope="raw"),
    "start [s]": Column("raw: start of the stretch to use, since the start of the block.", scope="raw", minimum=0.0),
    "end [s]": Column("raw: end of the stretch to use.", scope="raw"),
    "beat edits": Column(
        "raw: file of what a person decided of single beats: reject, keep, move (action, time [s], to [s]).",
        is_file=True,
        scope="raw",
    ),
    "sites": Column(
        f"Table of what was observed at further places, one row a place, with the columns {', '.join(SITES)}.",
        is_file=True,
        scope="animal",
    ),
    "ventricle": Column(
        "Table of the pressure in the ventricle that ejects into the network, with its time: one cycle or several "
        "beats, not in step with the recording. Gives its elastance beside the artery's.",
        is_file=True,
        scope="animal",
    ),
    "loops": Column(
        "Recording of pressure and volume of a ventricle, some seconds of beats, best with a fall of the preload; "
        "gives E_es, E_a, preload-recruitable work and others (`vasowave loops`).",
        is_file=True,
        scope="animal",
    ),
    "volume channel": Column(
        "loops: title of the volume's channel, where the titles do not tell.",
        scope="loops",
        enters_key="where given",
        is_option=False,
    ),
    "volume unit": Column(
        "loops: unit of the volume, where its file names none or a wrong one.",
        scope="loops",
        enters_key="where given",
        is_option=False,
    ),
    "volume delay [s]": Column(
        "loops: by how much the volume was recorded later than the pressure; negative: earlier.",
        scope="loops",
        minimum=-math.inf,
        enters_key="where given",
    ),
    "zero [mmHg]": Column(
        "What the transducer reads at zero pressure, where it is not 0; it is subtracted.", minimum=-math.inf
    ),
    "zero after [mmHg]": Column(
        "What it reads at zero pressure after the recording: the mean of both is subtracted, and the zero's SD is "
        "that of a drift between them, where no other is said.",
        minimum=-math.inf,
    ),
    "pressure gain [1]": Column(
        "By what the pressure above the zero is multiplied, where a second point of calibration says that the "
        "transducer reads too much or too little."
    ),
    "flow zero [ml/s]": Column("What the probe reads where nothing flows; it is subtracted.", minimum=-math.inf),
    "flow gain [1]": Column(
        "By what the flow is multiplied, likewise; -1 turns that of a probe mounted backward.", minimum=-math.inf
    ),
    "pressure cutoff [Hz]": Column(
        "Cut-off frequency of the amplifier's filter, of first order, which is taken out of the pressure again; "
        "empty: none."
    ),
    "pressure damping [1]": Column(
        "Damping ratio where the response is of second order, with the cut-off as its natural frequency: of a "
        "catheter (in place of the study's `catheter`), or 0.71 of a Butterworth filter."
    ),
    "flow cutoff [Hz]": Column("Likewise of the flow meter's."),
    "flow damping [1]": Column("Likewise of the flow meter's."),
    "pressure delay [s]": Column(
        "By how much the pressure was recorded too late; negative: too early.", minimum=-math.inf
    ),
    "flow delay [s]": Column("Likewise of the flow.", minimum=-math.inf),
    "hematocrit [1]": Column(
        "Share of cells in the blood, 0.2 to 0.8: the viscosity of study.yaml is that at 0.45.",
        scope="animal",
        enters_key="never",
        is_covariate=True,
    ),
    "temperature [°C]": Column(
        "Of the blood while it was recorded, 20 to 45: the viscosity of study.yaml is that at 37.",
        scope="animal",
        enters_key="never",
        is_covariate=True,
    ),
    "sampling rate [1/s]": Column("raw: samples per second of a table without a time column.", scope="raw"),
    "synthetic": Column("yes if the recording was made and not measured; the report then says so.", is_option=False),
    "shared recording": Column(
        "yes if another animal has the same recording on purpose; else that is an error.",
        enters_key="never",
        is_option=False,
    ),
    "R_T [mmHg s/ml]": Column(
        "Total resistance known from elsewhere (a published table): `check` compares, `run` ignores it.",
        enters_key="never",
        is_option=False,
    ),
    "C_T [ml/mmHg]": Column("Total compliance known from elsewhere, likewise.", enters_key="never", is_option=False),
    "tau [s]": Column("Time constant known from elsewhere, likewise.", enters_key="never", is_option=False),
    **{
        title: Column(meaning, minimum=0.0, enters_key="never", is_option=False)
        for title, meaning in columns().values()
    },
    **{
        title: Column(meaning, enters_key="never", is_option=False, is_covariate=True)
        for title, meaning in SHARED_SOURCES.items()
    },
}
"""Columns of animals.csv."""

REQUIRED_COLUMNS = ("animal", "group", "network", "recording")

FILES = tuple(title for title, column in COLUMNS.items() if column.is_file)
"""Columns that hold names of files."""

NUMBERS = {title: field_of(title) for title in COLUMNS if title.endswith("]") or title in ("block", *ERRORS)}
"""Columns of numbers, and the names of what they say."""
