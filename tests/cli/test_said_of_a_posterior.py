"""The table of a posterior at the terminal, to the letter."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from made_posterior import made_posterior
from vasowave.base import OTHER
from vasowave.cli import fit


@pytest.mark.parametrize("k_hat", [0.31, 0.93])
def test_columns_stand_below_each_other_and_a_sampling_that_failed_is_not_to_be_believed(capsys, k_hat):
    table = pd.DataFrame(
        {
            "median": [57.1234, 0.5], "interval_low": [41.26, 0.31], "interval_high": [81.94, 0.87],
            "prior_low": [8.1, 0.12], "prior_high": [404.0, np.inf], "unit": ["mmHg", "1"],
        },
        index=["beta", "r1"],
    )  # fmt: skip
    made = made_posterior("linear", -12.345, 57.0)
    diagnostics = made.diagnostics._replace(k_hat=k_hat, even=0.1)
    notes = (OTHER(text="the wall is stiff"),)
    fit._print_posterior(replace(made, summary=table, diagnostics=diagnostics, findings=notes))
    said = capsys.readouterr().out
    assert said.splitlines()[:3] == [
        "      median  95 % interval   prior 95 %  unit",
        "beta   57.12   [41.3, 81.9]   [8.1, 404]  mmHg",
        "r1       0.5   [0.31, 0.87]  [0.12, inf]",
    ]
    trusted = "The sampling succeeded" if k_hat < 0.7 else "Do not believe these numbers"
    assert " ".join(said.split()).endswith(
        f"{trusted}: Pareto k {k_hat}, 700 of 1000 draws effective, 1000 simulations, 16 harmonics compared, "
        "ln evidence -12.35 ± 0.10 note: the wall is stiff"
    )
