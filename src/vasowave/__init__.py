"""vasowave: from one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model."""

from importlib import import_module
from typing import Any

_HOMES = {
    "Blood": "blood",
    "BoundaryLayer": "blood",
    "Poiseuille": "blood",
    "PowerLaw": "blood",
    "Fit": "calibration",
    "Search": "calibration",
    "calibrate": "calibration",
    "ImpedanceSpectrum": "outlets",
    "Inflow": "recording",
    "LinearWall": "walls",
    "Model": "model",
    "Network": "network",
    "Nominal": "nominal",
    "Numerics": "solver",
    "Recording": "recording",
    "TangentWall": "walls",
    "Windkessel": "outlets",
    "compare_models": "selection",
    "compliance": "analysis",
    "estimate_nominal": "nominal",
    "impedance": "analysis",
    "read_network": "network",
    "read_recording": "recording",
    "simulate": "solver",
    "wave_intensity": "analysis",
    "write_results": "results",
}

__all__ = [
    "Blood",
    "BoundaryLayer",
    "Fit",
    "ImpedanceSpectrum",
    "Inflow",
    "LinearWall",
    "Model",
    "Network",
    "Nominal",
    "Numerics",
    "Poiseuille",
    "PowerLaw",
    "Recording",
    "Search",
    "TangentWall",
    "Windkessel",
    "calibrate",
    "compare_models",
    "compliance",
    "estimate_nominal",
    "impedance",
    "read_network",
    "read_recording",
    "simulate",
    "wave_intensity",
    "write_results",
]


def __getattr__(name: str) -> Any:
    """Load what is asked for when it is asked for, so that importing the package costs nothing."""
    if name not in _HOMES:
        raise AttributeError(f"module 'vasowave' has no attribute '{name}'; it has: {', '.join(__all__)}")
    return getattr(import_module(f"vasowave.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)
