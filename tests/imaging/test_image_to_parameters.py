"""The whole way by commands alone: a scan and a recording in, calibrated parameters out."""

import warnings

import numpy as np
import pandas as pd
import pytest
from made_phantom import run
from typer.testing import CliRunner

from vasowave.cli import app
from vasowave.datasets import control_network
from vasowave.datasets.phantom import embed, render, write_dicom_series
from vasowave.datasets.virtual import TRUTH, virtual_mouse
from vasowave.errors import VasowaveWarning
from vasowave.imaging.matching import match
from vasowave.imaging.places import written
from vasowave.network import read_network, write_network


def fitted(network, recording, output):
    """Run `vasowave fit` and return (table of parameters, table of the fit)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        arguments = ["fit", network, recording, "-o", output, "--wall", "linear", "--starts", "2"]
        result = CliRunner().invoke(app, list(map(str, arguments)))
    assert result.exit_code == 0, result.output + repr(result.exception)
    return pd.read_csv(output / "parameters.csv").set_index("parameter"), pd.read_csv(output / "fits.csv").iloc[0]


@pytest.mark.validation
@pytest.mark.parametrize("seed", [2101, 2102])
def test_a_scan_and_a_recording_give_back_the_parameters_within_what_radius_errors_explain(seed, tmp_path):
    truth, mouse = control_network(), virtual_mouse()
    rng = np.random.default_rng(seed)
    embedding = embed(truth, rng)
    write_dicom_series(render(embedding, 300, 2.5 / 300, rng), tmp_path / "dicom")
    outlets = ["x [cm],y [cm],z [cm]", *(written(embedding.lines[row][-1]) for row in truth.terminals)]
    (tmp_path / "outlets.csv").write_text("\n".join(outlets) + "\n")
    places = ("--root", written(embedding.cannula[0]), "--outlets", tmp_path / "outlets.csv")
    result, notes = run(tmp_path / "dicom", "-o", tmp_path / "network", *places)
    assert result.exit_code == 0, repr(result.exception)

    found = read_network(tmp_path / "network" / "network.csv")
    pairs = match(truth, found)
    assert len(found) == len(pairs) == 21
    error = found.radius[[pairs[row] for row in range(21)]] / truth.radius - 1

    columns = np.column_stack([mouse.time, mouse.pressure, mouse.flow])
    np.savetxt(tmp_path / "cycle.csv", columns, fmt="%.17g", delimiter=",", comments="",
               header="time [s],pressure [mmHg],flow [ml/s]")  # fmt: skip
    write_network(truth, tmp_path / "truth.csv")
    given, given_fit = fitted(tmp_path / "truth.csv", tmp_path / "cycle.csv", tmp_path / "fit-truth")
    own, own_fit = fitted(tmp_path / "network" / "network.csv", tmp_path / "cycle.csv", tmp_path / "fit")

    beta, reference = own["value"]["beta"], given["value"]["beta"]
    # β ∝ r⁴ (eq. 9); a vessel counts for it by the share of the flow that its error concerns.
    mean_error = np.average(np.abs(error), weights=truth.flow_fraction)
    explained = 4 * mean_error
    noise = 3 * own["standard_error_correlated"]["beta"] / beta
    print(
        f"radius error {100 * np.median(np.abs(error)):.2f} % median, {100 * mean_error:.2f} % by flow; beta "
        f"{beta:.2f} (true network {reference:.2f}, truth {TRUTH['beta']}), explained {100 * explained:.1f} + noise "
        f"{100 * noise:.1f} %; R_T {own_fit['R_T [mmHg s/ml]']:.2f} ({TRUTH['R_T']}), a {own_fit['a [1]']:.4f} "
        f"({TRUTH['a']}), RMSE {own_fit['RMSE [mmHg]']:.3f}; notes {notes}"
    )
    assert abs(beta / reference - 1) < explained
    assert abs(beta / TRUTH["beta"] - 1) < explained + noise
    assert own_fit["R_T [mmHg s/ml]"] == pytest.approx(TRUTH["R_T"], rel=0.02)
    assert own_fit["a [1]"] == pytest.approx(given_fit["a [1]"], abs=0.01)
    assert own_fit["RMSE [mmHg]"] < 1.2 * given_fit["RMSE [mmHg]"]
