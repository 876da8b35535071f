"""The methods paragraph of the report: what was solved and with which settings, read from the fit itself."""

from collections.abc import Sequence
from dataclasses import asdict

from vasowave.blood import boundary_layer
from vasowave.calibration.result import Fit
from vasowave.report.summary import number

_LAWS = {
    "linear": "linear elastic, p = β(√(A/A₀) − 1) (eq. 3)",
    "tangent": "stiffening, p = p₁ tan(π/γ (A/A₀ − 1)) (eq. 4)",
}


def methods_sentences(fits: Sequence[Fit]) -> list[str]:
    """Return the paragraphs on the model, the estimation and the numerics."""
    return [_model(fits), _estimation(fits), _numerics()]


def numerics_rows(fits: Sequence[Fit]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return header and rows of the simulations' settings and checks, one column per wall law."""
    keys = list(dict.fromkeys(key for fit in fits for key in fit.simulation.attrs))
    header = ("setting", *(f"{fit.wall} wall" for fit in fits))
    rows = [(str(key).replace("_", " "), *(number(fit.simulation.attrs.get(key)) for fit in fits)) for key in keys]
    return header, rows


def _model(fits: Sequence[Fit]) -> str:
    network, blood, period = fits[0].model.network, fits[0].model.blood, fits[0].recording.period
    friction = asdict(blood.friction)  # type: ignore[call-overload]
    settings = ", ".join(f"{key} {'local' if value is None else value}" for key, value in friction.items())
    settings = settings.replace("_", " ")
    laws = "; ".join(f"{fit.wall}: {_LAWS.get(fit.wall, fit.wall)}" for fit in fits)
    return (
        f"One-dimensional flow in a network of {len(network)} vessels ({len(network.terminals)} terminals, total "
        f"length {number(float(network.length.sum()))} cm). Blood: density {number(blood.density, 4)} g/ml, kinematic "
        f"viscosity {number(blood.viscosity)} cm²/s, friction {type(blood.friction).__name__} ({settings}), "
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
        "C = c1·C⁰ in all vascular beds. Standard errors and correlations come from the Jacobian at the optimum "
        "and take the residuals as independent; residuals of smooth waveforms are not, so the errors are lower limits."
    )


def _numerics() -> str:
    return (
        "The equations were integrated by a two-step Lax–Wendroff scheme with characteristic junctions and outlets, "
        "until the cycle repeated itself; the table gives the settings and what was reached. Units: cm, s, ml, mmHg."
    )
