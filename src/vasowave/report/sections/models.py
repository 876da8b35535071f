"""What the calibrated models say: waveforms, walls, parameters, starts, waves, impedance, residuals, selection."""

from collections.abc import Mapping

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.table import column
from vasowave.figures import modeled as figures
from vasowave.figures.compared import boxes_figure
from vasowave.figures.style import group_looks
from vasowave.report.blocks import Block, Drawing, Fold, Section, Table
from vasowave.report.sections.discrepancy import discrepancy_blocks
from vasowave.report.sections.space import space_block
from vasowave.report.tables import models as tables
from vasowave.report.tables.selection import misfit_table, preference_table, selection_table
from vasowave.report.wording import column_label

_BEDS = ("R_T", "C_T", "C_p_over_C_T", "tau", "a")
_SOURCES = "Sources differ by their hatch and stand below their boxes."


def model_section(cohort: Cohort, law: str, written: Mapping[str, str]) -> Section:
    """What the calibrated models say."""
    blocks = [
        *space_block(cohort, law or cohort.walls[0]),
        *_waveforms(cohort),
        *(tables.parameters(cohort, wall) for wall in cohort.walls),
        tables.bounds(cohort),
        *_boxes(cohort, written),
        Drawing("Waterfall", "S of every start over the best S of its animal, in rising order: a flat line is a "
                "calibration whose starts agree.", figures.waterfall_figure(cohort)),
        tables.starts(cohort),
        *_waves(cohort, written),
        Drawing("Impd", f"Impedance modulus and phase (eq. 19) at harmonics 0 to {_harmonics(cohort)}{_whose(cohort)}; "
                "grey circles: harmonics whose flow is near the noise.", figures.impedance_figure(cohort)),
        Drawing("Residuals", "Measured minus simulated pressure and its autocorrelation; inside the grey band an "
                "autocorrelation cannot be told from that of independent noise.", figures.residuals_figure(cohort)),
        misfit_table(cohort),
        *discrepancy_blocks(cohort),
        *_selection(cohort, law),
    ]  # fmt: skip
    return Section("models", "Calibrated model" if cohort.single else "Calibrated models", blocks)


def labelled(cohort: Cohort, names: tuple[str, ...], written: Mapping[str, str]) -> dict[str, str]:
    """Return the columns of those quantities that a model has, and what their axes are called."""
    modeled = cohort.table[cohort.table["source"].isin(cohort.walls)]
    labels = {}
    for name in dict.fromkeys(names):
        label = column(modeled, name)
        if label and modeled[label].notna().any():
            unit = column_label(label).partition(" [")[2] or "1]"
            labels[label] = f"{written.get(name, name)} [{unit}"
    return labels


def _waveforms(cohort: Cohort) -> list[Block]:
    looks = group_looks(cohort.groups)
    return [
        *(Drawing(f"PQsim-{place}", f"Pressure and flow at the middle of chosen vessels of {cohort.name(group)}; in "
                  "brackets the vessel's share of the mean flow.", figures.vessels_figure(result, looks[group].color))
          for place, (group, result) in enumerate(cohort.shown.items(), start=1)),
        Drawing("PAsim", "Pressure against area at the middle of the root vessel over one cycle (thick), and the wall "
                "law from zero pressure on (thin, if the results hold it).", figures.pressure_area_figure(cohort)),
        Drawing("Tree", "Wave speed at mean pressure in every vessel (eqs. 31, 32), and fall of the mean pressure "
                "from the inlet to the end of every terminal vessel.", figures.along_network_figure(cohort)),
    ]  # fmt: skip


def _boxes(cohort: Cohort, written: Mapping[str, str]) -> list[Block]:
    if cohort.single:
        return []
    laws = [cohort.law(wall) for wall in cohort.walls]
    own = (name for law in laws for name in law.parameters)
    names = (*own, *_BEDS, *(law.stiffness for law in laws), "wave_speed", "I_R", "S")
    caption = (
        "Optimized parameters and what follows from them, and the least-squares error S of \"PQsim\" (eq. 14). Box: "
        "quartiles and median; cross: mean; whiskers: to the last animal within 1.5 times the interquartile range; a "
        f"point for every animal. {_SOURCES}"
    )  # fmt: skip
    return [Drawing("ParOpt", caption, boxes_figure(cohort, labelled(cohort, names, written), cohort.walls))]


def _waves(cohort: Cohort, written: Mapping[str, str]) -> list[Block]:
    blocks: list[Block] = [
        Drawing(f"WIA-{place}", f"Forward and backward pressure (eq. 15, left) and time-normalized wave intensity "
                f"(eq. 16, right) at the inlet of {cohort.name(group)}: measured and with each wall law. F forward, B "
                "backward, C compression, D decompression wave.", figures.waves_figure(cohort, group))
        for place, group in enumerate(cohort.shown, start=1)
    ]  # fmt: skip
    if not cohort.single:
        boxes = boxes_figure(cohort, labelled(cohort, ("I_R",), written), cohort.sources)
        blocks.append(Drawing("WIA-I_R", f"Reflection coefficient I_R (eq. 17). {_SOURCES}", boxes))
    return [*blocks, tables.waves(cohort)]


def _selection(cohort: Cohort, law: str) -> list[Block]:
    if not cohort.compared:
        return []
    table: Table = selection_table(cohort)
    if cohort.single:
        return [table]
    return [preference_table(cohort, law), Fold("Model selection, animal by animal", [table])]


def _harmonics(cohort: Cohort) -> int:
    return max(int(result.measured.impedance["harmonic"].max()) for result in cohort.results)


def _whose(cohort: Cohort) -> str:
    return "" if cohort.single else " of the shown animals"
