"""From a micro-CT volume to a vessel network: read, lumen, axes, measure, witness, revise, exchange."""

from importlib import import_module
from typing import Any

_HOMES = {
    "Extraction": "extraction",
    "Options": "options",
    "Overview": "overview",
    "Volume": "read.volume",
    "extract": "extraction",
    "look": "overview",
    "read_volume": "read.files",
    "write_volume": "read.itk",
}

__all__ = ["Extraction", "Options", "Overview", "Volume", "extract", "look", "read_volume", "write_volume"]


def __getattr__(name: str) -> Any:
    """Load what is asked for when it is asked for: imaging is heavy, the rest of the package is not."""
    if name not in _HOMES:
        raise AttributeError(f"module 'vasowave.imaging' has no attribute '{name}'")
    return getattr(import_module(f"vasowave.imaging.{_HOMES[name]}"), name)
