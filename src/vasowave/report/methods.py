"""The methods paragraph of the report: what was solved and with which settings, read from the fit itself."""

from collections.abc import Sequence
from dataclasses import asdict

from vasowave.blood import boundary_layer
from vasowave.calibration.result import Fit
from vasowave.report.wording import friction_words, number

_SETTINGS = {
    "period": ("period", "s"),
    "cycles": ("simulated cycles", ""),
    "change": ("largest change over the last cycle", "mmHg"),
    "tolerance": ("change that counts as periodic", "mmHg"),
    "converged": ("periodic", ""),
    "courant": ("largest Courant number", ""),
    "steps_per_cycle": ("time steps per cycle", ""),
    "cell_size": ("longest cell", "cm"),
    "volume_error": ("volume out of balance over a cycle, relative", ""),
}
_LAWS = {
    "linear": "linear elastic, p = β(√(A/A₀) − 1) (eq. 3)",
    "tangent": "stiffening, p = p₁ tan(π/γ (A/A₀ − 1)) (eq. 4)",
}


def methods_sentences(fits: Sequence[Fit]) -> list[str]:
    """Return the paragraphs on the model, the estimation and the numerics."""
    return [_model(fits), _estimation(fits), _numerics(fits)]


def numerics_rows(fits: Sequence[Fit]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return header and rows of the simulations' settings and checks, one column per wall law."""
    header = ("setting", "unit", *(f"{fit.wall} wall" for fit in fits))
    rows = []
    for key in dict.fromkeys(str(key) for fit in fits for key in fit.simulation.attrs if key != "wall"):
        values = [fit.simulation.attrs.get(key) for fit in fits]
        cells = ["yes" if value else "no" for value in values] if key == "converged" else map(number, values)
        rows.append((*_SETTINGS.get(key, (key.replace("_", " "), "")), *cells))
    return header, rows


def _model(fits: Sequence[Fit]) -> str:
    network, blood, period = fits[0].model.network, fits[0].model.blood, fits[0].recording.period
    friction = friction_words(type(blood.friction).__name__, asdict(blood.friction))  # type: ignore[call-overload]
    laws = "; ".join(f"{fit.wall}: {_LAWS.get(fit.wall, fit.wall)}" for fit in fits)
    return (
        f"One-dimensional flow in a network of {len(network)} vessels ({len(network.terminals)} terminals, total "
        f"length {number(float(network.length.sum()))} cm). Blood: density {number(blood.density, 4)} g/ml, kinematic "
        f"viscosity {number(blood.viscosity)} cm²/s, friction of {friction}, "
        f"boundary layer {number(boundary_layer(blood.viscosity, period))} cm. Wall laws: {laws}. "
        "Every terminal vessel ends in a three-element Windkessel (eq. 7); the measured flow is the inflow."
    )


def _estimation(fits: Sequence[Fit]) -> str:
    free = "; ".join(
        f"{fit.wall}: {', '.join(fit.parameters.index[fit.parameters['free'].astype(bool)])}" for fit in fits
    )
    network = fits[0].model.network
    return (
        "Nominal parameters follow from the recording (eqs. 8 to 13). The sum S of squared differences between "
        f"measured and simulated waveforms at the inlet of vessel {network.name[network.root]} "
        f"(eq. 14) was minimized from several starts over the free parameters ({free}); R1 = r1·R1⁰, R2 = r2·R2⁰, "
        "C = c1·C⁰ in all vascular beds. Standard errors and correlations come from the Jacobian at the optimum. The "
        "residuals of a fit are smooth, not independent: an error that takes them as independent is a lower limit"
        f"{_correlated(fits)}."
    )


def _correlated(fits: Sequence[Fit]) -> str:
    known = all("standard_error_correlated" in fit.parameters for fit in fits)
    return "; the correlated one, used in the summary, allows for it" if known else ""


def _numerics(fits: Sequence[Fit]) -> str:
    periodic = all(fit.simulation.attrs.get("converged") for fit in fits)
    end = "until the cycle repeated itself" if periodic else "for a given number of cycles, not all of them periodic"
    return (
        "The equations were integrated by a two-step Lax–Wendroff scheme with characteristic junctions and outlets, "
        f"{end}; the table gives the settings and what was reached. Units: cm, s, ml, mmHg."
    )
