"""The published tables, their networks, and animals and lungs that the package makes itself."""

from vasowave.datasets.published import control_network, hypertensive_network, published_table
from vasowave.datasets.virtual import virtual_mouse

__all__ = ["control_network", "hypertensive_network", "published_table", "virtual_mouse"]
