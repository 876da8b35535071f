"""The sections of a cohort's report: what was measured, what the model says, the groups, every animal."""

from collections.abc import Mapping

import pandas as pd

from vasowave.animal.reading import data_of, wall_laws
from vasowave.cohort.comparison import INDICES, Comparison, column, importance
from vasowave.figures import cohort_gallery as drawing
from vasowave.figures.cohort_gallery import Cohort
from vasowave.figures.gallery import fit_figure, tree_figure
from vasowave.report.cohort import data_tables, group_tables, model_tables, words
from vasowave.report.cohort.selection_table import selection_table
from vasowave.report.document import Block, Drawing, Fold, Heading, Notice, Paragraph, Section
from vasowave.report.wording import column_label

_BOXES = ("beta", "p1", "gamma", "R_T", "C_T", "C_p_over_C_T", "tau", "a", "p1_over_gamma", "wave_speed", "I_R", "S")
_PARAMETERS = {
    "beta": "stiffness", "p1_over_gamma": "stiffness", "R_T": "R_T", "C_T": "C_T", "C_v": "C_v", "C_p": "C_p",
    "tau": "τ", "I_R": "I_R", "a": "R₁/R_T",
}  # fmt: skip


def data_section(cohort: Cohort) -> Section:
    """What was measured, and what follows from it without a model."""
    shown = "Black: the animal nearest to the medians of its group, which is shown below too."
    blocks: list[Block] = [
        Drawing("hemoData", f"Measured pressure and flow, impedance modulus |Z| and phase θ (eq. 19) of every animal. "
                f"{shown} Grey circles: harmonics whose flow is near the noise.", drawing.hemodynamics_figure(cohort)),
        data_tables.hemodynamics(cohort),
        Drawing("Network", "The networks as directed graphs, with each vessel's share of the mean flow (eq. 11); width "
                "follows the radius, lengths are not to scale.", drawing.networks_figure(cohort)),
        *data_tables.networks(cohort),
        Drawing("parEst", "Nominal parameters of the shown animals: characteristic impedance Z_c from the slope of the "
                "pressure-flow loop (eq. 8, top), time constant τ from the diastolic decay (eq. 12, bottom).",
                drawing.nominal_figure(cohort)),
        data_tables.nominal(cohort),
        data_tables.characteristic_impedances(cohort),
    ]  # fmt: skip
    return Section("data", "Measurements and nominal parameters", blocks)


def model_section(cohort: Cohort, written: Mapping[str, str]) -> Section:
    """What the calibrated models say."""
    blocks: list[Block] = []
    for place, (group, tree) in enumerate(cohort.shown.items(), start=1):
        color = cohort.looks[group].color
        blocks.append(
            Drawing(f"PQsim-{place}", f"Pressure and flow at the middle of chosen vessels of {cohort.name(group)}; in "
                    "brackets the vessel's share of the mean flow.", tree_figure(tree, color))
        )  # fmt: skip
    boxes = _box_columns(cohort, written)
    blocks += [
        Drawing("PAsim", "Pressure against area at the middle of the root vessel over one cycle (thick), and the wall "
                "law from zero pressure on (thin).", drawing.pressure_area_figure(cohort)),
        Drawing("Tree", "Wave speed at mean pressure in every vessel (eqs. 31, 32; top), and fall of the mean pressure "
                "from the inlet to the end of every terminal vessel (bottom).", drawing.along_tree_figure(cohort)),
        *(model_tables.parameters(cohort, wall) for wall in cohort.walls),
        model_tables.bounds(cohort),
        Drawing("ParOpt", "Optimized parameters and what follows from them, and the least-squares error S of \"PQsim\" "
                "(eq. 14). Box: quartiles and median; cross: mean; whiskers: to the last animal within 1.5 times the "
                "interquartile range; a point for every animal. Linear wall hatched.",
                drawing.boxes_figure(cohort, boxes, cohort.walls)),
        Drawing("Waterfall", "S of every start over the best S of its animal, in rising order: a flat line is a "
                "calibration whose starts agree.", drawing.waterfall_figure(cohort)),
        model_tables.starts(cohort),
    ]  # fmt: skip
    blocks += [
        Drawing(f"WIA-{place}", f"Forward and backward pressure (eq. 15, left) and time-normalized wave intensity "
                f"(eq. 16, right) at the inlet of {cohort.name(group)}: measured and with each wall law. F forward, B "
                "backward, C compression, D decompression wave.", drawing.waves_figure(cohort, group))
        for place, group in enumerate(cohort.shown, start=1)
    ]  # fmt: skip
    blocks += [
        Drawing("WIA-I_R", "Reflection coefficient I_R (eq. 17); linear wall hatched.",
                drawing.boxes_figure(cohort, _labelled(cohort, ("I_R",), written), ["measured", *cohort.walls])),
        model_tables.waves(cohort),
        Drawing("Impd", "Impedance modulus and phase (eq. 19) at harmonics 0 to 14 of the shown animals; grey circles: "
                "harmonics whose flow is near the noise.", drawing.impedance_figure(cohort)),
        Drawing("Residuals", "Measured minus simulated pressure and its autocorrelation; inside the grey band an "
                "autocorrelation cannot be told from that of independent noise.", drawing.residuals_figure(cohort)),
    ]  # fmt: skip
    if any("selection" in tree.children for tree in cohort.trees):
        blocks.append(Fold("Model selection, animal by animal", [selection_table(cohort)]))
    return Section("models", "Calibrated models", blocks)


def groups_section(cohort: Cohort, found: Mapping[str, Comparison], written: dict[str, str]) -> Section:
    """The groups compared."""
    blocks: list[Block] = []
    measured = importance(cohort.table, "measured", {name: name for name in INDICES})
    modeled = pd.concat([importance(cohort.table, wall, _PARAMETERS) for wall in cohort.walls] or [pd.DataFrame()])
    if len(measured) or len(modeled):
        blocks.append(
            Drawing("ParAll_change", f"Importance index η (eq. 20) of the measured indices and of the models' "
                    f"quantities, relative to {next(iter(cohort.groups))}: 1 is an increase by 100 %, -1 a fall to "
                    "zero. Stiffness: β of the linear, p₁/γ of the tangent wall. Linear wall hatched.",
                    drawing.importance_figure(cohort, measured, modeled))
        )  # fmt: skip
    else:
        blocks.append(Paragraph("There is one group; importance indices and tests need two."))
    for source, one in found.items():
        blocks += _compared(one, source, written)
    blocks.append(Fold("Every quantity of every source", [group_tables.groups(cohort)]))
    return Section("groups", "Groups", blocks)


def animals_section(cohort: Cohort, written: dict[str, str]) -> Section:
    """Every animal: what must be considered, its beats, its fit, its values with intervals."""
    blocks: list[Block] = []
    for place, tree in enumerate(cohort.trees, start=1):
        group, notes = str(tree.attrs["group"]), words.notes(tree)
        inner: list[Block] = [Notice("To be considered", notes)] if notes else []
        if "beats" in tree.children and "trace_pressure" in data_of(tree, "beats").data_vars:
            inner.append(Drawing(f"beats-{place}", _beats_caption(tree), drawing.beats_figure(tree)))
        if wall_laws(tree):
            inner.append(Drawing(f"fit-{place}", "Measured (black) and fitted pressure and flow at the inlet, and what "
                                 "is left.", fit_figure(tree, cohort.looks[group].color)))  # fmt: skip
            inner.append(model_tables.intervals(tree, written))
        made = ", synthetic" if words.is_synthetic(tree) else ""
        said = f", {len(notes)} {'note' if len(notes) == 1 else 'notes'}" if notes else ""
        blocks.append(Fold(f"{tree.attrs['animal']} ({group}{made}{said})", inner))
    return Section("animals", "Every animal", blocks)


def _compared(one: Comparison, source: str, written: dict[str, str]) -> list[Block]:
    blocks: list[Block] = []
    if len(one.contrasts):
        blocks.append(Heading("Measured indices" if source == "measured" else f"{source.capitalize()} wall"))
        blocks.append(group_tables.contrasts(one, source, written))
        pairs = one.contrasts[["reference", "other"]].drop_duplicates()
        if len(pairs) == 1:
            known = one.contrasts.assign(quantity=[written.get(c.split(" [")[0], c) for c in one.contrasts["quantity"]])
            blocks.append(Drawing(f"Ratios-{source}", "Ratio of geometric means with its 95 % interval (Welch, on "
                                  "logarithms).", drawing.ratios_figure(known)))  # fmt: skip
    if len(one.all_groups):
        blocks.append(group_tables.all_groups(one, source))
    if len(one.without_one):
        left_out = group_tables.without_one(one, source, written)
        blocks.append(Fold("One animal left out", [left_out]))
    if one.left_out:
        why = [f"{column_label(what)}: {reason}" for what, reason in one.left_out.items()]
        blocks.append(Notice(f"Not compared ({source})", why))
    return blocks


def _beats_caption(tree) -> str:  # type: ignore[no-untyped-def]
    beats = data_of(tree, "beats")
    kept = int(beats["kept"].sum())
    reasons = pd.Series([str(reason).split(":")[0] for reason in beats["reason"].values if reason])
    rejected = "; ".join(f"{count} rejected: {reason}" for reason, count in reasons.value_counts().items())
    return (
        f"{beats.sizes['beat']} beats detected, {kept} averaged{f'; {rejected}' if rejected else ''}. Above: recorded "
        "signals, triangles at detected beats; below: the averaged cycle."
    )


def _box_columns(cohort: Cohort, written: Mapping[str, str]) -> dict[str, str]:
    return _labelled(cohort, _BOXES, written)


def _labelled(cohort: Cohort, names: tuple[str, ...], written: Mapping[str, str]) -> dict[str, str]:
    found = {}
    for name in names:
        label = column(cohort.table, name)
        there = cohort.table[cohort.table["source"].isin(cohort.walls)]
        if label and there[label].notna().any():
            unit = column_label(label).partition(" [")[2]
            found[label] = f"{written.get(name, name)} [{unit}" if unit else f"{written.get(name, name)} [1]"
    return found
