"""One animal as its row in the table says it: group, files, and what the files do not tell."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from vasowave.catheter.read.formats import companion_files
from vasowave.catheter.read.site_files import site_files
from vasowave.catheter.signals.raw import SensorCalibration


@dataclass(frozen=True)
class AnimalRow:
    """One row of the table; a number is None and a text empty where the cell is.

    An empty `kind` is told from the file, see `kind_of`.
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
    def calibration(self) -> SensorCalibration:
        """Zeros and gains of the instruments."""
        gain, flow_gain = (1.0 if factor is None else factor for factor in (self.pressure_gain, self.flow_gain))
        return SensorCalibration(self.zero or 0.0, gain, flow_gain, self.flow_zero or 0.0)

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
