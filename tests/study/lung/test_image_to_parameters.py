"""The whole way by commands alone: a scan and a recording in, calibrated parameters out."""

import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

from extract_command import run
from phantom import embed, render, write_dicom_series
from vasowave.base import VasowaveWarning
from vasowave.cli import app
from vasowave.lung import match, written
from vasowave.pulse.examples import TRUTH, control_network, virtual_mouse
from vasowave.pulse.network import write_network
from vasowave.pulse.network_formats import read_network
from vasowave.study.results import read_results


def fitted(network, recording, output):
    """Run `vasowave fit` and return (calibration, quantities) of its stored result."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)
        arguments = ["fit", network, recording, "-o", output, "--walls", "linear", "--starts", "2", "--no-pdf"]
        result = CliRunner().invoke(app, list(map(str, arguments)))
    assert result.exit_code == 0, result.output + repr(result.exception)
    (result,) = read_results(output).in_order()
    return result.laws["linear"].calibration, result.laws["linear"].quantities


@pytest.mark.parametrize(
    "seed", [pytest.param(2101, marks=pytest.mark.validation), pytest.param(2102, marks=pytest.mark.weekly)]
)
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

    beta, reference = (float(one["value"].sel(parameter="beta")) for one in (own, given))
    # β ∝ r⁴ (eq. 9); a vessel counts for it by the share of the flow that its error concerns.
    mean_error = np.average(np.abs(error), weights=truth.flow_fraction)
    explained = 4 * mean_error
    noise = 3 * float(own["standard_error_correlated"].sel(parameter="beta")) / beta
    R_T, a, rmse = (float(own_fit[name]) for name in ("R_T", "a", "RMSE"))
    print(
        f"radius error {100 * np.median(np.abs(error)):.2f} % median, {100 * mean_error:.2f} % by flow; beta "
        f"{beta:.2f} (true network {reference:.2f}, truth {TRUTH['beta']}), explained {100 * explained:.1f} + noise "
        f"{100 * noise:.1f} %; R_T {R_T:.2f} ({TRUTH['R_T']}), a {a:.4f} "
        f"({TRUTH['a']}), RMSE {rmse:.3f}; notes {notes}"
    )
    assert abs(beta / reference - 1) < explained
    assert abs(beta / TRUTH["beta"] - 1) < explained + noise
    assert pytest.approx(TRUTH["R_T"], rel=0.02) == R_T
    assert a == pytest.approx(float(given_fit["a"]), abs=0.01)
    assert rmse < 1.2 * float(given_fit["RMSE"])
