"""The table of what the posteriors of one animal say about its wall laws."""

import xarray as xr

from vasowave.report.blocks import Table
from vasowave.report.wording import number


def laws_by_posterior(data: xr.Dataset) -> Table:
    """Return evidence and weight of every law, and how well it foretells each block of harmonics from the others."""
    from vasowave.inference.reweighting import UNTRUSTED  # loads the compiler, which few reports need

    blocks = [str(block) for block in data["block"].values]
    rows = []
    for wall in data["wall"].values:
        one = data.sel(wall=wall)
        evidence = f"{float(one['log_evidence']):.1f} ± {float(one['log_evidence_error']):.1f}"
        foretold = zip(one["left_out"].values, one["left_out_k_hat"].values, strict=True)
        cells = [f"{value:.1f}{'?' if k > UNTRUSTED else ''}" for value, k in foretold]
        rows.append((str(wall), evidence, number(float(one["weight"]), 2), *cells))
    header = ("wall law", "log evidence", "probability", *(f"harmonic {block}" for block in blocks))
    note = (
        f"{data.attrs['said']} Evidence: the probability density of the measured harmonics, everything unknown "
        "integrated out; probability: of the law, if all were as likely before. By harmonic: the log density of these "
        "harmonics given all others, larger is better; ?: the harmonics decide alone, and the number is rough (Pareto "
        f"k above {UNTRUSTED}). What is not among the unknowns, such as taper, can look like another wall."
    )
    return Table("", "Wall laws by their posteriors", header, rows, note)
